"""What readers do last: stand the motion on the floor of a z-up world, facing x, and change its frame rate."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.skeleton import INDEX

Floats = NDArray[np.float64]

FLOOR_PERCENTILE = 2.0
"""The lowest joint touches the floor in at least this share of the frames: a few bad frames do not count."""

_LEFT = (INDEX["left_hip"], INDEX["left_shoulder"])
_RIGHT = (INDEX["right_hip"], INDEX["right_shoulder"])


def from_y_up(points: Floats) -> Floats:
    """(..., 3) points with y up and z forward as points with z up and x forward."""
    return points[..., (2, 0, 1)]


def to_y_up(points: Floats) -> Floats:
    """The inverse of `from_y_up`."""
    return points[..., (1, 2, 0)]


def resample(points: Floats, *, fps: float, to: float) -> Floats:
    """(T, ...) points at another frame rate: linear in time, exact where the frames coincide."""
    before, after, part = blend(len(points), fps=fps, to=to)
    part = part.reshape(-1, *(1,) * (points.ndim - 1))
    return points[before] + part * (points[after] - points[before])


def blend(frames: int, *, fps: float, to: float) -> tuple[NDArray[np.intp], NDArray[np.intp], Floats]:
    """For every frame at another rate: the frames before and after it, and how far it is from one to the other."""
    count = int((frames - 1) / fps * to + 1e-4) + 1
    time = np.arange(count) * (fps / to)
    before = np.minimum(np.floor(time + 1e-6).astype(np.intp), frames - 1)
    part = np.clip(time - before, 0.0, 1.0).astype(np.float64)
    return before, np.minimum(before + 1, frames - 1), part


def put_on_floor(joints: Floats) -> Floats:
    """(T, J, 3) joints moved vertically so that the lowest of them stands at z = 0."""
    return joints - (0.0, 0.0, floor_height(joints))


def floor_height(joints: Floats) -> float:
    """Where the lowest of (T, J, 3) joints stands, z up."""
    return float(np.percentile(joints[..., 2].min(axis=1), FLOOR_PERCENTILE))


def face_forward(points: Floats, *, left: Sequence[int] = _LEFT, right: Sequence[int] = _RIGHT) -> Floats:
    """(T, J, 3) points moved and turned about z: at first the root is above the origin and the body faces x.

    Args:
        points: the root first, z up.
        left, right: hips and shoulders; the line from right to left becomes y.
    """
    first = points[0]
    x, y = (first[list(left)].sum(axis=0) - first[list(right)].sum(axis=0))[:2]
    length = np.hypot(x, y)
    cos, sin = (y / length, x / length) if length > 0 else (1.0, 0.0)
    turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
    return (points - first[0] * (1, 1, 0)) @ turn.T


def stand(joints: Floats) -> Floats:
    """(T, 22, 3) joints on the floor, at first above the origin and facing x."""
    return put_on_floor(face_forward(joints))
