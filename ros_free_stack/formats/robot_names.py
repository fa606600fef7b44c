"""Columns and entries of robot trajectories by their names: which is the root's, which a joint's, and in which unit."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.source import Angles, Units
from ros_free_stack.robots import RobotDescription

Part = Literal["time", "frame", "position", "quaternion", "euler", "joint"]

_ROOT: Final = r"(?:(?:root|base|pelvis|floating_?base|free_?joint|world|trunk|body)(?:_?link|_?joint)?[_ .]*)?"
_PATTERNS: Final[tuple[tuple[Part, str], ...]] = (
    ("time", r"t|time|times|timestamp|timestamps|time_?sec|seconds|sec"),
    ("frame", r"|#|frame|frames|index|idx|step|frame_?(?:id|idx|index|number)|no|unnamed.*"),
    ("quaternion", _ROOT + r"(?:q|quat|quaternion|rot|rotation|orientation|orient|ori)[_ .]*(?P<axis>[wxyz])"),
    ("euler", _ROOT + r"(?:rotate|euler|rpy)[_ .]*(?P<axis>[xyz])"),
    ("euler", _ROOT + r"(?P<axis>roll|pitch|yaw)"),
    ("position", _ROOT + r"(?:p|pos|position|trans|translate|translation|t|location)?[_ .]*(?P<axis>[xyz])"),
)
_COMPILED: Final[tuple[tuple[Part, re.Pattern[str]], ...]] = tuple(
    (part, re.compile(pattern)) for part, pattern in _PATTERNS
)

_UNITS: Final[dict[str, Units]] = {"m": "m", "meter": "m", "meters": "m", "metres": "m", "cm": "cm", "mm": "mm"}
_ANGLES: Final[dict[str, Angles]] = {
    **dict.fromkeys(("rad", "rads", "radian", "radians"), "rad"),
    **dict.fromkeys(("deg", "degs", "degree", "degrees"), "deg"),
}
_SECONDS: Final = {"s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_TAIL: Final = re.compile(r"[ _]*[\[(]\s*([a-z]+)\s*[\])]$|[ _]([a-z]+)$")
_ENDINGS: Final = ("_dof", "_pos", "_position", "_q", "_angle", "_qpos", "_joint", "_jnt", "_link", "joint")
_STARTS: Final = ("joint_", "dof_", "q_", "jpos_", "pos_", "qpos_", "robot/", "joint/")


@dataclass(frozen=True)
class Column:
    """What a column holds: the part, its axis (of a part of the root), its unit where its name says it, its name."""

    part: Part
    axis: str
    unit: str
    name: str


def understand_column(name: str, joints: Sequence[str] = ()) -> Column:
    """What a column's name says; what is the name of one of the robot's joints is a joint."""
    if name.strip() in joints:
        return Column("joint", "", "", name.strip())
    plain = name.strip().strip('"').lstrip("# ").lower()
    unit = ""
    tail = _TAIL.search(plain)
    word = (tail.group(1) or tail.group(2)) if tail else ""
    if word in _UNITS or word in _ANGLES or word in _SECONDS:
        plain, unit = plain[: tail.start()] if tail else plain, word
    for part, pattern in _COMPILED:
        found = pattern.fullmatch(plain)
        if found:
            axis = found.groupdict().get("axis") or ""
            return Column(part, {"roll": "x", "pitch": "y", "yaw": "z"}.get(axis, axis), unit, plain)
    return Column("joint", "", unit, plain)


def length_unit(columns: Sequence[Column]) -> Units | None:
    """The unit that the root's positions name, if they do."""
    return next(
        (_UNITS[column.unit] for column in columns if column.part == "position" and column.unit in _UNITS), None
    )


def angle_unit(columns: Sequence[Column]) -> Angles | None:
    """The unit that angles name, if they do."""
    named = (column.unit for column in columns if column.part in ("joint", "euler") and column.unit in _ANGLES)
    return next((_ANGLES[unit] for unit in named), None)


def seconds_a_unit(column: Column) -> float:
    """Seconds a unit of a column of times."""
    return _SECONDS.get(column.unit, 1.0)


def joint_columns(path: Path, names: Sequence[str], robot: RobotDescription) -> tuple[list[int], list[str]]:
    """Where each of the robot's joints stands among names, and the names that are none of them.

    Names may lack or have more of the endings that programs give them (`_joint`, `_dof`, `_pos`).

    Raises:
        InvalidFile: a joint is missing, or two names are one joint's.
    """
    exact = {name.strip(): i for i, name in enumerate(names)}
    stems: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        stems.setdefault(_stem(name), []).append(i)
    found: list[int] = []
    missing: list[str] = []
    for joint in robot.joint_names:
        places = [exact[joint]] if joint in exact else stems.get(_stem(joint), [])
        if len(places) > 1:
            same = " and ".join(names[i].strip() for i in places)
            raise InvalidFile(path, f"{same} are both the joint {joint} of {robot.title}")
        if places:
            found.append(places[0])
        else:
            missing.append(joint)
    left = [name.strip() for i, name in enumerate(names) if i not in found]
    if missing:
        among = f"; other names: {', '.join(left[:12])}" if left else ""
        raise InvalidFile(path, f"has no joint {', '.join(missing[:6])} of {robot.title}{among}")
    return found, left


def _stem(name: str) -> str:
    stem = name.strip().strip('"').lower().replace("-", "_").replace(" ", "_").replace(".", "_")
    changed = True
    while changed:
        changed = False
        for ending in _ENDINGS:
            if stem.endswith(ending) and len(stem) > len(ending):
                stem, changed = stem.removesuffix(ending), True
        for start in _STARTS:
            if stem.startswith(start) and len(stem) > len(start):
                stem, changed = stem.removeprefix(start), True
    return stem.strip("_")
