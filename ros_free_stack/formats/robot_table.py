"""Robot trajectories as csv with a line of names: every column is found by its name, in any order.

Root: `x`, `root_pos_x`, `root_translateX` and the like; `qw`, `root_quat_x` and the like, or angles `roll`, `pitch`,
`yaw`, `root_rotateX` (about fixed axes, x first); joints by the robot's own names, with other endings too; a column of
times or of frame numbers. This project's own tables are such files. BONES-SEED writes centimetres, degrees, 120 fps.
"""

from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats.robot_csv import CSV_FPS
from ros_free_stack.formats.robot_names import (
    Column,
    angle_unit,
    joint_columns,
    length_unit,
    seconds_a_unit,
    understand_column,
)
from ros_free_stack.formats.robot_source import RobotArrays, named_robot, robot_source
from ros_free_stack.formats.source import Angles, Source, SourceOptions, Units
from ros_free_stack.formats.tables import Table, read_table, times_rate
from ros_free_stack.messages import Floats

SEED_FPS: Final = 120.0
_SEED: Final = {f"root_{part}{axis}" for part in ("translate", "rotate") for axis in "xyz"}
"""Columns by which BONES-SEED's tables are known."""


def read(path: Path, options: SourceOptions) -> Source:
    """The robot trajectory in a csv with names.

    Raises:
        InvalidFile: a column of the root or a joint is missing; the message names it.
        InvalidOption: no robot was named, or a unit has to be.
    """
    table = read_table(path)
    if not table.names:
        raise InvalidFile(path, "has no line of names")
    robot = named_robot(path, options)
    columns = [understand_column(name, robot.joint_names) for name in table.names]
    joints = [i for i, column in enumerate(columns) if column.part == "joint"]
    places, left = joint_columns(path, [columns[i].name for i in joints], robot)
    seed = {column.name for column in columns} >= _SEED
    units: Units | None = length_unit(columns) or ("cm" if seed else None)
    angles: Angles | None = angle_unit(columns) or ("deg" if seed else None)
    notes: tuple[str, ...] = ()
    if seed and options.units is None and options.angles is None:
        notes += ("columns of BONES-SEED: centimetres and degrees",)
    if left:
        notes += (f"columns left out: {', '.join(left[:8])}{', ...' if len(left) > 8 else ''}",)
    fps, said = _rate(path, table, columns, options, CSV_FPS if not seed else SEED_FPS)
    arrays = RobotArrays(
        root_pos=table.rows[:, _axes(path, table, columns, "position", "xyz")],
        root_quat=_quaternions(path, table, columns, options, options.angles or angles),
        order="wxyz",
        joint_pos=table.rows[:, [joints[i] for i in places]],
        fps=fps,
        units=units,
        angles=angles,
        notes=notes + said,
    )
    return robot_source(path, options, arrays)


def _quaternions(
    path: Path, table: Table, columns: list[Column], options: SourceOptions, angles: Angles | None
) -> Floats:
    """(T, 4) wxyz, from quaternions by name or from angles about the fixed axes x, y, z."""
    if any(column.part == "euler" for column in columns):
        turns = table.rows[:, _axes(path, table, columns, "euler", "xyz")]
        widest = float(np.abs(turns).max())
        if angles is None and widest > 2 * np.pi:
            problem = f"name the unit of angles in {path} (rad or deg): the root turns by {widest:.3g}"
            raise InvalidOption("--angles", problem)
        rotation = Rotation.from_euler("xyz", turns, degrees=angles == "deg")
        return np.asarray(rotation.as_quat(scalar_first=True))
    order = "".join(column.axis for column in columns if column.part == "quaternion")
    if options.quaternion not in (None, order):
        problem = f"the columns of {path} name the order {order}, found {options.quaternion}"
        raise InvalidOption("--quaternion", problem)
    return table.rows[:, _axes(path, table, columns, "quaternion", "wxyz")]


def _axes(path: Path, table: Table, columns: list[Column], part: str, axes: str) -> list[int]:
    """Where the axes of a part of the root stand."""
    found: list[int] = []
    for axis in axes:
        places = [i for i, column in enumerate(columns) if column.part == part and column.axis == axis]
        if len(places) != 1:
            named = ", ".join(table.names[i] for i in places)
            have = f"are {named}" if places else f"is none among {', '.join(table.names[:12])}, ..."
            raise InvalidFile(path, f"expected one column for {axis} of the root's {part}, there {have}")
        found.append(places[0])
    return found


def _rate(
    path: Path, table: Table, columns: list[Column], options: SourceOptions, usual: float
) -> tuple[float, tuple[str, ...]]:
    times = [i for i, column in enumerate(columns) if column.part == "time"]
    if times and options.source_fps is None and len(table.rows) > 1:
        return times_rate(path, seconds_a_unit(columns[times[0]]) * table.rows[:, times[0]]), ()
    if options.source_fps is not None:
        return options.source_fps, ()
    return usual, (f"csv states no frame rate: {usual:g} assumed (--source-fps)",)
