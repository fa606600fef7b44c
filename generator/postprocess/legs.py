"""Legs of a motion: bones, stances as spans of frames, and inverse kinematics of hip, knee and ankle."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from ros_free_stack.skeleton import INDEX

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SIDES: Final = ("left", "right")
HIPS, KNEES, ANKLES, BALLS = ([INDEX[f"{side}_{name}"] for side in SIDES] for name in ("hip", "knee", "ankle", "foot"))
REACH: Final = 0.998
"""Share of a leg's length that it may stretch to."""


def spans(stance: Bools) -> list[slice]:
    """Each run of frames in which a foot stands."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stance, [False]]).astype(int)))
    return [slice(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


@dataclass(frozen=True)
class Leg:
    """Measures of one leg in m: its bones, and how far the ankle of a flat foot lies above the ball."""

    thigh: float
    shank: float
    foot: float
    drop: float

    @classmethod
    def measure(cls, joints: Floats, planted: Bools, side: int) -> "Leg":
        """Of joints (T, 22, 3) and stances (T, 2)."""
        chain = [joints[:, joint[side]] for joint in (HIPS, KNEES, ANKLES, BALLS)]
        thigh, shank, foot = (float(np.median(np.linalg.norm(b - a, axis=1))) for a, b in pairwise(chain))
        drops = (joints[:, ANKLES, 2] - joints[:, BALLS, 2])[planted]
        return cls(thigh, shank, foot, min(float(np.percentile(drops, 30)), 0.9 * foot))


def missing_reach(joints: Floats, planted: Bools, feet: list[tuple[Floats, Floats]], legs: list[Leg]) -> Floats:
    """(T,) by how much the body has to be lower so that its legs reach their standing feet, m, smooth."""
    missing = np.zeros(len(joints))
    for side, (leg, (ankle, _)) in enumerate(zip(legs, feet, strict=True)):
        hip, own = joints[:, HIPS[side]], joints[:, ANKLES[side]]
        reach = np.maximum(REACH * (leg.thigh + leg.shank), np.linalg.norm(own - hip, axis=1))
        down = np.sqrt(np.maximum(reach**2 - ((ankle - hip)[:, :2] ** 2).sum(1), 0))
        missing = np.maximum(missing, np.where(planted[:, side], hip[:, 2] - ankle[:, 2] - down, 0))
    return np.asarray(gaussian_filter1d(maximum_filter1d(missing, 5), 1.0))


def solve_leg(joints: Floats, side: int, leg: Leg, ankle: Floats, ball: Floats) -> Floats:
    """Joints with one leg's ankle and ball at the wanted places, the knee bent where it was."""
    out = joints.copy()
    hip, knee, own = (joints[:, joint[side]] for joint in (HIPS, KNEES, ANKLES))
    across = joints[:, HIPS[0]] - joints[:, HIPS[1]]
    ahead = unit(np.stack([across[:, 1], -across[:, 0], np.zeros(len(across))], axis=1))
    pole = across_line(knee - hip, own - hip) + 0.01 * ahead  # a straight leg does not tell where its knee bends to
    line = ankle - hip
    far = np.linalg.norm(line, axis=1, keepdims=True)
    length = np.clip(far, abs(leg.thigh - leg.shank) + 0.02, 0.9999 * (leg.thigh + leg.shank))
    axis = line / np.maximum(far, 1e-9)
    along = (leg.thigh**2 - leg.shank**2 + length**2) / (2 * length)
    bend = np.sqrt(np.maximum(leg.thigh**2 - along**2, 0))
    out[:, KNEES[side]] = hip + along * axis + bend * unit(across_line(pole, axis))
    out[:, ANKLES[side]] = hip + length * axis
    out[:, BALLS[side]] = ball + out[:, ANKLES[side]] - ankle
    return out


def across_line(vectors: Floats, line: Floats) -> Floats:
    """The part of (T, 3) vectors at right angles to lines (T, 3)."""
    axis = unit(line)
    return vectors - (vectors * axis).sum(axis=1, keepdims=True) * axis


def unit(vectors: Floats) -> Floats:
    """Vectors (..., n) of length 1."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def smoothstep(share: Floats) -> Floats:
    """3 x^2 - 2 x^3, clipped outside of 0 to 1."""
    share = np.clip(share, 0, 1)
    return share * share * (3 - 2 * share)
