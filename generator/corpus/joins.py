"""Cutting, warping, placing, layering and joining of poses, captured and authored alike.

A join is a short bridge: every channel runs on a quintic that takes over the place and the rate of the motion before
and reaches those of the motion after (the boundary-value form of inertialisation, Bollo, "Inertialization", GDC 2018),
while the feet get to their new places one after the other by a lifted step, so that none slides.
"""

from typing import Final

import numpy as np
from scipy.interpolate import CubicSpline

from generator.corpus.pose import CHANNELS, Pose
from ros_free_stack.errors import InvalidOption
from ros_free_stack.skeleton import FPS

SHORT_BRIDGE: Final = 8
LONG_BRIDGE: Final = 13
"""Frames of a bridge whose feet stay about where they are, and of one that takes steps."""
_FRAMES_A_SPEED: Final = 6.0
"""Frames more for each m/s by which the pelvis speeds up or slows down: a walk starts and stops within a second."""
_SLIDE = 0.015  # m: nearer than this a foot needs no step
_STEP = 0.06  # m: farther than this a bridge takes its time
_TURNING = {"arm_left": 3, "arm_right": 3, "foot_left": 3, "foot_right": 3}
"""Columns of angles that may have gone round by whole turns: the elbows' swivels and the feet's yaws."""


def length(pose: Pose) -> int:
    """Number of frames."""
    return len(pose["root"])


def cut(pose: Pose, start: int, stop: int) -> Pose:
    """Frames start to stop (excluded)."""
    return {name: channel[start:stop].copy() for name, channel in pose.items()}


def concatenate(*poses: Pose) -> Pose:
    """One after the other, as they are."""
    return {name: np.concatenate([pose[name] for pose in poses]) for name in CHANNELS}


def warp(pose: Pose, factor: float) -> Pose:
    """The pose played `factor` times as long, on cubic splines.

    Raises:
        InvalidOption: the factor is not positive.
    """
    if factor <= 0:
        raise InvalidOption("factor", f"expected a positive number, found {factor}")
    frames = length(pose)
    if frames < 2:
        return cut(pose, 0, frames)
    times = np.linspace(0, frames - 1, max(2, round(frames * factor)))
    columns = [channel.reshape(frames, -1) for channel in pose.values()]
    warped = CubicSpline(np.arange(frames), np.hstack(columns))(times)
    edges = np.cumsum([column.shape[1] for column in columns])[:-1]
    parts = np.split(warped, edges, axis=1)
    return {
        name: part.reshape(len(times), *channel.shape[1:])
        for (name, channel), part in zip(pose.items(), parts, strict=True)
    }


def place(pose: Pose, where: np.ndarray, heading: float) -> Pose:
    """The pose moved and turned on the floor so that its first frame stands at `where` (2,) with `heading` (rad)."""
    out = cut(pose, 0, length(pose))
    turn = heading - out["heading"][0]
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, s], [-s, c]])
    origin = out["root"][0, :2].copy()
    for name in ("root", "foot_left", "foot_right"):
        out[name][:, :2] = (out[name][:, :2] - origin) @ rotation + where
    out["heading"] += turn
    for name in ("foot_left", "foot_right"):
        out[name][:, 3] += turn
    return out


def layer(base: Pose, over: Pose, start: int, channels: tuple[str, ...], ramp: int = 8) -> Pose:
    """`base` with the given channels taken from `over` from frame `start` on, cross-faded over `ramp` frames."""
    out = cut(base, 0, length(base))
    frames = min(length(over), length(base) - start)
    steps = np.arange(frames)
    weight = _smooth(np.clip(np.minimum(steps + 1, frames - steps) / ramp, 0, 1))
    for name in channels:
        share = weight.reshape(-1, *[1] * (out[name].ndim - 1))
        window = slice(start, start + frames)
        change = over[name][:frames] - out[name][window]
        if name in _TURNING:
            angle, half = change[:, _TURNING[name]], frames // 2
            angle[:half] -= _whole_turns(angle[0])
            angle[half:] -= _whole_turns(angle[-1])  # at full weight, where a whole turn changes nothing
        out[name][window] += share * change
    return out


def join(before: Pose, after: Pose) -> tuple[Pose, int, int]:
    """`after` placed in front of where `before` ends and bridged to it.

    Returns:
        The joined pose, and the frames at which `before` has ended and `after` begins.
    """
    frames = LONG_BRIDGE if _moved_feet(before, after) > _STEP else SHORT_BRIDGE
    change = flat_speed(after, 0) - flat_speed(before, -1)
    frames += round(_FRAMES_A_SPEED * FPS * abs(change)) if frames == LONG_BRIDGE else 0
    span = frames + 1.0
    turned = place(after, np.zeros(2), before["heading"][-1])
    turn = 0.5 * span * (_rate(before, "heading", -1) + _rate(turned, "heading", 0))
    turned = place(turned, np.zeros(2), before["heading"][-1] + turn)
    drift = 0.5 * span * (_rate(before, "root", -1) + _rate(turned, "root", 0))[:2]
    placed = place(turned, before["root"][-1, :2] + drift, turned["heading"][0])
    for name, column in _TURNING.items():
        placed[name][:, column] -= _whole_turns(placed[name][0, column] - before[name][-1, column])
    start = length(before)
    return concatenate(before, _bridge(before, placed, frames), placed), start, start + frames


def _whole_turns(angle: float) -> float:
    """The whole turns, in rad, nearest to an angle."""
    return 2 * np.pi * round(angle / (2 * np.pi))


def _smooth(share: np.ndarray) -> np.ndarray:
    return share**3 * (10 - 15 * share + 6 * share**2)


def _rate(pose: Pose, name: str, frame: int) -> np.ndarray:
    """Rate of a channel at the first (0) or the last (-1) frame, per frame."""
    channel = pose[name]
    if len(channel) < 2:
        return np.zeros_like(channel[0])
    return channel[1] - channel[0] if frame == 0 else channel[-1] - channel[-2]


def _moved_feet(before: Pose, after: Pose) -> float:
    """How far the feet of `after` stand from those of `before` when both roots and headings agree, in m."""
    here = place(cut(before, length(before) - 1, length(before)), np.zeros(2), 0.0)
    there = place(cut(after, 0, 1), np.zeros(2), 0.0)
    feet = ("foot_left", "foot_right")
    resting = max(float(np.linalg.norm(here[foot][0, :3] - there[foot][0, :3])) for foot in feet)
    return resting + 4 * max(flat_speed(before, -1), flat_speed(after, 0))


def flat_speed(pose: Pose, frame: int) -> float:
    """Speed of the pelvis over the floor at the first (0) or the last (-1) frame, in m a frame."""
    return float(np.linalg.norm(_rate(pose, "root", frame)[:2]))


def _bridge(before: Pose, after: Pose, frames: int) -> Pose:
    shares = np.arange(1, frames + 1) / (frames + 1.0)
    out = {
        name: _quintic(
            before[name][-1], after[name][0], _rate(before, name, -1), _rate(after, name, 0), shares, frames + 1.0
        )
        for name in CHANNELS
    }
    feet = sorted(("foot_left", "foot_right"), key=lambda foot: _lateness(before, after, foot))
    for foot, (start, stop) in zip(feet, ((0.0, 0.58), (0.42, 1.0)), strict=True):
        out[foot] = _step(before[foot], after[foot], shares, start, stop, frames + 1.0)
    return out


def _lateness(before: Pose, after: Pose, foot: str) -> float:
    """Order of stepping: a foot that is in the air already goes first, one that takes off at once goes last."""
    flying, leaving = _rate(before, foot, -1)[:3], _rate(after, foot, 0)[:3]
    far = np.linalg.norm(after[foot][0, :2] - before[foot][-1, :2])
    return float(np.linalg.norm(leaving) - np.linalg.norm(flying) - 0.1 * far)


def _step(
    before: np.ndarray, after: np.ndarray, shares: np.ndarray, start: float, stop: float, span: float
) -> np.ndarray:
    """A foot's way (frames, 4) from its last to its first place between two shares of the bridge."""
    leave = before[-1] - before[-2] if start == 0.0 and len(before) > 1 else np.zeros(4)
    land = after[1] - after[0] if stop == 1.0 and len(after) > 1 else np.zeros(4)
    local = np.clip((shares - start) / (stop - start), 0, 1)
    path = _quintic(before[-1], after[0], leave, land, local, span * (stop - start))
    far = float(np.linalg.norm(after[0, :2] - before[-1, :2]))
    if far > _SLIDE:
        path[:, 2] += 16 * local**2 * (1 - local) ** 2 * min(0.07, 0.35 * far)
    return path


def _quintic(
    start: np.ndarray, end: np.ndarray, start_rate: np.ndarray, end_rate: np.ndarray, shares: np.ndarray, span: float
) -> np.ndarray:
    """Quintic between two states with given rates (per frame) and no acceleration, at `shares` (n,) of the span."""
    s = shares.reshape(-1, *[1] * np.ndim(start))
    x, a, b = end - start, start_rate * span, end_rate * span
    return (
        start
        + a * s
        + (10 * x - 6 * a - 4 * b) * s**3
        + (-15 * x + 8 * a + 7 * b) * s**4
        + (6 * x - 3 * a - 3 * b) * s**5
    )
