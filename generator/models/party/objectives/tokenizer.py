"""Training of the tokenizer: windows of features, and what is left of them in each body."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.bodies import WHOLE
from generator.config import Training
from generator.datasets.dataset import Clip, MotionDataset
from generator.models.party.config import TokenizerConfig, TokenizerLosses
from generator.models.party.tokenizer import PartyTokenizer
from generator.training.reconstruction import channel_weights, joint_error, positions, reconstruction_losses
from generator.training.stages import StageJob
from ros_free_stack.errors import InvalidOption

VALIDATION_CLIPS = 200
BATCH_CLIPS = 50
VELOCITY_WEIGHT = 0.5


def from_job(job: StageJob) -> "TokenizerObjective":
    """The objective of a stage of training."""
    config = replace(job.model(TokenizerConfig), features=job.dataset.layout.width)
    objective = TokenizerObjective(job.dataset, config, job.training, job.objective(TokenizerLosses), job.seed)
    objective.facts["generator"] = job.generator.name
    return objective


class TokenizerObjective:
    """Reconstruction of random windows of the training split by every body's VQ-VAE.

    Raises:
        InvalidOption: the training window is not whole tokens of every body, or no clip is as long.
    """

    name = "tokenizer"

    def __init__(
        self, dataset: MotionDataset, config: TokenizerConfig, training: Training, losses: TokenizerLosses, seed: int
    ) -> None:
        for body in config.bodies:
            if losses.window % config.window_of(body):
                raise InvalidOption(
                    "tokenizer.objective.window",
                    f"must be a multiple of the {config.window_of(body)} frames of a token of {body}, "
                    f"found {losses.window}",
                )
        self.config = config
        self.facts: dict[str, Any] = {
            "clips": len(dataset.split("train")),
            "training": asdict(training),
            "objective": asdict(losses),
        }
        self.model: Any = PartyTokenizer(config, torch.from_numpy(dataset.mean), torch.from_numpy(dataset.std))
        self._dataset, self._batch, self._losses, self._seed = dataset, training.batch, losses, seed
        self._clips = [clip for clip in dataset.split("train") if clip.length >= losses.window]
        if not self._clips:
            raise InvalidOption("--dataset", f"no training clip has {losses.window} frames or more")
        chance = np.array([clip.weight * (clip.length - losses.window + 1) for clip in self._clips])
        self._chance = chance / chance.sum()
        self._held = (dataset.split("val") or tuple(self._clips))[:VALIDATION_CLIPS]

    def loss(self, iteration: int) -> dict[str, Tensor]:
        target = self.model.standardise(self._windows(iteration).to(self.model.mean.device))
        mask = torch.ones(target.shape[:2], dtype=torch.bool, device=target.device)
        total, found = target.new_zeros(()), dict[str, Tensor]()
        for name in self.config.bodies:
            body = self.model.body(name)
            through = body(target[..., list(body.channels)], mask)
            own = self._measured(name, through.features, target)
            loss = own.pop("loss") + self._losses.approximation * through.approximation
            total = total + loss
            found |= {name: loss, f"{name}_approximation": through.approximation}
            found |= {f"{name}_{key}": value for key, value in own.items()}
        return {"loss": total, **found}

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Losses on whole held-out clips, and the mean joint error in mm."""
        assert isinstance(model, PartyTokenizer)
        sums, layout = dict[str, float](), self._dataset.layout
        for target, found in reconstructions(model, self._dataset, self._held):
            losses = {}
            if self.config.holistic:
                losses = self._measured(WHOLE, found[WHOLE], target)
            for name in self.config.parts:
                losses[name] = self._measured(name, found[name], target)["loss"]
            losses["loss"] = sum((losses[name] for name in self.config.parts), losses.get("loss", torch.zeros(())))
            merged = torch.zeros_like(target)
            for name in (WHOLE,) if self.config.holistic else self.config.parts:
                merged[..., list(model.body(name).channels)] = found[name]
            losses["joints_mm"] = 1e3 * layout.unit_m * joint_error(merged, target, model.std, layout.skeleton)
            for name, value in losses.items():
                sums[name] = sums.get(name, 0.0) + float(value) * len(target) / len(self._held)
        return sums

    def _measured(self, body: str, found: Tensor, target: Tensor) -> dict[str, Tensor]:
        """Losses of a body's standardised features (B, T, C); "loss" is their sum."""
        model, skeleton = self.model, self._dataset.layout.skeleton
        own = list(model.body(body).channels)
        if self._losses.losses == "weighted" and body == WHOLE:
            return reconstruction_losses(found, target, model.mean, model.std, skeleton)
        target = target[..., own]
        if self._losses.losses == "weighted":
            weights = channel_weights(skeleton)[own].to(found.device)
            steps = functional.smooth_l1_loss(found.diff(dim=1), target.diff(dim=1), reduction="none")
            values = functional.smooth_l1_loss(found, target, reduction="none")
            return {"loss": (values * weights).mean() + VELOCITY_WEIGHT * (steps * weights).mean()}
        joints = range(len(model.mean))[positions(skeleton)]
        places = [place for place, channel in enumerate(own) if channel in joints]
        loss = functional.l1_loss(found, target)
        return {"loss": loss + functional.l1_loss(found[..., places], target[..., places]) if places else loss}

    def _windows(self, iteration: int) -> Tensor:
        """(B, window, F) features, drawn by the clips' weights and lengths."""
        rng = np.random.default_rng((self._seed, iteration))
        window = self._losses.window
        rows = []
        for index in rng.choice(len(self._clips), self._batch, p=self._chance):
            clip = self._clips[index]
            start = int(rng.integers(clip.length - window + 1))
            rows.append(self._dataset.features(clip)[start : start + window])
        return torch.from_numpy(np.stack(rows))


def batches_of_equal_length(clips: Sequence[Clip], unit: int) -> list[list[int]]:
    """Indices of clips of equally many whole tokens of so many frames, at most 50 at a time."""
    lengths = np.array([clip.length // unit for clip in clips])
    batches = []
    for length in np.unique(lengths[lengths > 0]):
        rows = np.flatnonzero(lengths == length).tolist()
        batches += [rows[start : start + BATCH_CLIPS] for start in range(0, len(rows), BATCH_CLIPS)]
    return batches


def whole_features(dataset: MotionDataset, clips: Sequence[Clip], unit: int) -> Tensor:
    """(B, T, F) features of clips of equally many whole tokens, without the frames that fill none."""
    frames = clips[0].length // unit * unit
    return torch.from_numpy(np.stack([dataset.features(clip)[:frames] for clip in clips]))


def reconstructions(
    model: PartyTokenizer, dataset: MotionDataset, clips: Sequence[Clip]
) -> Iterator[tuple[Tensor, dict[str, Tensor]]]:
    """Batches of standardised features (B, T, F), and what is left of them in each body (B, T, C)."""
    unit = model.config.unit
    for rows in batches_of_equal_length(clips, unit):
        features = whole_features(dataset, [clips[row] for row in rows], unit).to(model.mean.device)
        frames = torch.full((len(rows),), features.shape[1], device=features.device)
        tokens = model.encode(features, frames)
        found = {}
        for name in model.config.bodies:
            body = model.body(name)
            mask = torch.arange(tokens[name].shape[1], device=frames.device) * body.window < frames[:, None]
            found[name] = body.decode(body.values(tokens[name]), mask)[:, : features.shape[1]]
        yield model.standardise(features), found
