"""From a robot description to a MuJoCo model, with the description's limits applied."""

from pathlib import Path

import mujoco
import numpy as np
from numpy.typing import NDArray

from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.errors import InvalidFile, UnsupportedModel
from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription

Indices = NDArray[np.intp]

G1_STANDING_HEIGHT_M = 0.787
"""Height of G1's pelvis in its standing pose: the size that length and speed thresholds are stated for."""


def read_spec(path: Path) -> mujoco.MjSpec:
    """An MJCF file as an editable spec; InvalidFile where it is missing or MuJoCo refuses it."""
    if not path.is_file():
        raise InvalidFile(path, "no such model file")
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise InvalidFile(path, f"not a MuJoCo model ({_one_line(error)})") from None


def compiled_spec(spec: mujoco.MjSpec, path: Path) -> mujoco.MjModel:
    """The compiled spec of the model file `path`; InvalidFile where MuJoCo refuses it or misses one of its files."""
    try:
        return spec.compile()
    except ValueError as error:
        raise InvalidFile(path, f"MuJoCo cannot compile this model ({_one_line(error)})") from None


def robot_spec(robot: RobotDescription, *, meshes: bool = True) -> mujoco.MjSpec:
    """The robot's model as an editable spec, with a free root, joint ranges and locked joints from the description.

    A root that the model fixes to the world gets a free joint, so that every robot's configuration begins with the
    pose of its root; that of a robot with `mount: fixed` never moves.

    Args:
        robot: the description.
        meshes: keep mesh geoms and textures. Loading them takes seconds and kinematics needs none; without them
            inertias stay the same: meshes from which MuJoCo infers an inertia are kept.

    Raises:
        InvalidFile: the model is damaged, or lacks a body or joint that the description names.
        UnsupportedModel: the root cannot move freely.
    """
    spec = read_spec(robot.model_path)
    if not meshes:
        strip_meshes(spec)
    _check_bodies(spec, robot)
    _free_root(spec, robot)
    for name, limits in robot.joints.items():
        joint = _joint(spec, robot, name)
        joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.range = np.array([limits.lower, limits.upper]) / _unit(spec, joint)
    for name, angle in robot.locked.items():
        _lock(spec, _joint(spec, robot, name), angle)
    return spec


def strip_meshes(spec: mujoco.MjSpec) -> None:
    """Delete every mesh geom that adds nothing to an inertia, and all meshes and textures that are left without use."""
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH and not _makes_inertia(spec, geom):
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if (mesh.name or Path(mesh.file).stem) not in used:
            spec.delete(mesh)
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for texture in list(spec.textures):
        spec.delete(texture)


def add_floor(spec: mujoco.MjSpec) -> None:
    """Put a plane named `floor` at z = 0 into the world."""
    floor = spec.worldbody.add_geom()
    floor.name = "floor"
    floor.type = mujoco.mjtGeom.mjGEOM_PLANE
    floor.size = np.array([0.0, 0.0, 0.05])


def kinematic_model(robot: RobotDescription) -> mujoco.MjModel:
    """The compiled model without meshes: quick to load, exact for kinematics and dynamics, blind to collisions."""
    return compiled_spec(robot_spec(robot, meshes=False), robot.model_path)


def joint_addresses(model: mujoco.MjModel, robot: RobotDescription) -> tuple[Indices, Indices]:
    """(J,) indices into `qpos` and (J,) into `qvel` of the description's joints, by name."""
    joints = [model.joint(name) for name in robot.joint_names]
    return np.array([j.qposadr[0] for j in joints]), np.array([j.dofadr[0] for j in joints])


def standing_qpos(model: mujoco.MjModel, robot: RobotDescription) -> Floats:
    """(nq,) the standing pose: the lowest sole corner on the floor; a robot without soles where its model puts it."""
    positions, _ = joint_addresses(model, robot)
    data = mujoco.MjData(model)
    data.qpos[positions] = robot.standing_pos
    settle(model, joint_couplings(model), data.qpos)
    if robot.soles:
        mujoco.mj_kinematics(model, data)
        data.qpos[2] -= min(float(corners[:, 2].min()) for corners in sole_corners(model, data, robot).values())
    return data.qpos.copy()


def size_scale(robot: RobotDescription, model: mujoco.MjModel) -> float:
    """The robot's size against G1: standing height of the root over 0.787 m, at most 1.

    Rounded, so that every model of the robot, with meshes and without, gives the same limits.
    """
    return min(1.0, round(float(standing_qpos(model, robot)[2]) / G1_STANDING_HEIGHT_M, 4))


def sole_corners(model: mujoco.MjModel, data: mujoco.MjData, robot: RobotDescription) -> dict[str, Floats]:
    """World positions (4, 3) in m of each sole's corners, for the kinematics now in `data`."""
    corners: dict[str, Floats] = {}
    for foot, sole in robot.soles.items():
        body = data.body(sole.body)
        corners[foot] = body.xpos + np.array(sole.corners) @ body.xmat.reshape(3, 3).T
    return corners


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _makes_inertia(spec: mujoco.MjSpec, geom: mujoco.MjsGeom) -> bool:
    inferred = spec.compiler.inertiafromgeom
    body = geom.parent
    if inferred == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE or body.name == "world":
        return False
    if inferred == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_AUTO and body.explicitinertial:
        return False
    low, high = spec.compiler.inertiagrouprange
    massless = geom.mass == 0 or (np.isnan(geom.mass) and geom.density == 0)
    return low <= geom.group <= high and not massless


def _check_bodies(spec: mujoco.MjSpec, robot: RobotDescription) -> None:
    named = {
        "root_body": (robot.root_body,),
        "torso_body": (robot.torso_body,),
        "attachments": tuple(item.body for item in robot.attachments.values()),
        "soles": tuple(sole.body for sole in robot.soles.values()),
        "capsules": tuple(robot.capsules),
    }
    known = {body.name for body in spec.bodies}
    for entry, bodies in named.items():
        for body in bodies:
            if body not in known:
                raise InvalidFile(robot.path, f"{entry} names a body {body!r} that {robot.model_path.name} lacks")


def _joint(spec: mujoco.MjSpec, robot: RobotDescription, name: str) -> mujoco.MjsJoint:
    joint = spec.joint(name)
    if joint is None:
        raise InvalidFile(robot.path, f"names a joint {name!r} that {robot.model_path.name} lacks")
    return joint


def _free_root(spec: mujoco.MjSpec, robot: RobotDescription) -> None:
    root = spec.body(robot.root_body)
    kinds = [joint.type for joint in root.joints]
    if kinds == [mujoco.mjtJoint.mjJNT_FREE]:
        return
    if kinds or root.parent is None or root.parent.name != "world":
        raise UnsupportedModel(
            f"robot {robot.name}: its root body {robot.root_body!r} must be a child of the world with a free joint or "
            "none; put it into a body of its own"
        )
    for key in list(spec.keys):  # they hold poses without a free root
        spec.delete(key)
    root.add_freejoint()


def _unit(spec: mujoco.MjSpec, joint: mujoco.MjsJoint) -> float:
    """What the numbers that a spec has for a joint are in, in rad or m."""
    return np.pi / 180 if spec.compiler.degree and joint.type == mujoco.mjtJoint.mjJNT_HINGE else 1.0


def _lock(spec: mujoco.MjSpec, joint: mujoco.MjsJoint, angle: float) -> None:
    equality = spec.add_equality()
    equality.type = mujoco.mjtEq.mjEQ_JOINT
    equality.name1 = joint.name
    equality.data[:] = 0.0
    equality.data[0] = angle - joint.ref * _unit(spec, joint)
