"""What a robot looks like in pictures: its meshes, thinned out so that software OpenGL keeps up, on a chequered floor.

Menagerie's meshes have up to a million faces; here vertices are merged on a grid of some millimetres and the result is
cached.
"""

import mujoco
import numpy as np

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import add_floor, kinematic_model, robot_spec, size_scale, standing_qpos
from ros_free_stack.robots import RobotDescription
from sim.model import cached_model, drop_meshes, replace_meshes

_CELL_M = 0.018
"""Vertices in one cell of this size (on G1) become one."""


def visual_model(robot: RobotDescription) -> mujoco.MjModel:
    """The robot's looks on a floor, meshes thinned out, from the cache where it is there."""
    return cached_model(robot, "looks-2", lambda: _visual_spec(robot))


def extent(model: mujoco.MjModel, robot: RobotDescription) -> tuple[float, float]:
    """Height in m of the lowest and the highest point of a visual model that stands."""
    data = mujoco.MjData(model)
    data.qpos[:] = standing_qpos(model, robot)
    mujoco.mj_kinematics(model, data)
    mine = model.geom_bodyid > 0
    up = data.geom_xmat[mine, 6:9]
    centre = data.geom_xpos[mine, 2] + (up * model.geom_aabb[mine, :3]).sum(axis=1)
    reach = (np.abs(up) * model.geom_aabb[mine, 3:]).sum(axis=1)
    return float((centre - reach).min()), float((centre + reach).max())


def _visual_spec(robot: RobotDescription) -> "mujoco.MjSpec":
    cell = _CELL_M * size_scale(robot, kinematic_model(robot))
    spec = robot_spec(robot)
    for geom in list(spec.geoms):
        if geom.contype or geom.conaffinity:
            spec.delete(geom)
    drop_meshes(spec, keep=lambda geom: True)
    replace_meshes(spec, lambda vertices, faces: merge_vertices(vertices, faces, cell))
    _light(spec)
    _lay_floor(spec)
    return spec


def _light(spec: "mujoco.MjSpec") -> None:
    """One lamp and the headlight in place of the model's own lamps: each costs a pass over all vertices."""
    for lamp in list(spec.lights):
        spec.delete(lamp)
    spec.worldbody.add_light(
        pos=[1, 1, 3], dir=[-0.5, 0.4, -1], diffuse=[0.6, 0.6, 0.6], castshadow=False,
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
    )  # fmt: skip
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.45, 0.45, 0.45]


def _lay_floor(spec: "mujoco.MjSpec") -> None:
    add_floor(spec)
    floor = spec.geom("floor")
    spec.add_texture(
        name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, builtin=mujoco.mjtBuiltin.mjBUILTIN_GRADIENT,
        rgb1=[0.93, 0.95, 0.98], rgb2=[0.75, 0.8, 0.87], width=64, height=384,
    )  # fmt: skip
    spec.add_texture(
        name="tiles", type=mujoco.mjtTexture.mjTEXTURE_2D, builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=[0.83, 0.86, 0.9], rgb2=[0.76, 0.8, 0.85], width=128, height=128,
    )  # fmt: skip
    tiles = spec.add_material(name="tiles", texrepeat=[4, 4], texuniform=True)
    tiles.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "tiles"
    floor.material = "tiles"


def merge_vertices(vertices: Floats, faces: np.ndarray, cell: float) -> tuple[Floats, np.ndarray]:
    """Merge the vertices (V, 3) that share a cubic cell of a grid and drop faces (F, 3) that collapse.

    Source: vertex clustering, Rossignac and Borrel 1993.
    """
    _, group, counts = np.unique(np.floor(vertices / cell).astype(int), axis=0, return_inverse=True, return_counts=True)
    group = group.ravel()
    merged = np.stack([np.bincount(group, weights=axis) for axis in vertices.T], axis=1) / counts[:, None]
    kept = group[faces]
    whole = (kept[:, 0] != kept[:, 1]) & (kept[:, 1] != kept[:, 2]) & (kept[:, 2] != kept[:, 0])
    kept = np.unique(_rolled(kept[whole]), axis=0)
    return (merged, kept) if len(kept) >= 4 else (vertices, faces)


def _rolled(faces: np.ndarray) -> np.ndarray:
    """Faces that begin with their smallest index, so that equal ones look equal."""
    start = np.argmin(faces, axis=1)
    return np.take_along_axis(faces, (start[:, None] + np.arange(3)) % 3, axis=1)
