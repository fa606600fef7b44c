"""From a robot description to a MuJoCo model, with the description's limits applied."""

import mujoco
import numpy as np
from numpy.typing import NDArray

from ros_free_stack.errors import InvalidFile
from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription

Indices = NDArray[np.intp]


def robot_spec(robot: RobotDescription, *, meshes: bool = True) -> mujoco.MjSpec:
    """The robot's model as an editable spec, joint ranges set from the description.

    Args:
        robot: the description.
        meshes: keep mesh geoms. Loading them takes seconds and kinematics needs none; without them inertias that
            the model states explicitly are unchanged.
    """
    try:
        spec = mujoco.MjSpec.from_file(str(robot.model_path))
    except ValueError as error:
        raise InvalidFile(robot.model_path, f"not a MuJoCo model ({error})") from None
    if not meshes:
        _strip_meshes(spec)
    for name, limits in robot.joints.items():
        joint = spec.joint(name)
        if joint is None:
            raise InvalidFile(robot.model_path, f"has no joint {name!r} that the description of {robot.name} names")
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = np.array([limits.lower, limits.upper])
    return spec


def _strip_meshes(spec: mujoco.MjSpec) -> None:
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH:
            spec.delete(geom)
    for mesh in list(spec.meshes):
        spec.delete(mesh)


def add_floor(spec: mujoco.MjSpec) -> None:
    """Put a plane named `floor` at z = 0 into the world."""
    floor = spec.worldbody.add_geom()
    floor.name = "floor"
    floor.type = mujoco.mjtGeom.mjGEOM_PLANE
    floor.size = np.array([0.0, 0.0, 0.05])


def kinematic_model(robot: RobotDescription) -> mujoco.MjModel:
    """The compiled model without meshes: quick to load, exact for kinematics and dynamics, blind to collisions."""
    return robot_spec(robot, meshes=False).compile()


def joint_addresses(model: mujoco.MjModel, robot: RobotDescription) -> tuple[Indices, Indices]:
    """(J,) indices into `qpos` and (J,) into `qvel` of the description's joints, by name."""
    joints = [model.joint(name) for name in robot.joint_names]
    return np.array([j.qposadr[0] for j in joints]), np.array([j.dofadr[0] for j in joints])


def standing_qpos(model: mujoco.MjModel, robot: RobotDescription) -> Floats:
    """(nq,) the standing pose with the lowest sole corner on the floor and the root above the origin."""
    positions, _ = joint_addresses(model, robot)
    data = mujoco.MjData(model)
    data.qpos[positions] = robot.standing_pos
    mujoco.mj_kinematics(model, data)
    data.qpos[2] -= min(float(corners[:, 2].min()) for corners in sole_corners(model, data, robot).values())
    return data.qpos.copy()


def sole_corners(model: mujoco.MjModel, data: mujoco.MjData, robot: RobotDescription) -> dict[str, Floats]:
    """World positions (4, 3) in m of each sole's corners, for the kinematics now in `data`."""
    corners: dict[str, Floats] = {}
    for foot, sole in robot.soles.items():
        body = data.body(sole.body)
        corners[foot] = body.xpos + np.array(sole.corners) @ body.xmat.reshape(3, 3).T
    return corners
