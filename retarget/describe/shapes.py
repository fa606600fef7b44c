"""The shapes of a model's bodies as points: what collides, or what is seen where nothing does."""

from itertools import product

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ros_free_stack.messages import Floats

_RING = 24


def body_geoms(model: mujoco.MjModel, body: int) -> list[int]:
    """Ids of a body's shapes: those that collide, else all; no planes or height fields."""
    flat = (int(mujoco.mjtGeom.mjGEOM_PLANE), int(mujoco.mjtGeom.mjGEOM_HFIELD))
    first = model.body_geomadr[body]
    geoms = [g for g in range(first, first + model.body_geomnum[body]) if int(model.geom_type[g]) not in flat]
    return [g for g in geoms if model.geom_contype[g] or model.geom_conaffinity[g]] or geoms


def collides(model: mujoco.MjModel, body: int) -> bool:
    """Whether a body has a shape that collides."""
    return any(model.geom_contype[g] or model.geom_conaffinity[g] for g in body_geoms(model, body))


def geom_points(model: mujoco.MjModel, geom: int) -> Floats:
    """(N, 3) points in the body's frame, m, whose convex hull is the shape."""
    size, kind = model.geom_size[geom], mujoco.mjtGeom(int(model.geom_type[geom]))
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        first = model.mesh_vertadr[mesh]
        points = model.mesh_vert[first : first + model.mesh_vertnum[mesh]].astype(float)
    elif kind == mujoco.mjtGeom.mjGEOM_BOX:
        points = np.array(list(product((-1.0, 1.0), repeat=3))) * size
    elif kind == mujoco.mjtGeom.mjGEOM_CYLINDER:
        points = np.concatenate([_ring(size[0], z) for z in (-size[1], size[1])])
    elif kind == mujoco.mjtGeom.mjGEOM_CAPSULE:
        points = np.concatenate([_ball(size[0]) + np.array([0, 0, z]) for z in (-size[1], size[1])])
    else:
        points = _ball(1.0) * (size if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID else size[0])
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return points @ rotation.reshape(3, 3).T + model.geom_pos[geom]


def body_points(model: mujoco.MjModel, body: int) -> Floats:
    """(N, 3) corners of the convex hulls of a body's shapes, in its frame, m; none where it has no shape."""
    return np.concatenate([np.zeros((0, 3)), *(_hull_corners(geom_points(model, g)) for g in body_geoms(model, body))])


def _hull_corners(points: Floats) -> Floats:
    try:
        return points[ConvexHull(points).vertices]
    except (QhullError, ValueError):  # flat or tiny shapes have no volume
        return points


def _ring(radius: float, height: float) -> Floats:
    angle = np.linspace(0, 2 * np.pi, _RING, endpoint=False)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), np.full(_RING, height)])


def _ball(radius: float) -> Floats:
    """Points on rings of latitude, the poles and the equator among them."""
    heights = np.sin(np.linspace(-np.pi / 2, np.pi / 2, 9))
    return np.concatenate([_ring(np.sqrt(max(1 - z * z, 0.0)), z) for z in heights]) * radius
