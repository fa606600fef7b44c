"""What every reader does last: resample, and stand the motion on the floor of a z-up world."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

FLOOR_PERCENTILE = 2.0
"""The lowest joint touches the floor in at least this share of the frames: a few bad frames do not count."""


def from_y_up(points: Floats) -> Floats:
    """(..., 3) points with y up and z forward as points with z up and x forward."""
    return points[..., (2, 0, 1)]


def resample(points: Floats, *, fps: float, to: float) -> Floats:
    """(T, ...) points at another frame rate: linear in time, exact where the frames coincide."""
    count = int((len(points) - 1) / fps * to + 1e-4) + 1
    time = np.arange(count) * (fps / to)
    before = np.minimum(np.floor(time + 1e-6).astype(int), len(points) - 1)
    after = np.minimum(before + 1, len(points) - 1)
    part = np.clip(time - before, 0.0, 1.0).reshape(-1, *(1,) * (points.ndim - 1))
    return points[before] + part * (points[after] - points[before])


def put_on_floor(joints: Floats) -> Floats:
    """(T, J, 3) joints moved vertically so that the lowest of them stands at z = 0."""
    lowest = joints[..., 2].min(axis=1)
    return joints - (0.0, 0.0, float(np.percentile(lowest, FLOOR_PERCENTILE)))
