"""Training of the motion tokenizer: windows of features, weighted by channel so that the root's motion survives."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import Training
from generator.data.dataset import Clip, MotionDataset
from generator.models.segmo.config import TOKEN_FRAMES, TokenizerConfig
from generator.models.segmo.tokenizer import MotionTokenizer
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import CHANNELS, HUMANML3D
from ros_free_stack.skeleton import BONES

ROOT, YAW, HEIGHT = slice(0, 3), slice(0, 1), slice(3, 4)
POSITIONS, ROTATIONS, VELOCITIES = slice(4, 67), slice(67, 193), slice(193, 259)

CONTACTS = slice(259, 263)
FEET = [4 + 3 * (joint - 1) + axis for joint in HUMANML3D.feet for axis in range(3)]

LIMBS = [(parent - 1, child - 1) for parent, child in BONES if parent > 0]

VALIDATION_CLIPS = 200
BATCH_CLIPS = 64

VELOCITY_WEIGHT, JOINT_WEIGHT, BONE_WEIGHT, DRIFT_WEIGHT, FEET_WEIGHT = 0.5, 2.0, 0.3, 0.5, 3.0
COMMITMENT_WEIGHT = 0.02
STIFF = 0.1  # of its length; bones that hardly move are not blown up
PLANTED = 4.0  # how much more a planted foot's slip counts than a swinging one's


def channel_weights() -> Tensor:
    """(263,) loss weights of the standardised features, of mean 1.

    Three of 263 channels carry the whole path of the body; at equal weight their error drowns in the rest.
    Rotations are not used to draw the motion, velocities follow from the positions.
    """
    weights = torch.ones(len(CHANNELS))
    weights[ROOT], weights[HEIGHT] = 4.0, 2.0
    weights[ROTATIONS], weights[VELOCITIES] = 0.1, 0.15
    return weights / weights.mean()


def reconstruction_losses(found: Tensor, target: Tensor, mean: Tensor, std: Tensor) -> dict[str, Tensor]:
    """Losses between standardised features (B, T, 263).

    "features" and "velocity": smooth L1 of values and of their differences in time (MoMask); "joints": mean distance
    of joint positions in m; "drift": error of root yaw (rad) and path (m) summed up over time, which catches the
    small steady errors that add up to a wrong heading; "feet": error of the feet's steps over the ground in m a
    frame, planted ones above all, because root and pose may each be nearly right and the feet skate all the same;
    "bones": error of each bone's vector by how much that bone varies, because a nod or a shrug is all that head and
    collars do, and yet moves the joints by no more than the usual error of their places.
    """
    weights = channel_weights().to(found.device)
    features = (functional.smooth_l1_loss(found, target, reduction="none") * weights).mean()
    velocity = functional.smooth_l1_loss(found.diff(dim=1), target.diff(dim=1), reduction="none") * weights
    error = (found - target) * std
    places = error[..., POSITIONS].unflatten(-1, (-1, 3))
    joints = _length(places).mean()
    drift = error[..., ROOT].cumsum(1).abs().mean()
    bones = _bone_error(places, (target * std + mean)[..., POSITIONS].unflatten(-1, (-1, 3)))
    feet = _feet_error(found * std + mean, target * std + mean)
    total = features + VELOCITY_WEIGHT * velocity.mean() + JOINT_WEIGHT * joints + BONE_WEIGHT * bones
    total = total + DRIFT_WEIGHT * drift + FEET_WEIGHT * feet
    return {"loss": total, "features": features, "joints": joints, "bones": bones, "drift": drift, "feet": feet}


def foot_steps(features: Tensor) -> Tensor:
    """How the four foot joints move over the ground: (B, T, 263) in their own units to (B, T - 1, 4, 3) in m a frame.

    The root's step and the change of the joint's place around the root add up, as `features.decode` integrates them;
    the axes are left, up and forward of the later frame.
    """
    places = features[..., FEET].unflatten(-1, (-1, 3))
    turn = 2 * features[:, :-1, :1]  # the feature is half the yaw, backwards
    left, up, forward = places[:, :-1].unbind(-1)
    before = torch.stack(
        [turn.cos() * left + turn.sin() * forward, up, turn.cos() * forward - turn.sin() * left], dim=-1
    )
    root = functional.pad(features[:, :-1, None, 1:3], (0, 1))[..., (0, 2, 1)]
    return root + places[:, 1:] - before


def _feet_error(found: Tensor, target: Tensor) -> Tensor:
    error = _length(foot_steps(found) - foot_steps(target))
    return (error * (1 + PLANTED * target[:, :-1, CONTACTS])).mean()


def _bone_error(error: Tensor, places: Tensor) -> Tensor:
    """Mean over the bones of the error of their vector by how much it varies in the batch, from (B, T, 21, 3) in m."""
    parents, children = zip(*LIMBS, strict=True)
    wrong = _length(error[..., children, :] - error[..., parents, :])
    bones = (places[..., children, :] - places[..., parents, :]).flatten(0, 1)
    varies = (bones - bones.mean(0)).square().sum(-1).mean(0).sqrt()
    return (wrong / varies.maximum(STIFF * _length(bones).mean(0))).mean()


def _length(vectors: Tensor) -> Tensor:
    """Euclidean length of (..., 3), with a gradient at zero."""
    return (vectors.square().sum(-1) + 1e-8).sqrt()


class TokenizerObjective:
    """Reconstruction of random windows of the training split.

    Raises:
        InvalidOption: no clip is as long as a window.
    """

    name = "tokenizer"

    def __init__(self, dataset: MotionDataset, config: TokenizerConfig, training: Training, seed: int) -> None:
        self.config = config
        self.facts = {"clips": len(dataset.split("train")), "training": asdict(training)}
        self.model: Any = MotionTokenizer(config, torch.from_numpy(dataset.mean), torch.from_numpy(dataset.std))
        self._dataset, self._training, self._seed = dataset, training, seed
        self._clips = [clip for clip in dataset.split("train") if clip.length >= training.window]
        if not self._clips:
            raise InvalidOption("--dataset", f"no training clip has {training.window} frames or more")
        chance = np.array([clip.weight * (clip.length - training.window + 1) for clip in self._clips])
        self._chance = chance / chance.sum()
        self._held = dataset.split("val")[:VALIDATION_CLIPS] or self._clips[:VALIDATION_CLIPS]

    def loss(self, iteration: int) -> dict[str, Tensor]:
        target = self.model.standardise(self._windows(iteration).to(self.model.mean.device))
        found = self.model(target)
        losses = reconstruction_losses(found.features, target, self.model.mean, self.model.std)
        losses["loss"] = losses["loss"] + COMMITMENT_WEIGHT * found.commitment
        return {**losses, "commitment": found.commitment}

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Losses on whole held-out clips, and the mean joint error in mm."""
        assert isinstance(model, MotionTokenizer)
        sums: dict[str, float] = {}
        for target, found in reconstructions(model, self._dataset, self._held):
            losses = reconstruction_losses(model.standardise(found), model.standardise(target), model.mean, model.std)
            for name, value in losses.items():
                sums[name] = sums.get(name, 0.0) + float(value) * len(target) / len(self._held)
        errors = channel_errors(model, self._dataset, self._held)
        root = {f"error_{name}": float(errors[i]) for i, name in enumerate(CHANNELS[:4])}
        return {**sums, "joints_mm": 1e3 * sums["joints"], "error_median": float(np.median(errors)), **root}

    def _windows(self, iteration: int) -> Tensor:
        """(B, window, 263) features, drawn by the clips' weights and lengths."""
        rng = np.random.default_rng((self._seed, iteration))
        window = self._training.window
        rows = []
        for index in rng.choice(len(self._clips), self._training.batch, p=self._chance):
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
    total, frames = torch.zeros(len(CHANNELS)), 0
    for target, found in reconstructions(model, dataset, clips):
        total += ((found - target) / model.std).square().sum((0, 1)).cpu()
        frames += target.shape[0] * target.shape[1]
    return (total / frames).numpy()
