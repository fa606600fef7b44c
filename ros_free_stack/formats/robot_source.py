"""Robot trajectories from files that hold only a root and joint angles."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import mujoco
import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidMessage, InvalidOption
from ros_free_stack.formats.jumps import find_capture, jump_notes
from ros_free_stack.formats.rates import frame_rate
from ros_free_stack.formats.robot_floor import off_the_floor
from ros_free_stack.formats.robot_places import body_places, configurations
from ros_free_stack.formats.source import Angles, QuaternionOrder, Source, SourceOptions, Units, check_finite
from ros_free_stack.formats.span import frames_between
from ros_free_stack.formats.stature import METRES
from ros_free_stack.messages import Bools, Floats, RobotTrajectory
from ros_free_stack.robot_model import kinematic_model, standing_qpos
from ros_free_stack.robots import RobotDescription, load_robot

CONTACT_HEIGHT_M: Final = 0.02
CONTACT_SPEED: Final = 0.25
"""A foot stands while its lowest sole corner is below the height and its middle slower than this (m/s)."""

UNIT_NORM: Final = 0.01

OUTSIDE_RAD: Final = 1.0
"""So far outside of a joint's range no angle in rad is: it is in degrees, or of another joint."""

TOO_HIGH: Final = 4.0
"""A root this many times as high as in the standing pose is in another unit."""


@dataclass(frozen=True, kw_only=True)
class RobotArrays:
    """What a file says of a robot's motion.

    Attributes:
        root_pos: (T, 3).
        root_quat: (T, 4) in the given order, normalised later.
        order: of the quaternions.
        joint_pos: (T, J) in the order of the robot's joints.
        fps: frames a second that the file states, if it does.
        units, angles: those that the file names; None where it does not.
        notes: what the reader had to assume.
    """

    root_pos: Floats
    root_quat: Floats
    order: QuaternionOrder
    joint_pos: Floats
    fps: float | None
    units: Units | None = None
    angles: Angles | None = None
    notes: tuple[str, ...] = ()


def named_robot(path: Path, options: SourceOptions) -> RobotDescription:
    """The robot that `--robot` names; InvalidOption where it names none."""
    if options.robot is None:
        raise InvalidOption("--robot", f"name the robot of {path}: the file does not say which one moves")
    return load_robot(options.robot)


def robot_source(path: Path, options: SourceOptions, arrays: RobotArrays) -> Source:
    """A Source of the robot that `--robot` names; contacts come from the height and speed of its soles.

    Raises:
        InvalidOption: no robot was named, the rate cannot be, or a unit has to be named.
        InvalidFile: the arrays are no trajectory of that robot.
    """
    robot = named_robot(path, options)
    fps = frame_rate(path, arrays.fps, options.source_fps)
    quaternions = _checked(path, robot, arrays)
    span = frames_between(path, len(quaternions), fps, options)
    model = kinematic_model(robot)
    root_pos = METRES[_length_unit(path, robot, model, arrays, options)] * arrays.root_pos[span]
    joint_pos = _in_radians(path, robot, model, arrays, options)[span]
    qpos = configurations(model, robot, root_pos, quaternions[span], joint_pos)
    bodies, corners = body_places(model, robot, qpos)
    capture = find_capture(bodies, fps)
    notes = (*arrays.notes, *jump_notes(capture, len(qpos), fps))
    kept = slice(capture.start, capture.end)
    lowered, said = off_the_floor(corners[kept], lower=options.floor is True)
    corners[..., 2] -= lowered
    try:
        trajectory = RobotTrajectory(
            robot=robot.name,
            model_sha256=robot.sha256,
            joint_names=robot.joint_names,
            fps=fps,
            root_pos=root_pos[kept] - (0.0, 0.0, lowered),
            root_quat=quaternions[span][kept],
            joint_pos=joint_pos[kept],
            contacts=_contacts(corners[kept], fps),
            foot_names=robot.foot_names,
        )
    except InvalidMessage as error:
        raise InvalidFile(path, f"not a valid robot trajectory: {error}") from None
    return Source(trajectory, notes + said)


def _checked(path: Path, robot: RobotDescription, arrays: RobotArrays) -> Floats:
    """(T, 4) unit quaternions wxyz; InvalidFile where an array does not fit the robot."""
    shapes = {
        "root position": (arrays.root_pos, 3),
        "root rotation": (arrays.root_quat, 4),
        "joints": (arrays.joint_pos, len(robot.joints)),
    }
    for name, (values, width) in shapes.items():
        if values.ndim != 2 or values.shape != (len(arrays.root_pos), width) or not len(values):
            wanted = f"(T, {width})" + (f" for {robot.title}" if name == "joints" else "")
            raise InvalidFile(path, f"{name}: expected {wanted}, found {values.shape}")
        check_finite(path, name, values)
    norms = np.linalg.norm(arrays.root_quat, axis=1)
    worst = int(np.argmax(np.abs(norms - 1)))
    if abs(norms[worst] - 1) > UNIT_NORM:
        raise InvalidFile(path, f"frame {worst}: a root quaternion of length {norms[worst]:.3g}, expected 1")
    return (arrays.root_quat / norms[:, None])[:, (3, 0, 1, 2) if arrays.order == "xyzw" else (0, 1, 2, 3)]


def _length_unit(
    path: Path, robot: RobotDescription, model: mujoco.MjModel, arrays: RobotArrays, options: SourceOptions
) -> Units:
    """The unit of the root's positions: the user's, the file's, else metres where the root is not far too high."""
    unit = options.units or arrays.units
    if unit is not None or not robot.soles:
        return unit or "m"
    height = float(np.median(np.abs(arrays.root_pos[:, 2])))
    standing = float(standing_qpos(model, robot)[2])
    if height > TOO_HIGH * standing:
        raise InvalidOption(
            "--units",
            f"name the unit of lengths in {path} ({', '.join(METRES)}): the root is {height:.3g} high, "
            f"{standing:.2f} m when {robot.title} stands",
        )
    return "m"


def _in_radians(
    path: Path, robot: RobotDescription, model: mujoco.MjModel, arrays: RobotArrays, options: SourceOptions
) -> Floats:
    """(T, J) rad: by the user's word, the file's, else as they are where that can be."""
    hinges = np.array([int(model.joint(name).type[0]) == mujoco.mjtJoint.mjJNT_HINGE for name in robot.joint_names])
    angles = options.angles or arrays.angles
    if angles == "deg":
        return np.where(hinges, np.deg2rad(arrays.joint_pos), arrays.joint_pos)
    outside = np.maximum(robot.lower - arrays.joint_pos, arrays.joint_pos - robot.upper).max(axis=0)
    worst = int(np.argmax(np.where(hinges, outside, -np.inf)))
    if angles is None and hinges.any() and outside[worst] > OUTSIDE_RAD:
        reached = arrays.joint_pos[np.argmax(np.abs(arrays.joint_pos[:, worst])), worst]
        name, low, high = robot.joint_names[worst], robot.lower[worst], robot.upper[worst]
        raise InvalidOption(
            "--angles",
            f"name the unit of angles in {path} (rad or deg): {name} goes to {reached:.3g}, "
            f"its range is {low:.2f} to {high:.2f} rad",
        )
    return arrays.joint_pos


def _contacts(corners: Floats, fps: float) -> Bools:
    """(T, F) whether each foot stands, by `CONTACT_HEIGHT_M` and `CONTACT_SPEED`."""
    low = corners[..., 2].min(axis=-1) < CONTACT_HEIGHT_M
    if len(corners) == 1:
        return low
    speed = np.linalg.norm(np.gradient(corners.mean(axis=2), axis=0), axis=-1) * fps
    return low & (speed < CONTACT_SPEED)
