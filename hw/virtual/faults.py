"""What can go wrong on an emulated bus: on the wire, at random or once, and in the servos.

A fault is written KIND:WHEN[:ID], where WHEN is a share of all packets (1%), a time since the bus was first heard
(2.5s), or the number of the goal position at which it happens (120); without an ID it befalls all servos.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from hw.virtual.servo import INPUT_VOLTAGE, OVERLOAD, Servo
from ros_free_stack.errors import InvalidOption

WIRE = {"corrupt": "corrupt", "lost": "drop", "noise": "noise", "latency": "spike"}
"""Kinds that befall answers, and the share of `Faults` that each is."""
_BROWN_OUT_V = 0.7
_OVERHEAT_C = 5.0


@dataclass
class Faults:
    """What goes wrong on the wire; may be changed while the bus runs.

    Attributes:
        drop: probability that an answer is lost.
        corrupt: probability that one byte of an answer is changed.
        drop_instruction: probability that an instruction is not heard.
        corrupt_instruction: probability that one byte of an instruction is changed.
        noise: probability of up to 8 random bytes before an answer.
        delay_s: extra time before each answer.
        spike_s: extra time before an answer, with probability `spike`.
        spike: see `spike_s`.
        seed: of the randomness.
        once: kinds of `WIRE` that befall the next answers, one each.
    """

    drop: float = 0.0
    corrupt: float = 0.0
    drop_instruction: float = 0.0
    corrupt_instruction: float = 0.0
    noise: float = 0.0
    delay_s: float = 0.0
    spike: float = 0.0
    spike_s: float = 0.05
    seed: int = 0
    once: list[str] = field(default_factory=list[str])
    _random: np.random.Generator = field(init=False, repr=False)

    def __post_init__(self) -> None:
        self._random = np.random.default_rng(self.seed)

    def heard(self, data: bytes) -> bytes:
        """What arrives of an instruction."""
        if self._happens(self.drop_instruction):
            return b""
        return self._changed(data) if self._happens(self.corrupt_instruction) else data

    def distort(self, data: bytes) -> bytes:
        """What arrives of an answer."""
        once = self.once.pop(0) if self.once and self.once[0] != "latency" else ""
        if self._happens(self.drop) or once == "lost":
            return b""
        if self._happens(self.corrupt) or once == "corrupt":
            data = self._changed(data)
        if self._happens(self.noise) or once == "noise":
            data = self._random.bytes(int(self._random.integers(1, 9))) + data
        return data

    def wait_s(self) -> float:
        """Extra time before an answer."""
        late = self._happens(self.spike)
        if self.once and self.once[0] == "latency":
            self.once.pop(0)
            late = True
        return self.delay_s + (self.spike_s if late else 0.0)

    def _happens(self, share: float) -> bool:
        return share > 0 and bool(self._random.random() < share)

    def _changed(self, data: bytes) -> bytes:
        changed = bytearray(data)
        changed[self._random.integers(len(data))] ^= int(self._random.integers(1, 256))
        return bytes(changed)


def _die(servo: Servo) -> None:
    servo.dead = True


def _jam(servo: Servo) -> None:
    servo.motor.jammed = True


def _overheat(servo: Servo) -> None:
    servo.motor.temperature = servo.get("Temperature Limit") + _OVERHEAT_C


def _brown_out(servo: Servo) -> None:
    servo.supply_voltage *= _BROWN_OUT_V
    servo.fail(INPUT_VOLTAGE)


SERVO: dict[str, Callable[[Servo], None]] = {
    "dead": _die,
    "overload": lambda servo: servo.fail(OVERLOAD),
    "overheating": _overheat,
    "brown-out": _brown_out,
    "reboot": lambda servo: servo.reboot(),
    "jam": _jam,
}
"""Kinds that befall a servo: it falls silent, shuts down for overload or for heat, gets 70 % of its voltage, restarts,
or cannot move."""

KINDS = (*WIRE, *SERVO)


@dataclass(frozen=True)
class Fault:
    """A fault that is to come.

    Attributes:
        kind: one of `KINDS`.
        when: share of packets, s since the bus was first heard, or number of the goal position.
        unit: which of them.
        id: servo, or None for all.
    """

    kind: str
    when: float
    unit: Literal["share", "s", "goals"]
    id: int | None = None

    @classmethod
    def parse(cls, text: str) -> "Fault":
        """From KIND:WHEN[:ID].

        Raises:
            InvalidOption: says what is valid.
        """
        found = re.fullmatch(r"([a-z-]+):([0-9.]+)(%|s?)(?::([0-9]+))?", text)
        if found is None or found[1] not in KINDS or found[2].count(".") > 1 or found[2] == ".":
            raise InvalidOption(
                "--fault", f"{text!r} is not KIND:WHEN[:ID]; kinds: {', '.join(KINDS)}; when: 1%, 2.5s or 120 (goals)"
            )
        kind, value, identity = found[1], float(found[2]), int(found[4]) if found[4] else None
        if found[3] == "%":
            if kind not in WIRE or identity is not None or value > 100:
                raise InvalidOption("--fault", f"{text!r}: a share, at most 100%, is of {', '.join(WIRE)}, without ID")
            return cls(kind, value / 100, "share")
        return cls(kind, value, "s" if found[3] else "goals", identity)

    def due(self, servos: dict[int, Servo], heard_s: float) -> bool:
        """Whether a fault of a time or a goal should happen now."""
        if self.unit == "s":
            return heard_s >= self.when
        told = (len(servo.goals) for key, servo in servos.items() if self.id in (None, key))
        return max(told, default=0) >= self.when

    def happen(self, servos: dict[int, Servo], faults: Faults) -> None:
        """Let it happen."""
        if self.kind in WIRE:
            faults.once.append(self.kind)
            return
        for key, servo in list(servos.items()):
            if self.id in (None, key):
                SERVO[self.kind](servo)
