"""Robot descriptions as data: one YAML a robot says where its model is and what the model leaves out.

A description names the MuJoCo model, how human joints map onto robot bodies, the soles, joint limits that the
model lacks, the standing pose and, where the robot has Dynamixel servos, the servo map.
"""

import hashlib
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import INDEX


@dataclass(frozen=True)
class Attachment:
    """A point fixed to a robot body: `offset` (3,) m in the body's frame."""

    body: str
    offset: tuple[float, float, float]


@dataclass(frozen=True)
class Sole:
    """The flat underside of a foot: `corners` (4, 3) m in the foot body's frame, and the human `ankle` above it."""

    body: str
    corners: tuple[tuple[float, float, float], ...]
    ankle: str


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` of the segment from `start` to `end`, (3,) m each in a body's frame."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float


@dataclass(frozen=True)
class JointLimits:
    """Limits of one joint: position range in rad, speed in rad/s, acceleration in rad/s^2, torque in N m."""

    lower: float
    upper: float
    velocity: float
    acceleration: float
    effort: float


@dataclass(frozen=True)
class ServoMap:
    """The robot's Dynamixel bus: servo model, baud rate, control cycle and the id of each joint's servo."""

    model: str
    baud: int
    cycle_s: float
    ids: dict[str, int]


@dataclass(frozen=True)
class RobotDescription:
    """One robot.

    Attributes:
        name: short name, as given to `--robot`.
        title: name for people.
        model_path: MJCF file.
        root_body: the floating base.
        torso_body: the body that carries the shoulders.
        torso_lean: share of the human torso's rotation against the pelvis that the torso body follows (1 for a
            robot with a waist, less for one whose torso and pelvis are one body).
        attachments: human joint name to the robot point that plays its part.
        soles: foot name to sole.
        capsules: body name to capsules that together cover the body's collision shapes.
        collision_pairs: pairs of bodies, each with capsules, that a motion must keep apart.
        joints: actuated joint name to limits, in the model's order.
        limits_source: where limits that the model lacks come from.
        standing: joint positions in rad of a stable standing pose; joints not named are 0.
        servos: the Dynamixel bus, or None.
        sha256: hash of the model file and of this description; trajectories and verdicts carry it.
    """

    name: str
    title: str
    model_path: Path
    root_body: str
    torso_body: str
    torso_lean: float
    attachments: dict[str, Attachment]
    soles: dict[str, Sole]
    capsules: dict[str, tuple[Capsule, ...]]
    collision_pairs: tuple[tuple[str, str], ...]
    joints: dict[str, JointLimits]
    limits_source: str
    standing: dict[str, float]
    servos: ServoMap | None
    sha256: str

    @property
    def joint_names(self) -> tuple[str, ...]:
        """J actuated joints, in the model's order; the order of every joint array."""
        return tuple(self.joints)

    @property
    def foot_names(self) -> tuple[str, ...]:
        return tuple(self.soles)

    @cached_property
    def lower(self) -> Floats:
        """(J,) lower joint limits, rad."""
        return np.array([limits.lower for limits in self.joints.values()])

    @cached_property
    def upper(self) -> Floats:
        """(J,) upper joint limits, rad."""
        return np.array([limits.upper for limits in self.joints.values()])

    @cached_property
    def velocity(self) -> Floats:
        """(J,) joint speed limits, rad/s."""
        return np.array([limits.velocity for limits in self.joints.values()])

    @cached_property
    def acceleration(self) -> Floats:
        """(J,) joint acceleration limits, rad/s^2."""
        return np.array([limits.acceleration for limits in self.joints.values()])

    @cached_property
    def effort(self) -> Floats:
        """(J,) joint torque limits, N m."""
        return np.array([limits.effort for limits in self.joints.values()])

    @cached_property
    def standing_pos(self) -> Floats:
        """(J,) standing pose, rad."""
        return np.array([self.standing.get(name, 0.0) for name in self.joints])


def robot_names() -> tuple[str, ...]:
    """Names of the robots that are described here."""
    folder = resources.files("ros_free_stack") / "robots"
    return tuple(sorted(item.name.removesuffix(".yaml") for item in folder.iterdir() if item.name.endswith(".yaml")))


def load_robot(name: str) -> RobotDescription:
    """The description of a robot by name.

    Raises:
        UnknownName: no such robot; lists the known ones.
        InvalidFile: its description or model file is damaged.
    """
    if name not in robot_names():
        raise UnknownName("robot", name, robot_names())
    with resources.as_file(resources.files("ros_free_stack") / "robots" / f"{name}.yaml") as path:
        return read_description(path)


def read_description(path: Path) -> RobotDescription:
    """Read a description file; InvalidFile where a field is missing or wrong."""
    try:
        text = path.read_text(encoding="utf-8")
        data = yaml.safe_load(text)
        model_path = _model_path(data["model"], path)
        capsules = _capsules(data.get("capsules", {}))
        return RobotDescription(
            name=data["name"],
            title=data["title"],
            model_path=model_path,
            root_body=data["root_body"],
            torso_body=data["torso_body"],
            torso_lean=float(data["torso_lean"]),
            attachments=_attachments(data["attachments"]),
            soles=_soles(data["soles"]),
            capsules=capsules,
            collision_pairs=_collision_pairs(data.get("collision_pairs", {}), capsules),
            joints=_joints(data["joints"]),
            limits_source=data["limits_source"],
            standing={joint: float(value) for joint, value in data["standing"].items()},
            servos=_servos(data.get("servos")),
            sha256=hashlib.sha256(model_path.read_bytes() + text.encode()).hexdigest(),
        )
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError) as error:
        raise InvalidFile(path, f"not a valid robot description ({type(error).__name__}: {error})") from None


def _model_path(model: dict[str, str], description: Path) -> Path:
    if "package" not in model:
        return (description.parent / model["file"]).resolve()
    return Path(str(resources.files(model["package"]))) / model["file"]


def _triple(values: list[Any]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _attachments(data: dict[str, Any]) -> dict[str, Attachment]:
    for joint in data:
        if joint not in INDEX:
            raise UnknownName("human joint", joint, INDEX)
    return {joint: Attachment(item["body"], _triple(item.get("offset", [0, 0, 0]))) for joint, item in data.items()}


def _soles(data: dict[str, Any]) -> dict[str, Sole]:
    return {
        foot: Sole(item["body"], tuple(_triple(corner) for corner in item["corners"]), item["ankle"])
        for foot, item in data.items()
    }


def _capsules(data: dict[str, Any]) -> dict[str, tuple[Capsule, ...]]:
    return {
        body: tuple(Capsule(_triple(item["start"]), _triple(item["end"]), float(item["radius"])) for item in items)
        for body, items in data.items()
    }


def _collision_pairs(data: dict[str, Any], bodies: Collection[str]) -> tuple[tuple[str, str], ...]:
    pairs = tuple((first, second) for first, others in data.items() for second in others)
    for body in dict.fromkeys(name for pair in pairs for name in pair):
        if body not in bodies:
            raise UnknownName("body with capsules", body, tuple(bodies))
    return pairs


def _joints(data: dict[str, Any]) -> dict[str, JointLimits]:
    return {
        joint: JointLimits(
            lower=float(item["range"][0]),
            upper=float(item["range"][1]),
            velocity=float(item["velocity"]),
            acceleration=float(item["acceleration"]),
            effort=float(item["effort"]),
        )
        for joint, item in data.items()
    }


def _servos(data: dict[str, Any] | None) -> ServoMap | None:
    if data is None:
        return None
    ids = {joint: int(number) for joint, number in data["ids"].items()}
    return ServoMap(data["model"], int(data["baud"]), float(data["cycle_s"]), ids)
