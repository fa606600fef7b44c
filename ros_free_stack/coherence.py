"""Temporal and spatial coherence of a human motion between its five body parts.

Source: ParTY, supplement C, equations S1 to S10, with its parameters for 20 frames a second. Two readings are ours:
S10 is averaged over its fifteen terms, so that 1 is the maximum as the paper's tables require, and distances are in
leg lengths, so that bodies of any size compare with one reference.

What the equations give is not what the paper prints for captured motion (0.96 and 0.99). 225 captured clips of 5 s
from the CMU database score 0.37 in time (5th to 95th percentile 0.23 to 0.58) and 0.73 in space (0.54 to 0.85);
bodies put together from parts of different clips score 0.18 and 0.67, and five parts that move in unison score
highest of all. Compare scores with those of captured motion and with nothing else.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import Final

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import FPS, INDEX, PARTS

PAIRS: Final = tuple(combinations(PARTS, 2))
"""The ten pairs of parts, in the order of every array of distances."""

_ENDS: Final = ("left_wrist", "right_wrist", "left_foot", "right_foot", "head")
_EPSILON: Final = 1e-8


@dataclass(frozen=True)
class SpatialReference:
    """Mean and standard deviation of natural body geometry: ten distances in leg lengths, five angles in rad."""

    mean: tuple[float, ...]
    std: tuple[float, ...]


# fmt: off
CMU_REFERENCE: Final = SpatialReference(
    mean=(0.3951, 0.9934, 1.0331, 0.2473, 1.0331, 0.9934, 0.2473, 0.3493, 0.9626, 0.9626,
          2.0758, 2.0758, 2.7365, 2.7365, 0.0945),
    std=(0.1095, 0.1631, 0.1580, 0.0858, 0.1580, 0.1631, 0.0858, 0.1264, 0.1243, 0.1243,
         0.8047, 0.8047, 0.2979, 0.2979, 0.0574),
)
# fmt: on
"""`fit_reference` over every frame of 179 captured takes of the CMU database (28 minutes) and their reflections."""


def part_speeds(joints: Floats) -> Floats:
    """(T-1, 5) root-mean-square displacement of each part's joints between frames (S1).

    Args:
        joints: (T, 22, 3) m.
    """
    squared = (np.diff(joints, axis=0) ** 2).sum(axis=-1)
    return np.stack([np.sqrt(squared[:, list(part)].mean(axis=1)) for part in PARTS.values()], axis=1)


def temporal_coherence(
    joints: Floats,
    *,
    window: int = 20,
    max_lag: int = 15,
    sigma: float = 0.1,
    kappa: float = 5.0,
    still: float = 0.0,
) -> float:
    """Mean lag-penalised correlation of the parts' speeds over windows and pairs (S2 to S6), 0 to 1.

    Args:
        joints: (T, 22, 3) m at 20 fps.
        window: frames a window; windows overlap by half.
        max_lag: greatest lag in frames.
        sigma: temperature of the weights over lags.
        kappa: frames by which lag is penalised.
        still: leave out pairs with a part whose speed varies by less than this many leg lengths a second within a
            window: its normalised speed is mere noise. 0 leaves none out, as in the paper.

    Returns:
        The score, or 1 where every pair is left out.
    """
    speeds = part_speeds(joints)
    length = min(window, len(speeds))
    if length < 2:
        return 1.0
    windows = sliding_window_view(speeds, length, axis=0)[:: max(1, window // 2)]  # (W, 5, L)
    moving = np.ptp(windows, axis=-1) >= still * leg_length(joints) / FPS
    scores = _pair_scores(windows, min(max_lag, length - 1), sigma, kappa)
    counted = np.stack([moving[:, g] & moving[:, h] for g, h in _pair_indices()], axis=1)
    return float(scores[counted].mean()) if counted.any() else 1.0


def _pair_indices() -> tuple[tuple[int, int], ...]:
    return tuple(combinations(range(len(PARTS)), 2))


def _pair_scores(windows: Floats, max_lag: int, sigma: float, kappa: float) -> Floats:
    """(W, 10) scores of S5 from windows (W, 5, L) of speeds."""
    length = windows.shape[-1]
    deviation = windows - windows.mean(axis=-1, keepdims=True)
    normal = deviation / (deviation.std(axis=-1, keepdims=True) + _EPSILON)
    energy = np.sqrt((normal**2).sum(axis=-1))
    first, second = np.array(_pair_indices()).T
    scale = energy[:, first] * energy[:, second] + _EPSILON
    lags = np.arange(-max_lag, max_lag + 1)
    correlation = np.stack(
        [
            np.einsum(
                "wpt,wpt->wp",
                normal[:, first, max(0, -lag) : length - max(0, lag)],
                normal[:, second, max(0, lag) : length + min(0, lag)],
            )
            / scale
            for lag in lags
        ]
    )  # (lags, W, 10), S3
    weight = np.exp((correlation - correlation.max(axis=0)) / sigma)
    weight /= weight.sum(axis=0)
    mean = (weight * correlation).sum(axis=0)
    mean_lag = (weight * np.abs(lags)[:, None, None]).sum(axis=0)
    return np.maximum(0.0, mean) * np.exp(-mean_lag / kappa)


def leg_length(joints: Floats) -> float:
    """Median length of thigh and shank together, in m."""
    legs = [("left_hip", "left_knee", "left_ankle"), ("right_hip", "right_knee", "right_ankle")]
    bones = [(a, b) for hip, knee, ankle in legs for a, b in ((hip, knee), (knee, ankle))]
    lengths = sum(np.linalg.norm(joints[:, INDEX[a]] - joints[:, INDEX[b]], axis=-1) for a, b in bones)
    return float(np.median(lengths)) / 2


def part_geometry(joints: Floats) -> Floats:
    """(T, 15) distances between the parts' centroids in leg lengths, then the parts' angles to the trunk (S7, S8)."""
    centroid = {name: joints[:, list(part)].mean(axis=1) for name, part in PARTS.items()}
    distances = [np.linalg.norm(centroid[g] - centroid[h], axis=-1) for g, h in PAIRS]
    trunk = _unit(joints[:, INDEX["neck"]] - joints[:, INDEX["pelvis"]])
    directions = [_unit(joints[:, INDEX[end]] - centroid[name]) for name, end in zip(PARTS, _ENDS, strict=True)]
    angles = [np.arccos(np.clip((direction * trunk).sum(axis=-1), -1, 1)) for direction in directions]
    return np.stack([*(distance / leg_length(joints) for distance in distances), *angles], axis=1)


def _unit(vectors: Floats) -> Floats:
    return vectors / (np.linalg.norm(vectors, axis=-1, keepdims=True) + _EPSILON)


def fit_reference(motions: Iterable[Floats]) -> SpatialReference:
    """Statistics of S9 over every frame of some motions, each (T, 22, 3)."""
    geometry = np.concatenate([part_geometry(joints) for joints in motions])
    return SpatialReference(tuple(geometry.mean(axis=0).tolist()), tuple(geometry.std(axis=0).tolist()))


def spatial_coherence(joints: Floats, reference: SpatialReference = CMU_REFERENCE, *, beta: float = 1.5) -> float:
    """Mean closeness of the body's geometry to natural geometry (S9, S10 as a mean), 0 to 1.

    Args:
        joints: (T, 22, 3) m.
        reference: natural geometry.
        beta: bandwidth in standard deviations.
    """
    return float(spatial_coherence_by_frame(joints, reference, beta=beta).mean())


def spatial_coherence_by_frame(
    joints: Floats, reference: SpatialReference = CMU_REFERENCE, *, beta: float = 1.5
) -> Floats:
    """(T,) the same for each frame."""
    score = (part_geometry(joints) - np.array(reference.mean)) / (np.array(reference.std) + _EPSILON)
    return np.exp(-(score**2) / beta**2).mean(axis=1)
