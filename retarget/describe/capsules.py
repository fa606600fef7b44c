"""Capsules around the shapes of a robot's bodies: how the numbers in the descriptions were found."""

from itertools import product

import mujoco
import numpy as np
from scipy.optimize import minimize
from scipy.spatial import ConvexHull

from retarget.describe.shapes import body_geoms, geom_points
from ros_free_stack.messages import Floats
from ros_free_stack.robots import Capsule

RESTARTS = 2
"""A simplex that has shrunk onto a ridge goes on from a fresh one, so many times."""


def fit_capsules(surface: Floats, cells: tuple[int, int, int] = (1, 1, 1)) -> tuple[Capsule, ...]:
    """Cover points (N, 3) with the capsule of least volume in each cell of a grid over their extent.

    A capsule covers a convex body whose points it covers. Several follow a box more closely than one.
    """
    low, size = surface.min(axis=0), np.ptp(surface, axis=0)
    index = np.minimum((surface - low) / size * cells, np.array(cells) - 1).astype(int)
    found: list[Capsule] = []
    for cell in product(*(range(count) for count in cells)):
        inside = surface[(index == cell).all(axis=1)]
        if len(inside) > 3:
            found.append(_least_capsule(inside))
    return tuple(found)


def exact_capsule(model: mujoco.MjModel, body: int) -> Capsule | None:
    """The capsule that a body's only shape is, a sphere or a capsule; else None."""
    geoms = body_geoms(model, body)
    round_shapes = (int(mujoco.mjtGeom.mjGEOM_SPHERE), int(mujoco.mjtGeom.mjGEOM_CAPSULE))
    if len(geoms) != 1 or int(model.geom_type[geoms[0]]) not in round_shapes:
        return None
    geom = geoms[0]
    capsule = int(model.geom_type[geom]) == int(mujoco.mjtGeom.mjGEOM_CAPSULE)
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    half = rotation.reshape(3, 3)[:, 2] * model.geom_size[geom, 1] * capsule
    (x, y, z), (u, v, w) = ((model.geom_pos[geom] + side * half).round(4).tolist() for side in (-1, 1))
    return Capsule((x, y, z), (u, v, w), float(np.ceil(1e4 * model.geom_size[geom, 0]) / 1e4))


def hull_surface(model: mujoco.MjModel, body: int, spacing: float = 0.004) -> Floats:
    """(N, 3) points on the convex hulls of a body's shapes, in the body's frame, m; none where it has no shape.

    Args:
        model: compiled with meshes.
        body: body id.
        spacing: largest distance of neighbouring points.
    """
    hulls = [_hull_points(geom_points(model, geom), spacing) for geom in body_geoms(model, body)]
    points = np.concatenate([np.zeros((0, 3)), *hulls])
    _, one_per_cube = np.unique(np.round(4 / spacing * points), axis=0, return_index=True)
    return points[one_per_cube]


def distance_outside(points: Floats, capsules: tuple[Capsule, ...]) -> Floats:
    """(N,) distance of points to the union of capsules, m; negative inside."""
    return np.min(
        [_to_segment(points, np.array(c.start), np.array(c.end)) - c.radius for c in capsules],
        axis=0,
    )


def _least_capsule(points: Floats) -> Capsule:
    """The capsule of least volume around points, from each principal axis by simplex searches."""
    corners = points[ConvexHull(points).vertices]
    centre, scale = (corners.min(axis=0) + corners.max(axis=0)) / 2, float(np.ptp(corners, axis=0).max())
    principal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2]

    def volume(ends: Floats) -> float:
        start, end = ends.reshape(2, 3)
        radius = _to_segment(corners, start, end).max()
        return float(radius**2 * (np.linalg.norm(end - start) + 4 / 3 * radius)) / scale**3

    def refined(ends: Floats) -> Floats:
        options = {"maxfev": 3000, "xatol": 1e-6, "fatol": 1e-9}
        return np.asarray(minimize(volume, ends, method="Nelder-Mead", options=options).x)

    reaches = [0.3 * np.ptp(points @ axis) * axis for axis in principal]
    best = min((refined(np.concatenate([centre - reach, centre + reach])) for reach in reaches), key=volume)
    for _ in range(RESTARTS):
        best = refined(best)
    best = np.round(best, 4).reshape(2, 3)
    radius = np.ceil(1e4 * _to_segment(corners, best[0], best[1]).max()) / 1e4
    (x, y, z), (u, v, w) = best.tolist()
    return Capsule((x, y, z), (u, v, w), float(radius))


def _to_segment(points: Floats, start: Floats, end: Floats) -> Floats:
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0, 1)
    return np.linalg.norm(points - start - share[:, None] * along, axis=1)


def _hull_points(corners: Floats, spacing: float) -> Floats:
    """Vertices and evenly spread points on the faces of a hull."""
    hull = ConvexHull(corners)
    found = [corners[hull.vertices]]
    for triangle in corners[hull.simplices]:
        longest = max(np.linalg.norm(triangle - np.roll(triangle, 1, axis=0), axis=1))
        count = int(np.ceil(longest / spacing))
        shares = np.array([(i, j, count - i - j) for i in range(count + 1) for j in range(count + 1 - i)]) / count
        found.append(shares @ triangle)
    return np.concatenate(found)
