"""Robot trajectories as csv without names: a row a frame, root position, root quaternion, joint angles.

Unitree's LAFAN1 retargeting writes quaternions xyzw, Kimodo writes MuJoCo's wxyz; both at 30 fps, and nothing in the
files tells them apart. Joints come in the order of the robot's model. A column of times may stand before.
"""

from pathlib import Path
from typing import Final

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import write_text
from ros_free_stack.formats.robot_resample import resample_trajectory
from ros_free_stack.formats.robot_source import UNIT_NORM, RobotArrays, named_robot, robot_source
from ros_free_stack.formats.source import QuaternionOrder, Source, SourceOptions
from ros_free_stack.formats.tables import read_table, times_rate
from ros_free_stack.messages import Floats, RobotTrajectory

CSV_FPS: Final = 30.0


def read_unitree(path: Path, options: SourceOptions) -> Source:
    """The trajectory in a csv of Unitree's, quaternions xyzw."""
    return _read(path, options, "xyzw")


def read_kimodo(path: Path, options: SourceOptions) -> Source:
    """The trajectory in a csv of Kimodo's, quaternions wxyz."""
    return _read(path, options, "wxyz")


def write_unitree(path: Path, trajectory: RobotTrajectory) -> tuple[str, ...]:
    """Write a trajectory with quaternions xyzw, resampled to 30 fps."""
    return _write(path, trajectory, "xyzw")


def write_kimodo(path: Path, trajectory: RobotTrajectory) -> tuple[str, ...]:
    """Write a trajectory with quaternions wxyz, resampled to 30 fps."""
    return _write(path, trajectory, "wxyz")


def _read(path: Path, options: SourceOptions, order: QuaternionOrder) -> Source:
    if options.quaternion not in (None, order):
        raise InvalidOption("--quaternion", f"this format's order is {order}, found {options.quaternion}")
    table = read_table(path)
    if table.names:
        raise InvalidFile(path, "line 1: names of columns, expected numbers only; --format csv-names reads such files")
    rows, fps, notes = table.rows, CSV_FPS, ()
    if _has_times(rows, len(named_robot(path, options).joints)):
        fps, rows, notes = times_rate(path, rows[:, 0]), rows[:, 1:], ("the first column is taken for times in s",)
    elif options.source_fps is None:
        notes = (f"csv states no frame rate: {CSV_FPS:g} assumed (--source-fps)",)
    arrays = RobotArrays(
        root_pos=rows[:, :3], root_quat=rows[:, 3:7], order=order, joint_pos=rows[:, 7:], fps=fps, notes=notes
    )
    return robot_source(path, options, arrays)


def _has_times(rows: Floats, joints: int) -> bool:
    """Whether a column of times stands before a root and so many joints: it rises, and quaternions fit behind it."""
    if rows.shape[1] != 8 + joints or len(rows) < 2 or not (np.diff(rows[:, 0]) > 0).all():
        return False
    return bool((np.abs(np.linalg.norm(rows[:, 4:8], axis=1) - 1) < UNIT_NORM).all())


def _write(path: Path, trajectory: RobotTrajectory, order: QuaternionOrder) -> tuple[str, ...]:
    notes = (f"quaternions {order}",)
    if trajectory.fps != CSV_FPS:
        notes += (f"resampled from {trajectory.fps:g} to {CSV_FPS:g} fps, linearly and by slerp",)
        trajectory = resample_trajectory(trajectory, CSV_FPS)
    quaternions = trajectory.root_quat[:, (1, 2, 3, 0) if order == "xyzw" else (0, 1, 2, 3)]
    table = np.concatenate([trajectory.root_pos, quaternions, trajectory.joint_pos], axis=1)
    write_text(path, "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in table))
    return notes
