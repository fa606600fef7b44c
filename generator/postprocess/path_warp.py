"""A motion that goes farther, turns more or takes longer, with feet that stand where they stand.

After Gleicher, "Motion path editing" (I3D 2001): the root's path is changed as a whole and the body rides on it. A
standing foot rides on the path as it is in the middle of its stance, so that it does not slide; in between it goes over
from one place to the next. The legs follow by inverse kinematics.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from generator.postprocess.foot_lock import find_stances, standing_height
from generator.postprocess.legs import ANKLES, BALLS, SIDES, Leg, missing_reach, smoothstep, solve_leg, spans
from ros_free_stack.formats.features import encode
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import INDEX

Floats = NDArray[np.float64]

_ACROSS = (("left_hip", "right_hip"), ("left_shoulder", "right_shoulder"))


@dataclass(frozen=True)
class Change:
    """What becomes of a range of a motion: factors of its way over the floor, of its turning and of its time."""

    start_s: float
    end_s: float
    travel: float = 1.0
    turn: float = 1.0
    time: float = 1.0


@dataclass(frozen=True)
class Path:
    """The root's path: place on the floor (T, 2) m, heading (T,) rad, unwrapped."""

    place: Floats
    heading: Floats

    @classmethod
    def of(cls, joints: Floats) -> "Path":
        """The path of joints (T, 22, 3)."""
        across = np.sum([joints[:, INDEX[left]] - joints[:, INDEX[right]] for left, right in _ACROSS], axis=0)
        return cls(joints[:, 0, :2].copy(), np.unwrap(np.arctan2(-across[:, 0], across[:, 1])))

    def scaled(self, travel: Floats, turn: Floats) -> "Path":
        """The path whose steps, seen from the body, and whose turning are scaled by factors (T - 1,) each."""
        heading = self.heading[0] + np.concatenate([[0.0], np.cumsum(turn * np.diff(self.heading))])
        steps = travel[:, None] * np.diff(self.place, axis=0)
        turned = rotated(steps, (heading - self.heading)[:-1])
        return Path(self.place[0] + np.concatenate([np.zeros((1, 2)), np.cumsum(turned, axis=0)]), heading)

    def at(self, frames: Floats) -> "Path":
        """The path at fractional frames."""
        whole = np.arange(len(self.heading))
        x, y, heading = (np.interp(frames, whole, values) for values in (*self.place.T, self.heading))
        return Path(np.stack([x, y], axis=1), heading)


def warped(motion: HumanMotion, changes: Sequence[Change]) -> HumanMotion:
    """The motion with its ranges changed; what comes after a range goes on from where it leads.

    Args:
        motion: on a level floor.
        changes: of ranges that do not overlap.
    """
    joints = motion.joints
    if any((change.travel, change.turn) != (1.0, 1.0) for change in changes) and len(joints) > 1:
        travel, turn = np.ones(len(joints) - 1), np.ones(len(joints) - 1)
        for change in changes:
            range_ = slice(round(change.start_s * motion.fps), round(change.end_s * motion.fps))
            travel[range_], turn[range_] = change.travel, change.turn
        joints = ridden(joints, travel, turn)
    return _retimed(replace(motion, joints=joints), changes)


def ridden(joints: Floats, travel: Floats, turn: Floats) -> Floats:
    """Joints (T, 22, 3) on the path that is scaled by factors (T - 1,) each."""
    rest = standing_height(joints)
    contacts = encode(joints)[:, -4:].astype(float)
    planted = find_stances(joints, np.concatenate([contacts, contacts[-1:]]), rest)
    old = Path.of(joints)
    new = old.scaled(travel, turn)
    out = carried(joints, old, new, np.arange(len(joints), dtype=float))
    legs = [Leg.measure(joints, planted, side) for side in range(len(SIDES))]
    feet = []
    for side in range(len(SIDES)):
        moments = _foot_moments(planted[:, side])
        foot = carried(joints[:, [ANKLES[side], BALLS[side]]], old, new, moments)
        feet.append((foot[:, 0], foot[:, 1]))
    out[..., 2] -= missing_reach(out, planted, feet, legs)[:, None]
    for side, (leg, (ankle, ball)) in enumerate(zip(legs, feet, strict=True)):
        out = solve_leg(out, side, leg, ankle, ball)
    return out


def carried(points: Floats, old: Path, new: Path, moments: Floats) -> Floats:
    """Points (T, n, 3) moved over the floor as the path was at fractional frames (T,)."""
    before, after = old.at(moments), new.at(moments)
    out = points.copy()
    flat = points[..., :2] - before.place[:, None]
    out[..., :2] = after.place[:, None] + rotated(flat, (after.heading - before.heading)[:, None])
    return out


def rotated(vectors: Floats, angles: Floats) -> Floats:
    """Vectors (..., 2) turned by angles (...) about the vertical."""
    cos, sin = np.cos(angles), np.sin(angles)
    x, y = vectors[..., 0], vectors[..., 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)


def _foot_moments(stance: NDArray[np.bool_]) -> Floats:
    """(T,) the frame as of which a foot rides on the path: the middle of its stance while it stands."""
    last = len(stance) - 1
    places = [
        (0, 0, 0.0),
        *((s.start, s.stop - 1, (s.start + s.stop - 1) / 2) for s in spans(stance)),
        (last, last, last),
    ]
    moments = np.zeros(len(stance))
    for (_, stop, from_), (start, end, to) in pairwise(places):
        way = np.arange(stop, start + 1)
        share = (way - stop) / max(start - stop, 1)
        moments[way] = from_ + (to - from_) * smoothstep(share)
        moments[start : end + 1] = to
    return moments


def _retimed(motion: HumanMotion, changes: Sequence[Change]) -> HumanMotion:
    """The motion with ranges that last longer or shorter."""
    if all(change.time == 1.0 for change in changes):
        return motion
    edges = np.unique([0.0, motion.duration_s, *(edge for c in changes for edge in (c.start_s, c.end_s))])
    middles = (edges[1:] + edges[:-1]) / 2
    factors = [next((c.time for c in changes if c.start_s <= m <= c.end_s), 1.0) for m in middles]
    lasting = np.concatenate([[0.0], np.cumsum(np.diff(edges) * factors)])
    count = max(2, round(lasting[-1] * motion.fps))
    frames = np.arange(len(motion.joints)) / motion.fps
    moments = np.clip(np.interp(np.arange(count) / motion.fps, lasting, edges), 0, frames[-1])
    segments = tuple(
        replace(s, start_s=float(np.interp(s.start_s, edges, lasting)), end_s=float(np.interp(s.end_s, edges, lasting)))
        for s in motion.segments
    )
    return replace(motion, joints=CubicSpline(frames, motion.joints, axis=0)(moments), segments=segments)
