"""Calibration as data: for each joint its servo's id, sense, zero and range, kept as YAML."""

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import yaml

from ros_free_stack.errors import InvalidFile, ModelMismatch
from ros_free_stack.files import write_text
from ros_free_stack.robots import RobotDescription


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
        data: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8"))
        calibration = Calibration(data["robot"], {name: _joint(name, item) for name, item in data["joints"].items()})
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InvalidFile(path, f"not a servo calibration ({type(error).__name__}: {error})") from None
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


def _joint(name: str, item: dict[str, Any]) -> JointCalibration:
    joint = JointCalibration(
        id=int(item["id"]),
        direction=int(item["direction"]),
        offset=float(item["offset"]),
        lower=float(item["lower"]),
        upper=float(item["upper"]),
    )
    if joint.direction not in (-1, 1) or not joint.lower < joint.upper or not math.isfinite(joint.offset):
        raise ValueError(f"{name}: expected direction 1 or -1, a finite offset and lower < upper, found {joint}")
    return joint
