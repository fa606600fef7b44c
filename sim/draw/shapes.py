"""What a robot looks like without OpenGL: each collision shape as a small cloud of points whose hull is drawn."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import standing_qpos
from ros_free_stack.robots import RobotDescription, Sole

_DIRECTIONS = 48
_SPECK_M = 0.015
"""Contact spheres smaller than this are no part of a robot's looks."""


@dataclass(frozen=True)
class Shape:
    """A convex part of a robot: corner points (n, 3) in m in the frame of a body (by index)."""

    body: int
    points: Floats


def body_shapes(model: mujoco.MjModel, robot: RobotDescription) -> tuple[Shape, ...]:
    """The collision shapes of all bodies except the world, each reduced to at most 48 extreme points.

    Feet are drawn from their soles; a body without a shape of its own (a waist) is a ball.
    """
    collision = _collision_shapes(model)
    shown = {shape.body for shape in collision} | {model.body(sole.body).id for sole in robot.soles.values()}
    ball = 0.09 * float(standing_qpos(model, robot)[2]) * sphere(_DIRECTIONS)
    bare = [Shape(body, ball) for body in range(1, model.nbody) if body not in shown]
    return (*collision, *bare, *(_foot(model, sole) for sole in robot.soles.values()))


def _foot(model: mujoco.MjModel, sole: Sole) -> Shape:
    """A wedge from the sole up to the ankle."""
    corners = np.array(sole.corners)
    instep = corners * [0.4, 0.7, 0.1]
    return Shape(model.body(sole.body).id, np.concatenate([corners, corners * [1, 1, 0.6], instep]))


def _collision_shapes(model: mujoco.MjModel) -> list[Shape]:
    directions = sphere(_DIRECTIONS)
    shapes: list[Shape] = []
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        collides = model.geom_contype[geom] or model.geom_conaffinity[geom]
        if body == 0 or not collides:
            continue
        local = geom_points(model, geom, directions)
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
        points = model.geom_pos[geom] + local @ rotation.reshape(3, 3).T
        extreme = np.unique(np.argmax(points @ directions.T, axis=0))
        if np.ptp(points, axis=0).max() > _SPECK_M:
            shapes.append(Shape(body, points[extreme]))
    return shapes


def geom_points(model: mujoco.MjModel, geom: int, directions: Floats) -> Floats:
    """Points (n, 3) whose hull is the geom, in its own frame."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    if kind == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = model.geom_dataid[geom]
        start = model.mesh_vertadr[mesh]
        return model.mesh_vert[start : start + model.mesh_vertnum[mesh]].astype(float)
    if kind == mujoco.mjtGeom.mjGEOM_BOX:
        return size * np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    if kind in (mujoco.mjtGeom.mjGEOM_CAPSULE, mujoco.mjtGeom.mjGEOM_CYLINDER):
        flat = kind == mujoco.mjtGeom.mjGEOM_CYLINDER
        angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
        cap = ring if flat else directions
        ends = [np.array([0, 0, side * size[1]]) for side in (-1, 1)]
        return np.concatenate([size[0] * cap + end for end in ends])
    if kind == mujoco.mjtGeom.mjGEOM_ELLIPSOID:
        return size * directions
    return size[0] * directions


def sphere(count: int) -> Floats:
    """(count, 3) nearly uniform unit vectors (Fibonacci lattice)."""
    index = np.arange(count) + 0.5
    height = 1 - 2 * index / count
    angle = np.pi * (1 + 5**0.5) * index
    radius = np.sqrt(1 - height**2)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=1)
