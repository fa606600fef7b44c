"""The flat underside of a foot: the largest facet of its hull that faces the floor, as a rectangle."""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ros_free_stack.messages import Floats

SAME_PLANE = 0.995
"""Cosine of the angle within which facets count as one."""
FACES_DOWN = 0.7
"""Cosine of the largest angle between a sole and the floor in the pose that the model or its keyframe gives."""
LEAST_AREA = 0.05
"""Least area of a sole, in squares of the foot's length: less is the underside of something round."""
THICKNESS = 0.03
"""How far above the plane corners still belong to the sole, in lengths of the foot."""


def find_sole(points: Floats, down: Floats, forward: Floats) -> Floats | None:
    """(4, 3) corners of a foot's underside, (back left, back right, front left, front right); None where none is flat.

    Args:
        points: (N, 3) corners of the foot's shapes, in its own frame, m.
        down: (3,) the direction of the floor in that frame, roughly.
        forward: (3,) where the toes point, roughly.
    """
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError):
        return None
    normals = hull.equations[:, :3]
    areas = _areas(points[hull.simplices])
    facing = np.flatnonzero(normals @ down > FACES_DOWN)
    if not len(facing):
        return None
    grouped = [areas[facing[normals[facing] @ normals[k] > SAME_PLANE]].sum() for k in facing]
    chosen = facing[int(np.argmax(grouped))]
    together = facing[normals[facing] @ normals[chosen] > SAME_PLANE]
    normal = (areas[together, None] * normals[together]).sum(axis=0)
    normal /= np.linalg.norm(normal)
    if grouped[int(np.argmax(grouped))] < LEAST_AREA * np.ptp(points @ forward) ** 2:
        return None
    heights = points @ normal
    flat = points[heights > heights.max() - THICKNESS * np.ptp(points @ forward)]
    return _rectangle(flat, normal, forward, float(heights.max()))


def _areas(triangles: Floats) -> Floats:
    a, b, c = triangles.transpose(1, 0, 2)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def _rectangle(points: Floats, normal: Floats, forward: Floats, height: float) -> Floats:
    """The smallest rectangle in the plane around the points, its long side along the foot."""
    x = forward - (forward @ normal) * normal
    x /= np.linalg.norm(x)
    y = np.cross(x, normal)  # left, since the normal points down
    flat = np.column_stack([points @ x, points @ y])
    best, least = np.zeros((4, 2)), np.inf
    for angle in np.linspace(-np.pi / 6, np.pi / 6, 121):
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        low, high = (flat @ turn).min(axis=0), (flat @ turn).max(axis=0)
        area = float(np.prod(high - low))
        if area < least * (1 - 1e-6):
            corners = np.array([[low[0], high[1]], [low[0], low[1]], [high[0], high[1]], [high[0], low[1]]])
            best, least = corners @ turn.T, area
    return best @ np.stack([x, y]) + height * normal
