"""Frames that are no capture: a pose before or after the motion, and jumps inside of it.

A jump is a step between two frames that is out of proportion to its neighbours. What lies before the first one is a
calibration pose if it is two or three frames or frozen; some conversions smooth the way from such a pose, over a few
frames with speeds that nobody reaches.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from ros_free_stack.messages import Floats

JUMP_SPEED: Final = 6.0
"""Least speed of the fastest joint in a jump, m/s."""
JUMP_M: Final = 0.1
"""Least length of a jump inside the motion that is worth a word."""
OUT_OF_PROPORTION: Final = 4.0
"""Least speed of a jump over that of the steps around it."""
POSE_FRAMES: Final = 3
"""So few frames before or after a jump are no motion."""
FROZEN_M: Final = 0.005
"""Nobody stands so still that no joint moves further than this: a pose, however long."""
_NEAR: Final = 3
_SMOOTHED_S: Final = 0.3
"""Longest way from a pose to the motion where a conversion smoothed it."""


@dataclass(frozen=True)
class Capture:
    """What of a motion is captured: its frames `start` to `end` (exclusive), and the jumps that are left inside.

    `jumps` are (frame before it, length in m).
    """

    start: int
    end: int
    jumps: tuple[tuple[int, float], ...]


def find_capture(points: Floats, fps: float, *, posed: Callable[[Floats], bool] = lambda frame: False) -> Capture:
    """Where the captured motion begins and ends.

    Args:
        points: (T, P, 3) m, the root first.
        fps: frames a second.
        posed: whether a frame (P, 3) shows a pose for calibration: a lesser jump is enough after it, and it may be
            held for any time without being frozen.
    """
    frames = len(points)
    if frames < 4:
        return Capture(0, frames, ())
    steps = _steps(points)
    pose_steps = _steps(points - points[:, :1])
    start = _lead(points, steps, pose_steps, fps, posed)
    left, back_steps, back_pose = (values[::-1][: frames - start] for values in (points, steps, pose_steps))
    back = _lead(left, back_steps, back_pose, fps, posed)
    inside = sorted({k for way in (steps, pose_steps) for k in _breaks(way, fps) if start <= k < frames - back - 1})
    jumps = tuple((k, float(steps[k])) for k in inside if steps[k] > JUMP_M)
    return Capture(start, frames - back, jumps)


def jump_notes(capture: Capture, frames: int, fps: float) -> tuple[str, ...]:
    """What has to be said of a capture of so many frames."""
    left_out = (("first", capture.start), ("last", frames - capture.end))
    notes = [
        f"the {where} {count} frame{'s are' if count > 1 else ' is'} a pose that the motion jumps from or to: left out"
        for where, count in left_out
        if count
    ]
    if capture.jumps:
        shown = ", ".join(f"{length:.2f} m at {k / fps:.2f} s" for k, length in capture.jumps[:3])
        more = f" and {len(capture.jumps) - 3} more" if len(capture.jumps) > 3 else ""
        notes.append(f"the motion jumps by {shown}{more}; --start and --end take a part of it")
    return tuple(notes)


def _steps(points: Floats) -> Floats:
    """(T-1,) way of the fastest point from frame to frame, m."""
    return np.linalg.norm(np.diff(points, axis=0), axis=-1).max(axis=1)


def _breaks(steps: Floats, fps: float) -> list[int]:
    """Steps that are out of proportion to those around them."""
    found: list[int] = []
    for k in np.flatnonzero(steps * fps > JUMP_SPEED):
        around = np.concatenate([steps[max(k - _NEAR, 0) : k], steps[k + 1 : k + 1 + _NEAR]])
        if len(around) and steps[k] > OUT_OF_PROPORTION * around.max():
            found.append(int(k))
    return found


def _lead(points: Floats, steps: Floats, pose_steps: Floats, fps: float, posed: Callable[[Floats], bool]) -> int:
    """How many frames at the start are a pose."""
    lead = max(_smoothed_lead(steps, fps), _smoothed_lead(pose_steps, fps))
    first = posed(points[0])
    if first and any(way[0] * fps > JUMP_SPEED / 2 and way[0] > 1.5 * way[1:4].max() for way in (steps, pose_steps)):
        lead = max(lead, 1)
    for k in {*_breaks(steps, fps), *_breaks(pose_steps, fps)}:
        frozen = float(np.ptp(points[: k + 1], axis=0).max()) < FROZEN_M
        held = first and posed(points[k]) and posed(points[k // 2])
        if k + 1 < len(points) - 1 and (k < POSE_FRAMES or frozen or held):
            lead = max(lead, k + 1)
    return lead


def _smoothed_lead(steps: Floats, fps: float) -> int:
    """How many frames at the start are a pose and a smoothed way from it."""
    longest = max(int(_SMOOTHED_S * fps), 1)
    later = steps[longest : longest + round(fps)]
    if len(later) < longest:
        return 0
    usual = max(float(np.percentile(later, 95)), 0.25 / fps)
    if steps[0] < OUT_OF_PROPORTION * usual or steps[0] * fps < JUMP_SPEED or steps[0] < steps[1:].max() / 2:
        return 0
    fast = np.flatnonzero(steps[:longest] > 2 * usual)
    last = int(fast[-1])
    return last + 1 if (np.diff(fast) <= _NEAR).all() and last < longest - 1 else 0
