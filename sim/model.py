"""The models that the judge simulates: real collision shapes, a floor, the robot's own servos.

MuJoCo collides a mesh as its convex hull, so only hull vertices are kept: contacts stay the same while the model
shrinks from a hundred megabytes to a few hundred kilobytes. The compiled model is cached, since reading the
meshes takes seconds.
"""

import hashlib
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import platformdirs
from scipy.spatial import ConvexHull

from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import atomic_path
from ros_free_stack.messages import Floats, Mount
from ros_free_stack.robot_model import add_floor, robot_spec, standing_qpos
from ros_free_stack.robots import RobotDescription

TIMESTEP_S = 0.002

NATURAL_FREQUENCY, DAMPING_RATIO = 2 * np.pi * 10.0, 2.0
"""Of the position loop that a bare motor gets, in rad/s and 1, on the inertia of its rotor alone (BeyondMimic, Liao et
al. 2025, choose the gains of G1's joints so): kp = J w^2, kd = 2 zeta J w."""

_CACHE_VERSION = "5"


def judging_model(robot: RobotDescription, *, mount: Mount = "free") -> mujoco.MjModel:
    """The robot on a floor (`free`) or with its root held in the air (`fixed`), compiled or from the cache.

    Collision geoms are the model's own, as convex hulls. Pairs of bodies that overlap in the standing pose by
    design never collide. Actuators have the description's torque limits, Dynamixels their speed-torque line.
    """
    return cached_model(robot, f"judging-{mount}", lambda: _judging_spec(robot, mount))


def cached_model(robot: RobotDescription, variant: str, build: Callable[[], "mujoco.MjSpec"]) -> mujoco.MjModel:
    """The compiled model of `build()`, kept in the user's cache under a hash of everything it depends on."""
    path = _cache_folder() / f"{robot.name}-{variant}-{_content_hash(robot)}.mjb"
    if path.is_file():
        try:
            return mujoco.MjModel.from_binary_path(str(path))
        except ValueError:  # written by a broken disk or another build of MuJoCo: build it anew
            path.unlink(missing_ok=True)
    model = build().compile()
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic_path(path) as temporary:
            mujoco.mj_saveModel(model, str(temporary))
    except (OSError, InvalidFile):  # a cache that cannot be written only costs time
        pass
    return model


def _cache_folder() -> Path:
    return platformdirs.user_cache_path("ros-free-stack")


def _content_hash(robot: RobotDescription) -> str:
    state = hashlib.sha256(f"{robot.sha256} {mujoco.__version__} {_CACHE_VERSION}".encode())
    folder = robot.model_path.parent
    for file in sorted(folder.rglob("*")):
        if file.is_file():
            state.update(f"{file.relative_to(folder)} {file.stat().st_size}".encode())
    return state.hexdigest()[:16]


def _judging_spec(robot: RobotDescription, mount: Mount) -> "mujoco.MjSpec":
    spec = robot_spec(robot)
    drop_meshes(spec, keep=lambda geom: bool(geom.contype or geom.conaffinity))
    replace_meshes(spec, _hull)
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    _limit_servos(spec, robot)
    for pair in _overlapping_by_design(spec.copy().compile(), robot):
        _exclude(spec, *pair)
    if mount == "free":
        add_floor(spec)
    else:
        _hold_root(spec, robot)
    return spec


def _limit_servos(spec: "mujoco.MjSpec", robot: RobotDescription) -> None:
    """Give actuators the description's torque limits, bare motors a position loop, Dynamixels their speed-torque line.

    A trajectory of angles moves position servos. Where a model has plain motors (H1), whose control is a torque, the
    robot's own drives close the loop, so the model gets one.

    The torque of such a servo falls from the stall torque at rest to nothing at its no-load speed. A force limit at
    the stall torque together with joint damping of stall torque over no-load speed is that line.
    """
    for actuator in spec.actuators:
        limits = robot.joints.get(actuator.target)
        if limits is None:
            continue
        actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        actuator.forcerange = np.array([-limits.effort, limits.effort])
        inertia = float(spec.joint(actuator.target).armature)
        if actuator.biastype == mujoco.mjtBias.mjBIAS_NONE and inertia > 0:
            _close_position_loop(actuator, inertia)
        if robot.servos is not None:
            joint = spec.joint(actuator.target)
            joint.damping = np.zeros_like(joint.damping)
            motor = robot.servos.motor
            joint.damping[0] = limits.effort / (motor.no_load_speed if motor else limits.velocity)


def _close_position_loop(actuator: "mujoco.MjsActuator", inertia: float) -> None:
    kp, kd = inertia * NATURAL_FREQUENCY**2, 2 * DAMPING_RATIO * inertia * NATURAL_FREQUENCY
    actuator.gaintype, actuator.biastype = mujoco.mjtGain.mjGAIN_FIXED, mujoco.mjtBias.mjBIAS_AFFINE
    actuator.gainprm[0] = kp
    actuator.biasprm[:3] = [0.0, -kp, -kd]
    actuator.gear[0] = 1.0
    actuator.ctrllimited = mujoco.mjtLimited.mjLIMITED_FALSE


def _hold_root(spec: "mujoco.MjSpec", robot: RobotDescription) -> None:
    """Fix the root to the world, where MuJoCo no longer takes it for its neighbours' parent."""
    root = spec.body(robot.root_body)
    for key in list(spec.keys):  # they hold a pose of the free root
        spec.delete(key)
    for joint in root.joints:
        spec.delete(joint)
    for child in root.bodies:
        _exclude(spec, root.name, child.name)


def _exclude(spec: "mujoco.MjSpec", first: str, second: str) -> None:
    exclude = spec.add_exclude()
    exclude.bodyname1, exclude.bodyname2 = first, second


def drop_meshes(spec: "mujoco.MjSpec", *, keep: Callable[["mujoco.MjsGeom"], bool]) -> None:
    """Delete mesh geoms that `keep` refuses, and every mesh that nothing uses any more."""
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH and not keep(geom):
            spec.delete(geom)
    used = {geom.meshname for geom in spec.geoms}
    for mesh in list(spec.meshes):
        if mesh_name(mesh) not in used:
            spec.delete(mesh)


def mesh_name(mesh: "mujoco.MjsMesh") -> str:
    """The name that geoms use for a mesh: its own, else its file's."""
    return mesh.name or Path(mesh.file).stem


def replace_meshes(
    spec: "mujoco.MjSpec", simplify: Callable[[Floats, np.ndarray], tuple[Floats, np.ndarray | None]]
) -> None:
    """Replace each mesh's vertices (V, 3) and faces (F, 3) by what `simplify` makes of them."""
    model = spec.copy().compile()  # compiling fills the meshes of a spec for good
    for mesh in spec.meshes:
        name = mesh_name(mesh)
        index = model.mesh(name).id
        start, count = model.mesh_vertadr[index], model.mesh_vertnum[index]
        first_face, faces = model.mesh_faceadr[index], model.mesh_facenum[index]
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, model.mesh_quat[index])
        # The compiler moves a mesh into its inertial frame; its own frame is where geoms expect it.
        vertices = model.mesh_vert[start : start + count] @ rotation.reshape(3, 3).T + model.mesh_pos[index]
        vertices, kept = simplify(vertices, model.mesh_face[first_face : first_face + faces])
        mesh.name, mesh.file = name, ""
        mesh.scale = np.ones(3)
        mesh.uservert = np.ascontiguousarray(vertices, dtype=float).ravel()
        if kept is not None:
            mesh.userface = np.ascontiguousarray(kept, dtype=np.int32).ravel()


def _hull(vertices: Floats, faces: np.ndarray) -> tuple[Floats, None]:
    del faces  # MuJoCo spans the hull anew from its vertices
    return vertices[ConvexHull(vertices).vertices], None


def _overlapping_by_design(model: mujoco.MjModel, robot: RobotDescription) -> set[tuple[str, str]]:
    """Pairs of bodies whose collision shapes overlap in the standing pose, where the real ones do not."""
    data = mujoco.MjData(model)
    data.qpos[:] = standing_qpos(model, robot)
    mujoco.mj_fwdPosition(model, data)
    pairs = {tuple(sorted(int(model.geom_bodyid[g]) for g in contact.geom)) for contact in data.contact}
    return {(model.body(first).name, model.body(second).name) for first, second in pairs}
