"""Foot-skate clean-up of decoded motion: standing feet stand still, and the body's path follows from them.

A decoder gets the poses right but not quite the path of the root, so that feet glide where they should stand. After
Kovar, Schreiner and Gleicher, "Footskate cleanup for motion capture editing" (SCA 2002): find when each foot is
planted, hold it at one place there, solve the legs by inverse kinematics, and fade every change out over the swing.
Before that the slip that both feet agree on is taken out of the root's path, which is where most of it comes from;
the legs then only have to make up for a rest.
"""

from typing import Final

import numpy as np
from scipy.linalg import solveh_banded
from scipy.ndimage import binary_closing, binary_opening

from generator.postprocess.legs import (
    ANKLES,
    BALLS,
    Bools,
    Floats,
    Leg,
    missing_reach,
    smoothstep,
    solve_leg,
    spans,
    unit,
)

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
    legs = [Leg.measure(moved, planted, side) for side in range(2)]
    feet = [_foot_path(moved, planted[:, side], rest, side, legs[side]) for side in range(2)]
    moved[..., 2] -= missing_reach(moved, planted, feet, legs)[:, None]
    for side, (leg, (ankle, ball)) in enumerate(zip(legs, feet, strict=True)):
        moved = solve_leg(moved, side, leg, ankle, ball)
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


def _without_edges(planted: Bools, balls: Floats, rest: float) -> Bools:
    """Stances without the frames of touch-down and take-off in which the foot is on its way."""
    height, travel, most = EDGE
    kept = planted.copy()
    steps = np.linalg.norm(np.diff(balls[..., :2], axis=0), axis=-1)
    low = balls[..., 2] - rest < height
    for side in range(2):
        for span in spans(planted[:, side]):
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
        for span in spans(planted[:, side]):
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


def _foot_path(joints: Floats, stance: Bools, rest: float, side: int, leg: Leg) -> tuple[Floats, Floats]:
    """Ankle and ball (T, 3) of a foot that stands still, and flat where it nearly does, in each of its stances."""
    own = np.concatenate([joints[:, ANKLES[side]], joints[:, BALLS[side]]], axis=1)
    sole = own[:, :3] - own[:, 3:]
    course = unit(sole[:, :2])
    level, aimed = (
        1 - smoothstep((sole[:, 2:] - leg.drop - start) / (stop - start)) for start, stop in (LEVEL_M, AIM_M)
    )
    change = np.zeros_like(own)
    stances = spans(stance)
    for span in stances:
        ball = np.append(own[span, 3:5].mean(axis=0), rest)
        height = sole[span, 2:] + level[span] * (leg.drop - sole[span, 2:])
        mean = unit((course[span] * (aimed[span] + 1e-3)).sum(axis=0))
        direction = unit(course[span] + aimed[span] * (mean - course[span]))
        height = np.clip(height, -0.99 * leg.foot, 0.99 * leg.foot)
        ankle = ball + np.concatenate([direction * np.sqrt(leg.foot**2 - height**2), height], axis=1)
        change[span] = np.concatenate([ankle, np.broadcast_to(ball, ankle.shape)], axis=1) - own[span]
    _fade(change, stances)
    path = own + change
    path[:, 5] = np.maximum(path[:, 5], rest)
    up = path[:, :3] - path[:, 3:]
    up *= leg.foot / np.maximum(np.linalg.norm(up, axis=1, keepdims=True), 1e-9)
    return path[:, 3:] + up, path[:, 3:]


def _fade(change: Floats, stances: list[slice]) -> None:
    """Let the change at the edges of the spans fade out over the frames between them, in place."""
    edges = [(0, None), *((span.start, span) for span in stances), (len(change), None)]
    stops = [0, *(span.stop for span in stances)]
    for stop, (start, _) in zip(stops, edges[1:], strict=True):
        gap = start - stop
        if gap <= 0:
            continue
        steps = np.arange(1, gap + 1)
        reach = min(FADE, gap) + 1
        if stop > 0:
            change[stop:start] += change[stop - 1] * (1 - smoothstep(steps / reach))[:, None]
        if start < len(change):
            change[stop:start] += change[start] * (1 - smoothstep(steps[::-1] / reach))[:, None]
