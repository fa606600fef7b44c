"""Foot-skate clean-up of decoded motion: standing feet stand still, and the body's path follows from them.

A decoder gets the poses right but not quite the path of the root, so that feet glide where they should stand. After
Kovar, Schreiner and Gleicher, "Footskate cleanup for motion capture editing" (SCA 2002): find when each foot is
planted, hold it at one place there, solve the legs by inverse kinematics, and fade every change out over the swing.
Before that the slip that both feet agree on is taken out of the root's path, which is where most of it comes from;
the legs then only have to make up for a rest.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.ndimage import binary_closing, binary_opening, gaussian_filter1d, maximum_filter1d

from ros_free_stack.skeleton import INDEX

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

SIDES: Final = ("left", "right")
HIPS, KNEES, ANKLES, BALLS = ([INDEX[f"{side}_{name}"] for side in SIDES] for name in ("hip", "knee", "ankle", "foot"))

LOW_M: Final = (0.015, 0.03)
"""A ball of the foot below the first height above its rest lands, above the second it has left the floor."""
CONTACT: Final = (0.6, 0.4)
"""The same for the predicted contact."""
HOVER_M: Final = 0.04
"""A body that floats by up to this much while a foot is predicted to be in contact is taken to stand on it."""
SHORTEST: Final = 3
"""Frames of the shortest stance; gaps of one frame in a stance are filled."""
LEVEL_M: Final = (0.0, 0.012)
"""A planted foot lies flat that has its ankle less than the first above its rest; above the second it keeps its roll.
A narrow range, because on a stretched leg the heel's last centimetre moves the knee by several."""
AIM_M: Final = (0.02, 0.05)
"""The same for the direction in which it points: once it is up on its toes it may turn."""
EDGE: Final = (0.008, 0.02, 3)
"""A first or last frame of a stance is no part of it while the ball is higher than this above its rest, or travels
farther than this to the next frame within (m); so many frames at most."""
FADE: Final = 4
"""Frames over which a change fades out after a stance and in before one."""
SMOOTHNESS: Final = 2.0
"""Weight of the change from frame to frame of the root's correction, against 1 for a standing foot's slip."""
TRUST: Final = (0.02, 0.2)
"""Weight of the root's own path where a foot stands and where none does."""
REACH: Final = 0.998
"""Share of a leg's length that it may stretch to."""


def lock_feet(joints: Floats, contacts: Floats, rest: float | None = None) -> Floats:
    """The motion with standing feet that stand still.

    Heading, trunk and arms keep their poses; the root's path and the legs change. Motion without contacts does not.

    Args:
        joints: (T, 22, 3) m, z up.
        contacts: (T, 4) predicted contacts in 0 to 1: left ankle, left ball, right ankle, right ball.
        rest: height of the ball of a standing foot, m; from the motion where not given.

    Returns:
        (T, 22, 3) with the lengths of thighs, shanks and feet constant.
    """
    rest = standing_height(joints) if rest is None else rest
    planted = find_stances(joints, contacts, rest)
    if not planted.any():
        return joints.copy()
    balls = joints[:, BALLS]
    roughly = balls + _root_correction(balls, planted, rest)[:, None]
    planted = _without_edges(planted, roughly, rest)
    moved = joints + _root_correction(balls, planted, rest)[:, None]
    legs = [_Leg.measure(moved, planted, side) for side in range(2)]
    feet = [_foot_path(moved, planted[:, side], rest, side, legs[side]) for side in range(2)]
    moved[..., 2] -= _missing_reach(moved, planted, feet, legs)[:, None]
    for side, (leg, (ankle, ball)) in enumerate(zip(legs, feet, strict=True)):
        moved = _solve_leg(moved, side, leg, ankle, ball)
    return moved


def standing_height(joints: Floats) -> float:
    """Height of the ball of a standing foot in a motion (T, 22, 3), m."""
    return float(np.percentile(joints[:, BALLS, 2].min(axis=1), 5))


def find_stances(joints: Floats, contacts: Floats, rest: float) -> Bools:
    """(T, 2) whether the left and the right foot stand: predicted in contact and low, with hysteresis.

    Args:
        joints: (T, 22, 3) m.
        contacts: (T, 4) as in `lock_feet`.
        rest: height of the ball of a standing foot, m.
    """
    chance = contacts[:, 1::2]
    height = joints[:, BALLS, 2] - rest
    lowest = np.where(chance > CONTACT[0], height, np.inf).min(axis=1)
    height = height - np.where(np.isfinite(lowest), np.clip(lowest, 0, HOVER_M), 0)[:, None]
    start = (height < LOW_M[0]) & (chance > CONTACT[0])
    hold = (height < LOW_M[1]) & (chance > CONTACT[1])
    return np.stack([_cleaned(_hysteresis(start[:, i], hold[:, i])) for i in range(2)], axis=1)


def _hysteresis(start: Bools, hold: Bools) -> Bools:
    """Every run of `hold` in which `start` is true somewhere."""
    run = np.cumsum(np.diff(hold, prepend=False))
    return hold & np.isin(run, run[start & hold])


def _cleaned(stance: Bools) -> Bools:
    """Stances without gaps of one frame and without those below `SHORTEST`."""
    padded = np.pad(stance, SHORTEST, mode="edge")
    closed = binary_closing(padded, np.ones(2, dtype=bool))
    return np.asarray(binary_opening(closed, np.ones(SHORTEST, dtype=bool)), dtype=bool)[SHORTEST:-SHORTEST]


def _spans(stance: Bools) -> list[slice]:
    edges = np.flatnonzero(np.diff(np.concatenate([[False], stance, [False]]).astype(int)))
    return [slice(int(start), int(stop)) for start, stop in edges.reshape(-1, 2)]


def _without_edges(planted: Bools, balls: Floats, rest: float) -> Bools:
    """Stances without the frames of touch-down and take-off in which the foot is on its way."""
    height, travel, most = EDGE
    kept = planted.copy()
    steps = np.linalg.norm(np.diff(balls[..., :2], axis=0), axis=-1)
    low = balls[..., 2] - rest < height
    for side in range(2):
        for span in _spans(planted[:, side]):
            inner = low[span, side]
            after = inner & np.append(steps[span, side][: len(inner) - 1] < travel, False)
            before = inner & np.concatenate([[False], steps[span, side][: len(inner) - 1] < travel])
            first = min(int(after.argmax()) if after.any() else most, most) if span.start else 0
            last = min(int(before[::-1].argmax()) if before.any() else most, most) if span.stop < len(planted) else 0
            kept[span.start : span.start + first, side] = False
            kept[span.stop - last : span.stop, side] = False
    return kept


def _root_correction(balls: Floats, planted: Bools, rest: float) -> Floats:
    """(T, 3) by which to move the body so that the balls (T, 2, 3) of planted feet slip and float least.

    Two regularised least-squares problems with one unknown a frame: the change of the root's horizontal velocity is
    smooth and answers the slip; the change of its height is smooth and answers the height of the standing feet.
    """
    frames = len(balls)
    correction = np.zeros((frames, 3))
    weight = _stance_weight(planted)
    height = balls[..., 2] - rest
    correction[:, 2] = _smoothest(-(weight * height).sum(1), weight.sum(1) + TRUST[0], order=2)
    if frames > 2:
        weight = np.minimum(weight[1:], weight[:-1])
        slip = np.diff(balls[..., :2], axis=0)
        trust = np.where(weight.sum(1) > 0, *TRUST)
        speed = _smoothest(-(weight[..., None] * slip).sum(1), weight.sum(1) + trust, order=1)
        correction[1:, :2] = np.cumsum(speed, axis=0)
    return correction


def _stance_weight(planted: Bools) -> Floats:
    """(T, 2) 1 in the middle of a stance, less at its first and last frames, 0 elsewhere."""
    weight = np.zeros(planted.shape)
    for side in range(2):
        for span in _spans(planted[:, side]):
            place = np.arange(span.stop - span.start)
            from_start = place + 1 if span.start else np.full(len(place), FADE)
            to_end = place[::-1] + 1 if span.stop < len(planted) else np.full(len(place), FADE)
            weight[span, side] = np.minimum(np.minimum(from_start, to_end), FADE) / FADE
    return weight


def _smoothest(pull: Floats, weight: Floats, order: int) -> Floats:
    """x (T, ...) that solves weight x + SMOOTHNESS D'D x = pull, D the difference of the given order."""
    stencil = {1: (-1.0, 1.0), 2: (1.0, -2.0, 1.0)}[order]
    count = len(weight)
    bands = np.zeros((order + 1, count))
    bands[order] = weight
    for i, a in enumerate(stencil):
        for k, b in enumerate(stencil[i:]):
            bands[order - k, i + k : count - order + i + k] += SMOOTHNESS * a * b
    return np.asarray(solveh_banded(bands, pull))


@dataclass(frozen=True)
class _Leg:
    """Measures of one leg in m: its bones, and how far the ankle of a flat foot lies above the ball."""

    thigh: float
    shank: float
    foot: float
    drop: float

    @classmethod
    def measure(cls, joints: Floats, planted: Bools, side: int) -> "_Leg":
        chain = [joints[:, joint[side]] for joint in (HIPS, KNEES, ANKLES, BALLS)]
        thigh, shank, foot = (float(np.median(np.linalg.norm(b - a, axis=1))) for a, b in pairwise(chain))
        drops = (joints[:, ANKLES, 2] - joints[:, BALLS, 2])[planted]
        return cls(thigh, shank, foot, min(float(np.percentile(drops, 30)), 0.9 * foot))


def _foot_path(joints: Floats, stance: Bools, rest: float, side: int, leg: _Leg) -> tuple[Floats, Floats]:
    """Ankle and ball (T, 3) of a foot that stands still, and flat where it nearly does, in each of its stances."""
    own = np.concatenate([joints[:, ANKLES[side]], joints[:, BALLS[side]]], axis=1)
    sole = own[:, :3] - own[:, 3:]
    course = _unit(sole[:, :2])
    level, aimed = (
        1 - _smoothstep((sole[:, 2:] - leg.drop - start) / (stop - start)) for start, stop in (LEVEL_M, AIM_M)
    )
    change = np.zeros_like(own)
    spans = _spans(stance)
    for span in spans:
        ball = np.append(own[span, 3:5].mean(axis=0), rest)
        height = sole[span, 2:] + level[span] * (leg.drop - sole[span, 2:])
        mean = _unit((course[span] * (aimed[span] + 1e-3)).sum(axis=0))
        direction = _unit(course[span] + aimed[span] * (mean - course[span]))
        height = np.clip(height, -0.99 * leg.foot, 0.99 * leg.foot)
        ankle = ball + np.concatenate([direction * np.sqrt(leg.foot**2 - height**2), height], axis=1)
        change[span] = np.concatenate([ankle, np.broadcast_to(ball, ankle.shape)], axis=1) - own[span]
    _fade(change, spans)
    path = own + change
    path[:, 5] = np.maximum(path[:, 5], rest)
    up = path[:, :3] - path[:, 3:]
    up *= leg.foot / np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    return path[:, 3:] + up, path[:, 3:]


def _fade(change: Floats, spans: list[slice]) -> None:
    """Let the change at the edges of the spans fade out over the frames between them, in place."""
    edges = [(0, None), *((span.start, span) for span in spans), (len(change), None)]
    stops = [0, *(span.stop for span in spans)]
    for stop, (start, _) in zip(stops, edges[1:], strict=True):
        gap = start - stop
        if gap <= 0:
            continue
        steps = np.arange(1, gap + 1)
        reach = min(FADE, gap) + 1
        if stop > 0:
            change[stop:start] += change[stop - 1] * (1 - _smoothstep(steps / reach))[:, None]
        if start < len(change):
            change[stop:start] += change[start] * (1 - _smoothstep(steps[::-1] / reach))[:, None]


def _missing_reach(joints: Floats, planted: Bools, feet: list[tuple[Floats, Floats]], legs: list[_Leg]) -> Floats:
    """(T,) by how much the body has to be lower so that its legs reach their standing feet, m, smooth."""
    missing = np.zeros(len(joints))
    for side, (leg, (ankle, _)) in enumerate(zip(legs, feet, strict=True)):
        hip, own = joints[:, HIPS[side]], joints[:, ANKLES[side]]
        reach = np.maximum(REACH * (leg.thigh + leg.shank), np.linalg.norm(own - hip, axis=1))
        down = np.sqrt(np.maximum(reach**2 - ((ankle - hip)[:, :2] ** 2).sum(1), 0))
        missing = np.maximum(missing, np.where(planted[:, side], hip[:, 2] - ankle[:, 2] - down, 0))
    return np.asarray(gaussian_filter1d(maximum_filter1d(missing, 5), 1.0))


def _solve_leg(joints: Floats, side: int, leg: _Leg, ankle: Floats, ball: Floats) -> Floats:
    """Joints with one leg's ankle and ball at the wanted places, the knee bent where it was."""
    out = joints.copy()
    hip, knee, own = (joints[:, joint[side]] for joint in (HIPS, KNEES, ANKLES))
    across = joints[:, HIPS[0]] - joints[:, HIPS[1]]
    ahead = _unit(np.stack([across[:, 1], -across[:, 0], np.zeros(len(across))], axis=1))
    pole = _across(knee - hip, own - hip) + 0.01 * ahead  # a straight leg does not tell where its knee bends to
    line = ankle - hip
    far = np.linalg.norm(line, axis=1, keepdims=True)
    length = np.clip(far, abs(leg.thigh - leg.shank) + 0.02, 0.9999 * (leg.thigh + leg.shank))
    axis = line / np.maximum(far, 1e-9)
    along = (leg.thigh**2 - leg.shank**2 + length**2) / (2 * length)
    bend = np.sqrt(np.maximum(leg.thigh**2 - along**2, 0))
    out[:, KNEES[side]] = hip + along * axis + bend * _unit(_across(pole, axis))
    out[:, ANKLES[side]] = hip + length * axis
    out[:, BALLS[side]] = ball + out[:, ANKLES[side]] - ankle
    return out


def _across(vectors: Floats, line: Floats) -> Floats:
    """The part of (T, 3) vectors at right angles to lines (T, 3)."""
    axis = _unit(line)
    return vectors - (vectors * axis).sum(axis=1, keepdims=True) * axis


def _unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def _smoothstep(share: Floats) -> Floats:
    share = np.clip(share, 0, 1)
    return share * share * (3 - 2 * share)
