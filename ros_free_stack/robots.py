"""Robot descriptions as data: one YAML a robot says where its model is and what the model leaves out.

A description names the MuJoCo model, how human joints map onto robot bodies, the soles, joint limits that the
model lacks, the standing pose and, where the robot has Dynamixel servos, the servo map.
"""

import hashlib
import math
from collections.abc import Collection
from dataclasses import dataclass, field, fields
from functools import cached_property
from importlib import resources
from pathlib import Path
from typing import Any, Literal, TypeVar, get_args

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


ServoMode = Literal["position", "extended position", "current-based position"]
StopPolicy = Literal["off", "hold"]

WATCHDOG_MAX_S = 2.54


@dataclass(frozen=True)
class ServoSettings:
    """How the robot wants its servos set up; None leaves a register as it is.

    Attributes:
        mode: operating mode.
        p_gain, i_gain, d_gain: of the position controller, in the firmware's units.
        profile_velocity: rad/s; 0 for none, so that a servo follows each goal at once.
        profile_acceleration: rad/s^2; 0 for none.
        current_limit: A, for the models that measure current.
    """

    mode: ServoMode = "position"
    p_gain: int | None = None
    i_gain: int | None = None
    d_gain: int | None = None
    profile_velocity: float = 0.0
    profile_acceleration: float = 0.0
    current_limit: float | None = None


@dataclass(frozen=True)
class ServoSafety:
    """What stops a stream to the servos, and how it stops.

    Attributes:
        temperature: deg C.
        voltage: V; None takes each servo's own minimum.
        current: A, for longer than `current_s`.
        load: share of full load, for longer than `current_s`, of servos that measure no current.
        current_s: s.
        following_error: rad between goal and measured angle, for longer than `following_s`.
        following_s: s.
        lost_after: readings in a row that a servo may miss.
        late_after: cycles in a row that may begin more than one period late.
        stall_s: longest pause of the computer, s.
        watchdog_s: silence after which the servos stop by themselves, s (20 ms steps, at most 2.54 s).
        ramp_speed: rad/s towards the first frame.
        hold_s: s of holding still before the torque goes off.
        on_fault: whether the servos go limp or hold after a fault or an interrupt.
    """

    temperature: float = 70.0
    voltage: float | None = None
    current: float = 2.0
    load: float = 0.9
    current_s: float = 0.5
    following_error: float = 0.5
    following_s: float = 0.25
    lost_after: int = 12
    late_after: int = 25
    stall_s: float = 0.5
    watchdog_s: float = 0.2
    ramp_speed: float = 1.0
    hold_s: float = 0.3
    on_fault: StopPolicy = "off"

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if item.name == "on_fault":
                if value not in get_args(StopPolicy):
                    raise UnknownName("servo_safety on_fault", str(value), get_args(StopPolicy))
            elif value is not None and not (isinstance(value, int | float) and 0 < value < math.inf):
                raise ValueError(f"servo_safety {item.name}: expected a positive number, found {value!r}")
        if self.watchdog_s > WATCHDOG_MAX_S:
            raise ValueError(f"servo_safety watchdog_s: expected at most {WATCHDOG_MAX_S} s, found {self.watchdog_s}")


@dataclass(frozen=True)
class ServoMap:
    """The robot's Dynamixel servos.

    Attributes:
        model: servo model of every joint that `models` does not name.
        baud: bits a second.
        cycle_s: control cycle, s.
        ids: joint name to servo id; distinct, also where the robot has several ports.
        models: joint name to servo model, where it is another one.
        settings: how the servos are set up.
        safety: what stops a stream.
    """

    model: str
    baud: int
    cycle_s: float
    ids: dict[str, int]
    models: dict[str, str] = field(default_factory=dict[str, str])
    settings: ServoSettings = ServoSettings()
    safety: ServoSafety = ServoSafety()

    def model_of(self, joint: str) -> str:
        """The servo model of a joint."""
        return self.models.get(joint, self.model)


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


Section = TypeVar("Section", ServoSettings, ServoSafety)


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
            servos=_servos(data, data["joints"]),
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


def _servos(data: dict[str, Any], joints: Collection[str]) -> ServoMap | None:
    servos = data.get("servos")
    if servos is None:
        return None
    ids = {joint: int(number) for joint, number in servos["ids"].items()}
    models = {joint: str(model) for joint, model in servos.get("models", {}).items()}
    for joint in ids:
        if joint not in joints:
            raise UnknownName("joint with a servo", joint, joints)
    for joint in models:
        if joint not in ids:
            raise UnknownName("joint with a servo model", joint, ids)
    if len(set(ids.values())) < len(ids):
        raise ValueError("two joints have the same servo id")
    settings = _section(ServoSettings, "servos settings", servos.get("settings", {}))
    if settings.mode not in get_args(ServoMode):
        raise UnknownName("servo mode", settings.mode, get_args(ServoMode))
    return ServoMap(
        model=str(servos["model"]),
        baud=int(servos["baud"]),
        cycle_s=float(servos["cycle_s"]),
        ids=ids,
        models=models,
        settings=settings,
        safety=_section(ServoSafety, "servo_safety", data.get("servo_safety", {})),
    )


def _section(kind: type[Section], name: str, data: dict[str, Any]) -> Section:
    known = {item.name for item in fields(kind)}
    for key in data:
        if key not in known:
            raise UnknownName(f"entry of {name}", key, known)
    return kind(**data)
