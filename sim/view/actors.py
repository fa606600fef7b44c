"""What stands on a browser viewer's floor: each actor puts its parts there once and moves them to a frame."""

from typing import Any, Protocol

import mujoco
import numpy as np
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import sole_corners
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import BONES, INDEX
from sim.draw.appearance import extent
from sim.draw.markers import (
    AT_LIMIT,
    INSIDE,
    OUTSIDE,
    STANDING,
    UNLOADED,
    Colour,
    bone_colour,
    contains,
    is_bare,
    sole_patch,
    support_polygon,
)
from sim.draw.playback_frames import Film
from sim.draw.shapes import geom_points, sphere

Rgb = tuple[int, int, int]

GHOST: Rgb = (37, 99, 235)
_GHOST_OPACITY = 0.3
_DIRECTIONS = 100
_BONE_RADIUS_M, _HEAD_RADIUS_M = 0.045, 0.105


class Actor(Protocol):
    """Something that can be shown at a frame, or hidden."""

    def show(self, frame: int) -> None: ...

    def set_visible(self, visible: bool) -> None: ...


class RobotActor:
    """A robot in some poses; as a ghost pale blue, else red where joints are at their limits.

    Args:
        scene: viser's scene.
        name: of its root node.
        model: the visual model.
        robot: the robot.
        qpos: (N, nq) poses.
        at_limit: (N, J) joints to paint red; None makes a ghost.
    """

    def __init__(
        self,
        scene: Any,
        name: str,
        model: mujoco.MjModel,
        robot: RobotDescription,
        qpos: Floats,
        at_limit: np.ndarray | None,
    ) -> None:
        self._model, self._data, self._qpos, self._at_limit = model, mujoco.MjData(model), qpos, at_limit
        self._root = scene.add_frame(f"/{name}", show_axes=False)
        self.bodies = {
            body: scene.add_frame(f"/{name}/{body}", show_axes=False)
            for body in sorted({int(body) for body in model.geom_bodyid if body > 0})
        }
        self._links = [int(model.jnt_bodyid[model.joint(joint).id]) for joint in robot.joint_names]
        self._meshes: dict[int, list[tuple[Any, Rgb]]] = {body: [] for body in self.bodies}
        for geom in range(model.ngeom):
            body = int(model.geom_bodyid[geom])
            if body in self.bodies:
                colour = GHOST if at_limit is None else _colour(model, geom)
                vertices, faces = _mesh(model, geom)
                handle = scene.add_mesh_simple(
                    f"/{name}/{body}/{geom}", vertices, faces, color=colour, flat_shading=True, side="double",
                    opacity=_GHOST_OPACITY if at_limit is None else None, cast_shadow=at_limit is not None,
                )  # fmt: skip
                self._meshes[body].append((handle, colour))
        self._red: frozenset[int] = frozenset()

    def show(self, frame: int) -> None:
        self._data.qpos[:] = self._qpos[frame]
        mujoco.mj_kinematics(self._model, self._data)
        for body, node in self.bodies.items():
            node.position, node.wxyz = self._data.xpos[body], self._data.xquat[body]
        if self._at_limit is not None:
            red = frozenset(self._links[joint] for joint in np.flatnonzero(self._at_limit[frame]))
            for body in (red ^ self._red) & self.bodies.keys():
                for handle, colour in self._meshes[body]:
                    handle.color = _rgb(AT_LIMIT) if body in red else colour
            self._red = red

    def set_visible(self, visible: bool) -> None:
        self._root.visible = visible


class ContactActor:
    """Patches under feet that should stand, and the ZMP: blue within the support polygon, red outside of it."""

    def __init__(self, scene: Any, model: mujoco.MjModel, robot: RobotDescription, film: Film) -> None:
        self._model, self._robot, self._film, self._data = model, robot, film, mujoco.MjData(model)
        low, high = extent(model, robot)
        self._weight = float(model.body_subtreemass[0] * -model.opt.gravity[2])
        size = high - low
        mujoco.mj_kinematics(model, self._data)
        soles = sole_corners(model, self._data, robot)
        self._root = scene.add_frame("/contacts", show_axes=False)
        self.patches: list[Any] = []
        self._margin = 0.012 * size
        for foot, corners in soles.items():
            _, half, _ = sole_patch(corners, margin=self._margin)
            sides = (2 * float(half[0]), 2 * float(half[1]), 0.004 * size)
            self.patches.append(scene.add_box(f"/contacts/{foot}", dimensions=sides, color=_rgb(STANDING)))
        self.ball = scene.add_icosphere("/contacts/zmp", radius=0.02 * size, color=_rgb(INSIDE))

    def show(self, frame: int) -> None:
        film = self._film
        self._data.qpos[:] = film.qpos[frame]
        mujoco.mj_kinematics(self._model, self._data)
        soles = list(sole_corners(self._model, self._data, self._robot).values())
        for foot, (patch, corners) in enumerate(zip(self.patches, soles, strict=True)):
            patch.visible = bool(film.standing[frame, foot])
            middle, _, turn = sole_patch(corners, margin=self._margin)
            patch.position, patch.wxyz = middle, Rotation.from_matrix(turn).as_quat(scalar_first=True)
            bare = film.force is not None and is_bare(float(film.force[frame, foot]), weight=self._weight)
            patch.color = _rgb(UNLOADED if bare else STANDING)
        self._show_zmp(
            film.zmp[frame], [sole for sole, stands in zip(soles, film.standing[frame], strict=True) if stands]
        )

    def _show_zmp(self, zmp: Floats, soles: list[Floats]) -> None:
        self.ball.visible = not bool(np.isnan(zmp).any())
        if self.ball.visible:
            polygon = support_polygon(np.concatenate(soles)[:, :2]) if soles else None
            inside = polygon is not None and contains(polygon, zmp)
            self.ball.position, self.ball.color = np.append(zmp, 0.0), _rgb(INSIDE if inside else OUTSIDE)

    def set_visible(self, visible: bool) -> None:
        self._root.visible = visible


class HumanActor:
    """The human of (N, 22, 3) joints in m, `aside` (3,) m from where it is, limbs as thick as `scale` says."""

    def __init__(self, scene: Any, joints: Floats, *, aside: Floats, scale: float) -> None:
        from trimesh.creation import capsule

        self._joints = joints
        self._root = scene.add_frame("/human", show_axes=False, position=aside)
        self.bones: dict[tuple[int, int], Any] = {}
        for first, second in BONES:
            if second == INDEX["head"]:
                continue
            length = float(np.linalg.norm(joints[:, second] - joints[:, first], axis=1).mean())
            shape = capsule(height=length, radius=scale * _BONE_RADIUS_M, count=(10, 10))
            centred = shape.vertices - shape.bounds.mean(axis=0)
            self.bones[first, second] = scene.add_mesh_simple(
                f"/human/{second}", centred, shape.faces, color=_rgb(bone_colour(second))
            )
        self.head = scene.add_icosphere(
            "/human/head", radius=scale * _HEAD_RADIUS_M, color=_rgb(bone_colour(INDEX["head"]))
        )

    def show(self, frame: int) -> None:
        pose = self._joints[frame]
        for (first, second), handle in self.bones.items():
            along = pose[second] - pose[first]
            handle.position, handle.wxyz = pose[first] + along / 2, _turned_up(along)
        self.head.position = pose[INDEX["head"]]

    def set_visible(self, visible: bool) -> None:
        self._root.visible = visible


def _turned_up(along: Floats) -> Floats:
    """(4,) a rotation, wxyz, that turns z along a vector (3,)."""
    length = float(np.linalg.norm(along))
    half = np.array([along[2] + length, -along[1], along[0], 0.0])  # the quaternion between two vectors, not yet unit
    size = float(np.linalg.norm(half))
    return half / size if size > 1e-9 else np.array([0.0, 1.0, 0.0, 0.0])


def _mesh(model: mujoco.MjModel, geom: int) -> tuple[Floats, np.ndarray]:
    """A geom's vertices (V, 3) in its body's frame and faces (F, 3)."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
        start = int(model.mesh_vertadr[mesh])
        points = model.mesh_vert[start : start + model.mesh_vertnum[mesh]].astype(float)
        faces = model.mesh_face[first : first + count]
    else:
        points = geom_points(model, geom, sphere(_DIRECTIONS))
        faces = ConvexHull(points).simplices
    return points @ rotation.reshape(3, 3).T + model.geom_pos[geom], faces


def _colour(model: mujoco.MjModel, geom: int) -> Rgb:
    material = int(model.geom_matid[geom])
    red, green, blue, _ = model.geom_rgba[geom] if material < 0 else model.mat_rgba[material]
    return _rgb((float(red), float(green), float(blue), 1.0))


def _rgb(colour: Colour) -> Rgb:
    red, green, blue = (round(255 * part) for part in colour[:3])
    return red, green, blue
