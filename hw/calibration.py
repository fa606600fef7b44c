"""Calibration as data: for each joint its servo's id, sense, zero and range, kept as YAML."""

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from ros_free_stack.errors import InvalidFile, ModelMismatch
from ros_free_stack.files import write_text
from ros_free_stack.robots import RobotDescription

_LONGEST = 1_000_000


@dataclass(frozen=True)
class JointCalibration:
    """One joint.

    Attributes:
        id: servo id.
        direction: 1, or -1 where the servo turns against the joint.
        offset: servo angle at joint angle 0, rad.
        lower, upper: measured joint range, rad.
    """

    id: int
    direction: int = 1
    offset: float = 0.0
    lower: float = -math.pi
    upper: float = math.pi


@dataclass(frozen=True)
class Calibration:
    """Calibration of one robot, or of the joints that a partial rig has."""

    robot: str
    joints: dict[str, JointCalibration]

    @classmethod
    def neutral(cls, robot: RobotDescription) -> "Calibration":
        """Servos mounted as the description has them: same sense, same zero."""
        ids = robot.servos.ids if robot.servos else {}
        return cls(robot.name, {joint: JointCalibration(number) for joint, number in ids.items()})

    def save(self, path: Path) -> None:
        """Write as YAML."""
        data = {"robot": self.robot, "joints": {name: asdict(joint) for name, joint in self.joints.items()}}
        write_text(path, "# Servo calibration; angles in rad.\n" + yaml.safe_dump(data, sort_keys=False))


def load_calibration(path: Path, robot: RobotDescription) -> Calibration:
    """Read a calibration and check it against the robot.

    Raises:
        InvalidFile: not a calibration.
        ModelMismatch: it is another robot's, its ids differ from the robot's servo map, or a joint has no room to move
            between its measured ends and the robot's own range.
    """
    try:
        data: dict[str, Any] = yaml.load(_text(path), _DistinctNames)
        calibration = Calibration(data["robot"], {name: _joint(name, item) for name, item in data["joints"].items()})
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError, RecursionError) as error:
        problem = " ".join(f"{type(error).__name__}: {error}".split())
        raise InvalidFile(path, f"not a servo calibration ({problem})") from None
    expected = robot.servos.ids if robot.servos else {}
    odd = [
        name
        for name, joint in calibration.joints.items()
        if expected.get(name) != joint.id
        or max(joint.lower, robot.joints[name].lower) >= min(joint.upper, robot.joints[name].upper)
    ]
    if calibration.robot != robot.name or odd:
        raise ModelMismatch(
            f"{path}: calibration of {calibration.robot} does not fit {robot.name}"
            + (f"; joints that differ in id or range: {', '.join(sorted(odd))}" if odd else "")
        )
    return calibration


class _DistinctNames(yaml.SafeLoader):
    """A name that stands twice would count the second time alone; references to other parts have no use here."""

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        if self.check_event(yaml.AliasEvent):
            raise ValueError("references (*name) are not taken")
        return super().compose_node(parent, index)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        names = [self.construct_object(key, deep=True) for key, _ in node.value]  # pyright: ignore[reportUnknownMemberType]
        for name in names:
            if names.count(name) > 1:
                raise ValueError(f"{name!r} stands there twice")
        return super().construct_mapping(node, deep)


def _text(path: Path) -> str:
    """A file's text; no device, no pipe, nothing longer than a calibration can be."""
    if path.exists() and not path.is_file():
        raise ValueError("it is no file")
    if path.stat().st_size > _LONGEST:
        raise ValueError(f"it is longer than {_LONGEST} bytes")
    return path.read_text(encoding="utf-8")


def _joint(name: str, item: dict[str, Any]) -> JointCalibration:
    return JointCalibration(
        id=_whole(name, item, "id", range(253)),
        direction=_whole(name, item, "direction", (1, -1)),
        offset=_angle(name, item, "offset"),
        **_range(name, item),
    )


def _whole(name: str, item: dict[str, Any], entry: str, choices: range | tuple[int, ...]) -> int:
    value = item[entry]
    if type(value) is not int or value not in choices:
        words = f"{choices[0]} to {choices[-1]}" if isinstance(choices, range) else " or ".join(map(str, choices))
        raise ValueError(f"{name}: expected {entry} {words}, found {value!r}")
    return value


def _angle(name: str, item: dict[str, Any], entry: str) -> float:
    value = item[entry]
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"{name}: expected a finite {entry} in rad, found {value!r}")
    return float(value)


def _range(name: str, item: dict[str, Any]) -> dict[str, float]:
    ends = {entry: _angle(name, item, entry) for entry in ("lower", "upper")}
    if not ends["lower"] < ends["upper"]:
        raise ValueError(f"{name}: expected lower < upper, found {ends['lower']:g} and {ends['upper']:g}")
    return ends
