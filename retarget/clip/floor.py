"""The floor under a captured motion: a plane through its footholds, which may be tilted.

Where a capture's vertical was calibrated a degree off, a walk climbs or sinks by centimetres within a few steps, and
feet that stand seem to hover or to be under ground.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from retarget.clip.runs import runs
from ros_free_stack.messages import Bools, Floats

FOOTHOLD_FRAMES = 2
"""Least frames in which a foot is still that count as a foothold."""
HEIGHT_M = 0.01
"""Standard deviation of the heights of toes that stand on one plane."""
OUTLIER = 3.0
"""Standard deviations above the plane at which a foothold is as likely to be on something else."""
SLOPE = 0.02
"""Standard deviation of a capture's slope in either direction."""
WIDEST_M, ITERATIONS = 0.1, 20
"""Standard deviation with which the search begins, and its steps down to `HEIGHT_M`."""
LOW_PERCENT = 5
"""Percentile of the lower toe's height that is the floor where no foot ever rests."""


def put_on_level_floor(joints: Floats, toes: Floats, still: Bools) -> Floats:
    """(T, J, 3) joints moved and tilted so that the floor is z = 0.

    Args:
        joints: (T, J, 3) m, z up.
        toes: (T, F, 3) m, those of them that touch the floor.
        still: (T, F) whether each is at rest.
    """
    slope, height = _floor(_footholds(toes, still), float(np.percentile(toes[..., 2].min(axis=1), LOW_PERCENT)))
    normal = np.array([-slope[0], -slope[1], 1.0]) / np.sqrt(1 + slope @ slope)
    tilt = Rotation.align_vectors([[0.0, 0.0, 1.0]], [normal])[0].as_matrix()
    return joints @ tilt.T - [0.0, 0.0, normal[2] * height]


def _footholds(toes: Floats, still: Bools) -> Floats:
    """(K, 3) medians of toes over the stretches in which they are at rest and lower than the other foot."""
    lowest = toes[..., 2].argmin(axis=1)
    places = [
        np.median(toes[start:end, i], axis=0)
        for i in range(toes.shape[1])
        for start, end in runs(still[:, i] & (lowest == i))
        if end - start >= FOOTHOLD_FRAMES
    ]
    return np.reshape(places, (-1, 3))


def _floor(places: Floats, otherwise: float) -> tuple[Floats, float]:
    """Slope (2,) and height at the origin, m, of the floor under (K, 3) footholds; `otherwise` high without any.

    The plane is the likeliest for the footholds' heights and its own slope. A foothold above it counts by the bounded
    loss of Geman and McClure, so that objects and steps tell nothing; one below it counts in full, as nothing stands
    under the floor. The search is graduated non-convexity (Blake and Zisserman 1987, "Visual reconstruction"): from a
    loss that is wide enough for all footholds to the one that is meant.
    """
    if not len(places):
        return np.zeros(2), otherwise
    middle = places[:, :2].mean(axis=0)
    design = np.column_stack([np.ones(len(places)), places[:, :2] - middle])
    away, plane = places[:, 2] - np.median(places[:, 2]), np.zeros(3)
    for spread in np.geomspace(WIDEST_M, HEIGHT_M, ITERATIONS):
        prior = np.diag([0.0, 1.0, 1.0]) * (spread / SLOPE) ** 2
        weights = (1 + (np.maximum(away, 0) / (OUTLIER * spread)) ** 2) ** -2
        plane = np.linalg.solve(design.T @ (weights[:, None] * design) + prior, design.T @ (weights * places[:, 2]))
        away = places[:, 2] - design @ plane
    return plane[1:], float(plane[0] - plane[1:] @ middle)
