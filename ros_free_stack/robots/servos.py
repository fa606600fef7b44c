"""The servo side of a robot description: which Dynamixel drives which joint, how it is set up, what stops it."""

import math
from collections.abc import Collection
from dataclasses import dataclass, field, fields
from typing import Any, Literal, TypeVar, get_args

from ros_free_stack.errors import UnknownName

ServoMode = Literal["position", "extended position", "current-based position"]
StopPolicy = Literal["off", "hold"]

WATCHDOG_MAX_S = 2.54
_LAST_ID = 252


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
class ServoMotor:
    """The electric motor of the robot's servos and its heat, from the maker's data sheet.

    Attributes:
        voltage: V, at which stall torque and no-load speed of the joints hold.
        stall_current: A at that voltage.
        no_load_speed: rad/s at that voltage, where no torque is left.
        encoder_steps: steps of the position sensor in a turn.
        supply_power: W that the robot's power supply gives.
        heat_capacity: J/K of one servo.
        thermal_resistance: K/W from one servo to the room.
    """

    voltage: float
    stall_current: float
    no_load_speed: float
    encoder_steps: int
    supply_power: float
    heat_capacity: float
    thermal_resistance: float

    def __post_init__(self) -> None:
        for item in fields(self):
            value = getattr(self, item.name)
            if not (isinstance(value, int | float) and 0 < value < math.inf):
                raise ValueError(f"servos motor {item.name}: expected a positive number, found {value!r}")

    @property
    def resistance(self) -> float:
        """Ohm of the winding."""
        return self.voltage / self.stall_current


@dataclass(frozen=True)
class ServoBoard:
    """A board on the servos' bus, between the battery and them: their power switch, its buttons and its voltage.

    Attributes:
        name: for people.
        id: on the bus.
        model_number: as it answers a ping.
        power: address of the switch (1 byte).
        buttons: address of the buttons (1 byte, one bit each, set while it is pressed).
        button_names: of the bits, the lowest first. Any of them stops a stream.
        voltage: address of the battery's voltage (1 byte).
        on: what the switch holds when the servos have power; 0 takes it.
        wait_s: s that the servos need to start.
        volt: V of one unit of the voltage.
        low_voltage: V below which a person is warned.
    """

    name: str
    id: int
    model_number: int
    power: int
    buttons: int
    button_names: tuple[str, ...]
    voltage: int
    on: int = 1
    wait_s: float = 0.1
    volt: float = 0.1
    low_voltage: float = 0.0

    def __post_init__(self) -> None:
        # YAML has lists, and takes a word where a list was meant.
        names: object = self.button_names
        if isinstance(names, str) or not 1 <= len(self.button_names) <= 8:
            raise ValueError(f"servos board button_names: expected a list of 1 to 8 names, found {names!r}")
        object.__setattr__(self, "button_names", tuple(map(str, self.button_names)))
        whole = {
            "id": _LAST_ID,
            "model_number": 0xFFFF,
            "power": 0xFFFF,
            "buttons": 0xFFFF,
            "voltage": 0xFFFF,
            "on": 255,
        }
        for name, highest in whole.items():
            value = getattr(self, name)
            if type(value) is not int or not 0 <= value <= highest:
                raise ValueError(f"servos board {name}: expected a whole number from 0 to {highest}, found {value!r}")
        for name in ("wait_s", "volt", "low_voltage"):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and 0 <= value < math.inf):
                raise ValueError(f"servos board {name}: expected a number of at least 0, found {value!r}")


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
        motor: its electrical and thermal figures, or None where they are not known.
        board: what gives the servos their power, or None where that is no device on the bus.
    """

    model: str
    baud: int
    cycle_s: float
    ids: dict[str, int]
    models: dict[str, str] = field(default_factory=dict[str, str])
    settings: ServoSettings = ServoSettings()
    safety: ServoSafety = ServoSafety()
    motor: ServoMotor | None = None
    board: ServoBoard | None = None

    def model_of(self, joint: str) -> str:
        """The servo model of a joint."""
        return self.models.get(joint, self.model)


Section = TypeVar("Section", ServoSettings, ServoSafety, ServoMotor, ServoBoard)


def read_servos(data: dict[str, Any], joints: Collection[str]) -> ServoMap | None:
    """The servo map of a description, or None where it has none.

    Args:
        data: the whole description.
        joints: names of its joints.

    Raises:
        UnknownName: an entry, a joint or a mode that does not exist.
        KeyError, TypeError, ValueError: an entry is missing or has the wrong type.
    """
    servos = data.get("servos")
    if servos is None:
        return None
    ids = {joint: _id(joint, number) for joint, number in servos["ids"].items()}
    models = {joint: str(model) for joint, model in servos.get("models", {}).items()}
    for joint in ids:
        if joint not in joints:
            raise UnknownName("joint with a servo", joint, joints)
    for joint in models:
        if joint not in ids:
            raise UnknownName("joint with a servo model", joint, ids)
    if len(set(ids.values())) < len(ids):
        raise ValueError("two joints have the same servo id")
    board = _section(ServoBoard, "servos board", servos["board"]) if "board" in servos else None
    if board is not None and board.id in ids.values():
        raise ValueError(f"the servos' board has the id {board.id} of a servo")
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
        motor=_section(ServoMotor, "servos motor", servos["motor"]) if "motor" in servos else None,
        board=board,
    )


def _id(joint: str, number: object) -> int:
    if type(number) is not int or not 0 <= number <= _LAST_ID:
        raise ValueError(f"{joint}: expected a servo id 0 to {_LAST_ID}, found {number!r}")
    return number


def _section(kind: type[Section], name: str, data: dict[str, Any]) -> Section:
    known = {item.name for item in fields(kind)}
    for key in data:
        if key not in known:
            raise UnknownName(f"entry of {name}", key, known)
    return kind(**data)
