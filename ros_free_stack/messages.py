"""The frozen messages that cross from one stage to the next. Arrays are read-only and checked on construction."""

import hashlib
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Literal, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ros_free_stack.errors import InvalidMessage
from ros_free_stack.skeleton import JOINT_COUNT

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
Mount = Literal["free", "fixed"]
ControllerName = Literal["pd", "default", "wbc"]
"""What moves a robot in physics: servos alone, with feedforward and ankle feedback, or whole-body control."""
StateName = Literal["true", "estimated"]
"""What a controller reads in physics: the simulation's own state, or what encoders and an IMU tell."""
Level = Literal["strict", "default", "lenient"]
"""How strict the limits of a verdict are."""


def _array(message: str, name: str, value: ArrayLike, shape: tuple[int | None, ...], dtype: Any = np.float64) -> Any:
    """A read-only, finite copy of `value` with the given shape (None: any length), or InvalidMessage."""
    try:
        array: NDArray[Any] = np.array(value, dtype=dtype)
    except (TypeError, ValueError) as error:
        raise InvalidMessage(message, name, f"expected an array of numbers, {error}") from None
    wanted = "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"
    if array.ndim != len(shape) or any(n is not None and n != m for n, m in zip(shape, array.shape, strict=True)):
        raise InvalidMessage(message, name, f"expected shape {wanted}, found {array.shape}")
    if any(m == 0 != n for n, m in zip(shape, array.shape, strict=True)):
        raise InvalidMessage(message, name, f"is empty, expected shape {wanted} with at least one frame")
    if dtype is np.float64 and not np.isfinite(array).all():
        where = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise InvalidMessage(message, name, f"expected finite values, found {array[where]} at {where}")
    array.setflags(write=False)
    return array


def _positive(message: str, name: str, value: float) -> float:
    value = float(value)
    if not (np.isfinite(value) and value > 0):
        raise InvalidMessage(message, name, f"expected a positive number, found {value}")
    return value


@dataclass(frozen=True)
class Segment:
    """One action of a motion: its text and when it happens, in seconds from the start."""

    text: str
    start_s: float
    end_s: float

    def __post_init__(self) -> None:
        if not 0 <= self.start_s <= self.end_s:
            raise InvalidMessage("Segment", "end_s", f"expected 0 <= start <= end, found {self.start_s}, {self.end_s}")


@dataclass(frozen=True)
class HumanMotion:
    """A human motion on the 22-joint skeleton.

    Attributes:
        joints: (T, 22, 3) joint positions in m; z up, x forward at the first frame, floor at z = 0.
        fps: frames a second.
        prompt: the sentence it was made from, or "".
        segments: the actions in temporal order.
        source: where it comes from (a model's name, a file).
    """

    joints: Floats
    fps: float
    prompt: str = ""
    segments: tuple[Segment, ...] = ()
    source: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "joints", _array("HumanMotion", "joints", self.joints, (None, JOINT_COUNT, 3)))
        object.__setattr__(self, "fps", _positive("HumanMotion", "fps", self.fps))
        object.__setattr__(self, "segments", tuple(self.segments))

    @property
    def duration_s(self) -> float:
        return len(self.joints) / self.fps


@dataclass(frozen=True)
class RobotTrajectory:
    """Joint positions of one robot over time, with its floating base and foot contacts.

    Attributes:
        robot: name of the robot description.
        model_sha256: `RobotDescription.sha256` of the robot it was made for.
        joint_names: J names of actuated joints, as in the robot's model.
        fps: frames a second.
        root_pos: (T, 3) position of the root body in m, world frame.
        root_quat: (T, 4) orientation of the root body, wxyz, unit norm.
        joint_pos: (T, J) rad.
        contacts: (T, F) whether each foot is meant to stand on the floor.
        foot_names: F names, the keys of the robot description's soles.
    """

    robot: str
    model_sha256: str
    joint_names: tuple[str, ...]
    fps: float
    root_pos: Floats
    root_quat: Floats
    joint_pos: Floats
    contacts: Bools
    foot_names: tuple[str, ...]

    def __post_init__(self) -> None:
        kind = "RobotTrajectory"
        for name in ("joint_names", "foot_names"):
            object.__setattr__(self, name, tuple(str(item) for item in getattr(self, name)))
        if len(set(self.joint_names)) != len(self.joint_names):
            raise InvalidMessage(kind, "joint_names", "expected distinct names")
        object.__setattr__(self, "fps", _positive(kind, "fps", self.fps))
        object.__setattr__(self, "joint_pos", _array(kind, "joint_pos", self.joint_pos, (None, len(self.joint_names))))
        frames = len(self.joint_pos)
        object.__setattr__(self, "root_pos", _array(kind, "root_pos", self.root_pos, (frames, 3)))
        object.__setattr__(self, "root_quat", _array(kind, "root_quat", self.root_quat, (frames, 4)))
        shape = (frames, len(self.foot_names))
        object.__setattr__(self, "contacts", _array(kind, "contacts", self.contacts, shape, np.bool_))
        norms = np.linalg.norm(self.root_quat, axis=1)
        worst = int(np.argmax(np.abs(norms - 1)))
        if abs(norms[worst] - 1) > 1e-6:
            raise InvalidMessage(kind, "root_quat", f"expected unit norm, found {norms[worst]:.6f} at frame {worst}")

    @property
    def duration_s(self) -> float:
        return len(self.joint_pos) / self.fps

    @cached_property
    def digest(self) -> str:
        """SHA-256 of everything in the trajectory; a verdict names it."""
        state = hashlib.sha256()
        head = (self.robot, self.model_sha256, self.joint_names, repr(float(self.fps)), self.foot_names)
        state.update(repr(head).encode())
        for array in (self.root_pos, self.root_quat, self.joint_pos, self.contacts):
            state.update(np.ascontiguousarray(array).tobytes())
        return state.hexdigest()


@dataclass(frozen=True)
class Check:
    """One measured property of a trajectory against its limit.

    Attributes:
        name: short identifier, e.g. "joint_velocity".
        value: the worst measured value.
        unit: unit of `value` and `limit`.
        limit: the threshold.
        passed: whether the value is within the limit, as the judge says; `holds` works it out anew.
        worst_frame: frame of the worst value, or -1 where it has none.
        worst_item: joint, body pair or foot of the worst value, or "".
        meaning: one sentence on what was measured.
        minimum: whether the limit is the least that `value` may be, instead of the most.
    """

    name: str
    value: float
    unit: str
    limit: float
    passed: bool
    worst_frame: int = -1
    worst_item: str = ""
    meaning: str = ""
    minimum: bool = False

    @property
    def holds(self) -> bool:
        """Whether the numbers say so: the value is within the limit; one that is no number never is."""
        return bool(self.value >= self.limit if self.minimum else self.value <= self.limit)


@dataclass(frozen=True)
class Verdict:
    """The judgement of one trajectory: passed only if every check passed and there is at least one.

    Attributes:
        robot: name of the robot description.
        model_sha256: `RobotDescription.sha256` of the robot that was judged.
        trajectory_digest: `RobotTrajectory.digest` of what was judged.
        checks: every check that was made.
        notes: what the checks do not say.
        physics: whether the trajectory was also played in physics; servos take no other verdict.
        mount: `free` for a robot on the floor, `fixed` for one held by its root, whose balance was not judged.
        controller: what moved the robot in physics; servos take none that their driver does not run.
        state: what that controller read.
        level: how strict the limits were.
        limits_sha256: `ros_free_stack.thresholds.limits_sha256` of all limits of that level for that robot.
        path_digest: `RobotTrajectory.digest` of the trajectory's servo path, on which every check was made.
    """

    robot: str
    model_sha256: str
    trajectory_digest: str
    checks: tuple[Check, ...]
    notes: tuple[str, ...] = ()
    physics: bool = False
    mount: Mount = "free"
    controller: ControllerName = "default"
    state: StateName = "true"
    level: Level = "default"
    limits_sha256: str = ""
    path_digest: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "checks", tuple(self.checks))
        object.__setattr__(self, "notes", tuple(self.notes))
        # A word in place of a truth value would count as true.
        flags: list[tuple[str, object]] = [("physics", self.physics)]
        flags += [("checks", flag) for check in self.checks for flag in (check.passed, check.minimum)]
        for name, value in flags:
            if not isinstance(value, bool | np.bool_):
                raise InvalidMessage("Verdict", name, f"expected true or false, found {value!r}")
        words = {"mount": Mount, "controller": ControllerName, "state": StateName, "level": Level}
        for name, choices in words.items():
            if (found := getattr(self, name)) not in get_args(choices):
                known = ", ".join(get_args(choices))
                raise InvalidMessage("Verdict", name, f"expected one of {known}, found {found!r}")

    @property
    def passed(self) -> bool:
        return bool(self.checks) and all(check.passed for check in self.checks)

    @property
    def failures(self) -> tuple[Check, ...]:
        return tuple(check for check in self.checks if not check.passed)


@dataclass(frozen=True)
class ServoTelemetry:
    """What a stream to servos commanded and measured in K cycles of N joints.

    Attributes:
        robot: name of the robot description.
        joint_names: N names of the joints that were streamed.
        time_s: (K,) time of each cycle since the first, s.
        late_s: (K,) how late each cycle began against its deadline, s.
        goal: (K, N) commanded angle, rad.
        fresh: (K, N) whether the servo answered in this cycle; where not, its last values stand.
        position: (K, N) measured angle, rad.
        velocity: (K, N) rad/s.
        current: (K, N) A; the share of full load for servos that measure no current.
        voltage: (K, N) V.
        temperature: (K, N) deg C.
    """

    robot: str
    joint_names: tuple[str, ...]
    time_s: Floats
    late_s: Floats
    goal: Floats
    fresh: Bools
    position: Floats
    velocity: Floats
    current: Floats
    voltage: Floats
    temperature: Floats

    def __post_init__(self) -> None:
        kind = "ServoTelemetry"
        object.__setattr__(self, "joint_names", tuple(str(name) for name in self.joint_names))
        object.__setattr__(self, "time_s", _array(kind, "time_s", self.time_s, (None,)))
        object.__setattr__(self, "late_s", _array(kind, "late_s", self.late_s, (len(self.time_s),)))
        shape = (len(self.time_s), len(self.joint_names))
        object.__setattr__(self, "fresh", _array(kind, "fresh", self.fresh, shape, np.bool_))
        for name in ("goal", *self.MEASURED):
            object.__setattr__(self, name, _array(kind, name, getattr(self, name), shape))

    MEASURED: ClassVar[tuple[str, ...]] = ("position", "velocity", "current", "voltage", "temperature")
    """Names of the measured arrays."""
