"""Training of the motion tokenizer: windows of features, and what is left of them."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from generator.config import Training
from generator.datasets.dataset import Clip, MotionDataset
from generator.models.segmo.config import TOKEN_FRAMES, TokenizerConfig, TokenizerLosses
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.training.reconstruction import (
    COMMITMENT_WEIGHT,
    joint_error,
    published_losses,
    reconstruction_losses,
)
from generator.training.stages import StageJob
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import CHANNELS

VALIDATION_CLIPS = 200
BATCH_CLIPS = 64


def from_job(job: StageJob) -> "TokenizerObjective":
    """The objective of a stage of training."""
    config = replace(job.model(TokenizerConfig), features=job.dataset.layout.width)
    return TokenizerObjective(job.dataset, config, job.training, job.objective(TokenizerLosses), job.seed)


class TokenizerObjective:
    """Reconstruction of random windows of the training split.

    Raises:
        InvalidOption: no clip is as long as a window.
    """

    name = "tokenizer"

    def __init__(
        self, dataset: MotionDataset, config: TokenizerConfig, training: Training, losses: TokenizerLosses, seed: int
    ) -> None:
        self.config = config
        self.facts = {
            "clips": len(dataset.split("train")),
            "training": asdict(training),
            "objective": asdict(losses),
        }
        self.model: Any = MotionTokenizer(config, torch.from_numpy(dataset.mean), torch.from_numpy(dataset.std))
        self._dataset, self._batch, self._losses, self._seed = dataset, training.batch, losses, seed
        self._clips = [clip for clip in dataset.split("train") if clip.length >= losses.window]
        if not self._clips:
            raise InvalidOption("--dataset", f"no training clip has {losses.window} frames or more")
        chance = np.array([clip.weight * (clip.length - losses.window + 1) for clip in self._clips])
        self._chance = chance / chance.sum()
        self._held = dataset.split("val")[:VALIDATION_CLIPS] or self._clips[:VALIDATION_CLIPS]

    def loss(self, iteration: int) -> dict[str, Tensor]:
        target = self.model.standardise(self._windows(iteration).to(self.model.mean.device))
        found = self.model(target)
        losses = self._measured(self.model, found.features, target)
        losses["loss"] = losses["loss"] + COMMITMENT_WEIGHT * found.commitment
        return {**losses, "commitment": found.commitment}

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Losses on whole held-out clips, and the mean joint error in mm."""
        assert isinstance(model, MotionTokenizer)
        layout, sums = self._dataset.layout, dict[str, float]()
        for target, found in reconstructions(model, self._dataset, self._held):
            pair = model.standardise(found), model.standardise(target)
            losses = {**self._measured(model, *pair), "joints": joint_error(*pair, model.std, layout.skeleton)}
            for name, value in losses.items():
                sums[name] = sums.get(name, 0.0) + float(value) * len(target) / len(self._held)
        errors = channel_errors(model, self._dataset, self._held)
        root = {f"error_{name}": float(errors[i]) for i, name in enumerate(CHANNELS[:4])}
        return {
            **sums,
            "joints_mm": 1e3 * layout.unit_m * sums["joints"],
            "error_median": float(np.median(errors)),
            **root,
        }

    def _measured(self, model: MotionTokenizer, found: Tensor, target: Tensor) -> dict[str, Tensor]:
        if self._losses.losses == "published":
            return published_losses(found, target, self._dataset.layout.skeleton)
        return reconstruction_losses(found, target, model.mean, model.std, self._dataset.layout.skeleton)

    def _windows(self, iteration: int) -> Tensor:
        """(B, window, 263) features, drawn by the clips' weights and lengths."""
        rng = np.random.default_rng((self._seed, iteration))
        window = self._losses.window
        rows = []
        for index in rng.choice(len(self._clips), self._batch, p=self._chance):
            clip = self._clips[index]
            start = int(rng.integers(clip.length - window + 1))
            rows.append(self._dataset.features(clip)[start : start + window])
        return torch.from_numpy(np.stack(rows))


def batches_of_equal_length(clips: Sequence[Clip]) -> Iterator[list[int]]:
    """Indices of clips whose whole tokens are equally many, at most 64 at a time."""
    lengths = np.array([clip.length // TOKEN_FRAMES for clip in clips])
    for length in np.unique(lengths):
        rows = np.flatnonzero(lengths == length).tolist()
        for start in range(0, len(rows), BATCH_CLIPS):
            yield rows[start : start + BATCH_CLIPS]


def feature_batch(dataset: MotionDataset, clips: Sequence[Clip], device: torch.device) -> Tensor:
    """(B, T, 263) features of clips of equally many whole tokens, without the frames that fill none."""
    frames = clips[0].length // TOKEN_FRAMES * TOKEN_FRAMES
    return torch.from_numpy(np.stack([dataset.features(clip)[:frames] for clip in clips])).to(device)


def reconstructions(
    model: MotionTokenizer, dataset: MotionDataset, clips: Sequence[Clip]
) -> Iterator[tuple[Tensor, Tensor]]:
    """Batches of features (B, T, 263) and what is left of them after a trip through the tokens."""
    for rows in batches_of_equal_length(clips):
        target = feature_batch(dataset, [clips[row] for row in rows], model.mean.device)
        yield target, model.decode(model.encode(target))


def channel_errors(model: MotionTokenizer, dataset: MotionDataset, clips: Sequence[Clip]) -> np.ndarray:
    """(263,) mean squared error of each feature over the clips, divided by the feature's variance in training."""
    total, frames = torch.zeros(len(model.mean)), 0
    for target, found in reconstructions(model, dataset, clips):
        total += ((found - target) / model.std).square().sum((0, 1)).cpu()
        frames += target.shape[0] * target.shape[1]
    return (total / frames).numpy()
