"""Robot trajectories as csv without header: a row a frame, root position (m), root quaternion, joint angles (rad).

Unitree's LAFAN1 retargeting writes quaternions xyzw, Kimodo writes MuJoCo's wxyz; both at 30 fps, and nothing in the
files tells them apart. Joints come in the order of the robot's model.
"""

from pathlib import Path
from typing import Final

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import write_text
from ros_free_stack.formats.robot_source import resample_trajectory, robot_source
from ros_free_stack.formats.source import QuaternionOrder, Source, SourceOptions
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
    table = _table(path)
    notes = () if options.source_fps else (f"csv states no frame rate: {CSV_FPS:g} assumed (--source-fps)",)
    return robot_source(
        path,
        options,
        fps=CSV_FPS,
        root_pos=table[:, :3],
        root_quat=table[:, 3:7],
        order=order,
        joint_pos=table[:, 7:],
        notes=notes,
    )


def _table(path: Path) -> Floats:
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InvalidFile(path, "is not text") from None
    rows = [(number, line.split(",")) for number, line in enumerate(lines, start=1) if line.strip()]
    if not rows:
        raise InvalidFile(path, "no frames")
    width = len(rows[0][1])
    table = np.empty((len(rows), width))
    for row, (number, words) in zip(table, rows, strict=True):
        if len(words) != width:
            raise InvalidFile(path, f"line {number}: expected {width} numbers, found {len(words)} (truncated?)")
        try:
            row[:] = [float(word) for word in words]
        except ValueError as error:
            raise InvalidFile(path, f"line {number}: {error}; expected numbers and no header") from None
        if not np.isfinite(row).all():
            raise InvalidFile(path, f"line {number}: a value that is not finite")
    return table


def _write(path: Path, trajectory: RobotTrajectory, order: QuaternionOrder) -> tuple[str, ...]:
    notes = (f"quaternions {order}",)
    if trajectory.fps != CSV_FPS:
        notes += (f"resampled from {trajectory.fps:g} to {CSV_FPS:g} fps, linearly and by slerp",)
        trajectory = resample_trajectory(trajectory, CSV_FPS)
    quaternions = trajectory.root_quat[:, (1, 2, 3, 0) if order == "xyzw" else (0, 1, 2, 3)]
    table = np.concatenate([trajectory.root_pos, quaternions, trajectory.joint_pos], axis=1)
    write_text(path, "".join(",".join(f"{value:.9g}" for value in row) + "\n" for row in table))
    return notes
