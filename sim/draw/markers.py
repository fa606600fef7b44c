"""What is drawn into a MuJoCo scene beside the robot: standing feet, floor forces, ZMP, red joints, the human."""

from collections.abc import Sequence

import mujoco
import numpy as np
from scipy.spatial import ConvexHull, QhullError

from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import BONES, INDEX, PARTS

Colour = tuple[float, float, float, float]

LEFT, RIGHT, TRUNK = (0.85, 0.47, 0.02, 1.0), (0.15, 0.39, 0.92, 1.0), (0.28, 0.33, 0.41, 1.0)
STANDING, UNLOADED = (0.09, 0.64, 0.29, 0.9), (0.92, 0.6, 0.1, 0.9)
INSIDE, OUTSIDE = (0.15, 0.39, 0.92, 1.0), (0.86, 0.15, 0.15, 1.0)
FORCE = (0.09, 0.64, 0.29, 0.55)
AT_LIMIT = (0.86, 0.12, 0.12, 1.0)

_LOADED = 0.02
"""Share of the weight from which a foot counts as loaded."""

_HEAD_RADIUS_M, _BONE_RADIUS_M = 0.105, 0.045


class LimitPaint:
    """Paints the links red whose joints are at a limit, and back."""

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription) -> None:
        self._model = model
        self._colours, self._materials = model.geom_rgba.copy(), model.geom_matid.copy()
        links = [int(model.jnt_bodyid[model.joint(name).id]) for name in robot.joint_names]
        self._geoms = [np.flatnonzero(model.geom_bodyid == link) for link in links]

    def apply(self, at_limit: Bools) -> None:
        """Show one frame's (J,) joints at their limits."""
        self._model.geom_rgba[:], self._model.geom_matid[:] = self._colours, self._materials
        for joint in np.flatnonzero(at_limit):
            self._model.geom_rgba[self._geoms[joint]] = AT_LIMIT
            self._model.geom_matid[self._geoms[joint]] = -1


def add_human(scene: mujoco.MjvScene, joints: Floats) -> None:
    """One pose (22, 3) of the human as limbs with a head."""
    for bone in BONES:
        if bone[1] != INDEX["head"]:
            add_rod(scene, joints[bone[0]], joints[bone[1]], radius=_BONE_RADIUS_M, colour=bone_colour(bone[1]))
    add_ball(scene, joints[INDEX["head"]], radius=_HEAD_RADIUS_M, colour=TRUNK)


def add_contacts(
    scene: mujoco.MjvScene,
    soles: Sequence[Floats],
    standing: Bools,
    force: Floats | None,
    *,
    size: float,
    weight: float,
) -> None:
    """A patch under each foot that should stand (orange while it bears nothing), and the floor's force as an arrow.

    Args:
        scene: the scene.
        soles: (4, 3) corners of each sole, m.
        standing: (F,) whether each foot should stand.
        force: (F,) N, or None.
        size: of the robot, m; an arrow of this length stands for twice its weight.
        weight: of the robot, N.
    """
    for foot, corners in enumerate(soles):
        load = None if force is None else float(force[foot])
        if standing[foot]:
            bare = load is not None and is_bare(load, weight=weight)
            _add_patch(scene, corners, UNLOADED if bare else STANDING, size=size)
        if load is not None and not is_bare(load, weight=weight):
            start, up = corners.mean(axis=0) * [1, 1, 0], np.array([0, 0, 0.5 * load / weight * size])
            _add(scene, mujoco.mjtGeom.mjGEOM_ARROW, FORCE, start, start + up, 0.02 * size)


def add_zmp(scene: mujoco.MjvScene, zmp: Floats, soles: Sequence[Floats], standing: Bools, *, size: float) -> None:
    """The support polygon as a line and the ZMP (2,) m as a ball: blue in the polygon, red outside of it."""
    if np.isnan(zmp).any():
        return
    corners = [sole[:, :2] for sole, stands in zip(soles, standing, strict=True) if stands]
    polygon = support_polygon(np.concatenate(corners)) if corners else None
    inside = polygon is not None and contains(polygon, zmp)
    if polygon is not None:
        lifted = np.column_stack([polygon, np.full(len(polygon), 0.004 * size)])
        for start, end in zip(lifted, np.roll(lifted, -1, axis=0), strict=True):
            add_rod(scene, start, end, radius=0.003 * size, colour=TRUNK)
    add_ball(scene, np.append(zmp, 0.0), radius=0.025 * size, colour=INSIDE if inside else OUTSIDE)


def is_bare(force: float, *, weight: float) -> bool:
    """Whether a foot with this force on it, N, bears next to nothing of a robot's weight, N."""
    return force < _LOADED * weight


def sole_patch(corners: Floats, *, margin: float) -> tuple[Floats, Floats, Floats]:
    """A rectangle on the floor around a sole: its centre (3,), half its sides (2,) with a margin in m, rotation (3, 3).

    Its first side runs along the longer one of the sole.
    """
    middle = corners.mean(axis=0) * [1, 1, 0]
    flat = corners[:, :2] - middle[:2]
    ahead = flat[np.argsort(np.linalg.norm(flat - flat[0], axis=1))[2]] - flat[0]
    angle = float(np.arctan2(ahead[1], ahead[0]))
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    return middle, np.abs(flat @ turn[:2, :2]).max(axis=0) + margin, turn


def support_polygon(points: Floats) -> Floats | None:
    """(n, 2) corners, anticlockwise, of the hull of points (m, 2); None where they span no area."""
    try:
        return points[ConvexHull(points).vertices]
    except QhullError:
        return None


def contains(polygon: Floats, point: Floats) -> bool:
    """Whether a convex polygon (n, 2), anticlockwise, holds a point (2,)."""
    edge, to_point = np.roll(polygon, -1, axis=0) - polygon, point - polygon
    return bool((edge[:, 0] * to_point[:, 1] - edge[:, 1] * to_point[:, 0] >= 0).all())


def add_ball(scene: mujoco.MjvScene, position: Floats, *, radius: float, colour: Colour) -> None:
    """A sphere at a position (3,) m."""
    _put(scene, mujoco.mjtGeom.mjGEOM_SPHERE, colour, np.full(3, radius), position, np.eye(3))


def add_rod(scene: mujoco.MjvScene, start: Floats, end: Floats, *, radius: float, colour: Colour) -> None:
    """A capsule from start to end, (3,) m each."""
    _add(scene, mujoco.mjtGeom.mjGEOM_CAPSULE, colour, start, end, radius)


def _add_patch(scene: mujoco.MjvScene, corners: Floats, colour: Colour, *, size: float) -> None:
    middle, half, turn = sole_patch(corners, margin=0.012 * size)
    _put(scene, mujoco.mjtGeom.mjGEOM_BOX, colour, np.append(half, 0.002 * size), middle, turn)


def _add(scene: mujoco.MjvScene, kind: int, colour: Colour, start: Floats, end: Floats, radius: float) -> None:
    geom = _put(scene, kind, colour, np.zeros(3), np.zeros(3), np.eye(3))
    if geom is not None:
        mujoco.mjv_connector(geom, kind, radius, start, end)


def _put(
    scene: mujoco.MjvScene, kind: int, colour: Colour, size: Floats, position: Floats, rotation: Floats
) -> "mujoco.MjvGeom | None":
    """The scene's next free geom, filled in; None where the scene is full."""
    if scene.ngeom >= scene.maxgeom:
        return None
    scene.ngeom += 1
    geom = scene.geoms[scene.ngeom - 1]
    mujoco.mjv_initGeom(geom, kind, size, position, rotation.ravel(), np.array(colour, np.float32))
    return geom


def bone_colour(joint: int) -> Colour:
    """The colour of the bone that ends in a joint: orange left, blue right, grey the trunk."""
    if joint in PARTS["backbone"]:
        return TRUNK
    return LEFT if joint in PARTS["left_arm"] or joint in PARTS["left_leg"] else RIGHT
