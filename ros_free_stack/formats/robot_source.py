"""Robot trajectories from files that hold only a root and joint angles."""

from pathlib import Path
from typing import Final

import mujoco
import numpy as np

from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.errors import InvalidFile, InvalidMessage, InvalidOption
from ros_free_stack.formats.frames import blend
from ros_free_stack.formats.rates import frame_rate
from ros_free_stack.formats.source import QuaternionOrder, Source, SourceOptions, check_finite
from ros_free_stack.messages import Bools, Floats, RobotTrajectory
from ros_free_stack.robot_model import joint_addresses, kinematic_model, sole_corners
from ros_free_stack.robots import RobotDescription, load_robot

CONTACT_HEIGHT_M: Final = 0.02
CONTACT_SPEED: Final = 0.25
"""A foot stands while its lowest sole corner is below the height and its middle slower than this (m/s)."""

UNIT_NORM: Final = 0.01


def robot_source(
    path: Path,
    options: SourceOptions,
    *,
    fps: float | None,
    root_pos: Floats,
    root_quat: Floats,
    order: QuaternionOrder,
    joint_pos: Floats,
    notes: tuple[str, ...] = (),
) -> Source:
    """A Source of the robot that `--robot` names; contacts come from the height and speed of its soles.

    Args:
        path: the file, for errors.
        options: the user's options.
        fps: frames a second that the file states, if it does.
        root_pos: (T, 3) m.
        root_quat: (T, 4) in the given order, normalised here.
        order: of the quaternions.
        joint_pos: (T, J) rad, in the order of the robot's joints.
        notes: what else the reader had to assume.

    Raises:
        InvalidOption: no robot was named, or the rate cannot be.
        InvalidFile: the arrays are no trajectory of that robot.
    """
    if options.robot is None:
        raise InvalidOption("--robot", f"name the robot of {path}: the file does not say which one moves")
    robot = load_robot(options.robot)
    fps = frame_rate(path, fps, options.source_fps)
    arrays = {"root position": (root_pos, 3), "root rotation": (root_quat, 4), "joints": (joint_pos, len(robot.joints))}
    for name, (values, width) in arrays.items():
        if values.ndim != 2 or values.shape != (len(root_pos), width) or not len(values):
            wanted = f"(T, {width})" + (f" for {robot.title}" if name == "joints" else "")
            raise InvalidFile(path, f"{name}: expected {wanted}, found {values.shape}")
        check_finite(path, name, values)
    norms = np.linalg.norm(root_quat, axis=1)
    worst = int(np.argmax(np.abs(norms - 1)))
    if abs(norms[worst] - 1) > UNIT_NORM:
        raise InvalidFile(path, f"frame {worst}: a root quaternion of length {norms[worst]:.3g}, expected 1")
    quaternions = (root_quat / norms[:, None])[:, (3, 0, 1, 2) if order == "xyzw" else (0, 1, 2, 3)]
    model = kinematic_model(robot)
    qpos = configurations(model, robot, root_pos, quaternions, joint_pos)
    try:
        trajectory = RobotTrajectory(
            robot=robot.name,
            model_sha256=robot.sha256,
            joint_names=robot.joint_names,
            fps=fps,
            root_pos=root_pos,
            root_quat=quaternions,
            joint_pos=joint_pos,
            contacts=_contacts(model, robot, qpos, fps),
            foot_names=robot.foot_names,
        )
    except InvalidMessage as error:
        raise InvalidFile(path, f"not a valid robot trajectory: {error}") from None
    return Source(trajectory, notes)


def configurations(
    model: mujoco.MjModel, robot: RobotDescription, root_pos: Floats, root_quat: Floats, joint_pos: Floats
) -> Floats:
    """(T, nq) MuJoCo configurations; joints that follow others are put where they belong."""
    addresses, _ = joint_addresses(model, robot)
    root = int(model.jnt_qposadr[model.body_jntadr[model.body(robot.root_body).id]])
    couplings = joint_couplings(model)
    qpos = np.tile(model.qpos0, (len(joint_pos), 1))
    qpos[:, root : root + 7] = np.concatenate([root_pos, root_quat], axis=1)
    qpos[:, addresses] = joint_pos
    for row in qpos:
        settle(model, couplings, row)
    return qpos


def resample_trajectory(trajectory: RobotTrajectory, fps: float) -> RobotTrajectory:
    """A trajectory at another frame rate: linear, the root's orientation by slerp, contacts of the frame before."""
    from scipy.spatial.transform import Rotation, Slerp  # pyright: ignore[reportMissingTypeStubs]

    before, after, part = blend(len(trajectory.joint_pos), fps=trajectory.fps, to=fps)

    def linear(values: Floats) -> Floats:
        return values[before] + part[:, None] * (values[after] - values[before])

    quaternions = trajectory.root_quat
    if len(quaternions) > 1:
        slerp = Slerp(np.arange(len(quaternions)), Rotation.from_quat(quaternions, scalar_first=True))
        quaternions = slerp(before + part).as_quat(scalar_first=True)
    return RobotTrajectory(
        robot=trajectory.robot,
        model_sha256=trajectory.model_sha256,
        joint_names=trajectory.joint_names,
        fps=fps,
        root_pos=linear(trajectory.root_pos),
        root_quat=quaternions,
        joint_pos=linear(trajectory.joint_pos),
        contacts=trajectory.contacts[before],
        foot_names=trajectory.foot_names,
    )


def _contacts(model: mujoco.MjModel, robot: RobotDescription, qpos: Floats, fps: float) -> Bools:
    """(T, F) whether each foot stands, by `CONTACT_HEIGHT_M` and `CONTACT_SPEED`."""
    data = mujoco.MjData(model)
    corners = np.zeros((len(qpos), len(robot.soles), 4, 3))
    for frame, row in enumerate(qpos):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        for foot, points in enumerate(sole_corners(model, data, robot).values()):
            corners[frame, foot] = points
    low = corners[..., 2].min(axis=-1) < CONTACT_HEIGHT_M
    if len(qpos) == 1:
        return low
    speed = np.linalg.norm(np.gradient(corners.mean(axis=2), axis=0), axis=-1) * fps
    return low & (speed < CONTACT_SPEED)
