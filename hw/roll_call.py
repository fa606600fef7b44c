"""Who answers on the ports of a rig, and how well: silent servos, twins and mute ones are told apart."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from hw.bus import Bus, DamagedAnswers, Device
from hw.registers import ControlTable, control_table
from hw.rig import Rig
from ros_free_stack.errors import BusFault, LostServo, UnknownName

_FIRST, _LAST = "Realtime Tick", "Present Temperature"
"""Registers between which two servos surely differ."""


@dataclass(frozen=True)
class Answer:
    """What came of calling one servo of a rig.

    Attributes:
        index: in the rig.
        places: indices of the ports that it answers on.
        device: what it is; None where nothing answers.
        damaged: why its answers cannot be used, empty where they can.
        mute: it answers pings alone.
    """

    index: int
    places: tuple[int, ...] = ()
    device: Device | None = None
    damaged: str = ""
    mute: bool = False

    @property
    def table(self) -> ControlTable | None:
        """The control table of its model and firmware, as far as that is known."""
        return None if self.device is None else known_table(self.device)


def known_table(device: Device) -> ControlTable | None:
    """The control table of what answered, or None where the SDK has none."""
    try:
        return control_table(device.model, device.firmware)
    except UnknownName:
        return None


def roll_call(rig: Rig, buses: tuple[Bus, ...], check: Callable[[], None] = lambda: None) -> tuple[Answer, ...]:
    """Call every servo of a rig by name; `check` comes before each and may raise to give up."""
    heard = [{device.id for device in bus.scan()} for bus in buses] if len(buses) > 1 else [set[int]()]
    answers: list[Answer] = []
    for i, identity in enumerate(rig.ids):
        check()
        # A reply to the broadcast may have been lost: ask by name on every port.
        asked = [k for k, ids in enumerate(heard) if identity in ids] or range(len(buses))
        answers.append(_call(i, identity, buses, asked))
    return tuple(answers)


def _call(index: int, identity: int, buses: tuple[Bus, ...], asked: Iterable[int]) -> Answer:
    found = {k: device for k in asked if (device := buses[k].find(identity)) is not None}
    if not found:
        return Answer(index)
    k, device = next(iter(found.items()))
    damaged, mute = voice(buses[k], device)
    return Answer(index, tuple(found), device, damaged, mute)


def voice(bus: Bus, device: Device) -> tuple[str, bool]:
    """Why a servo's answers cannot be used (empty where they can), and whether it answers pings alone."""
    table = known_table(device)
    if table is None or _FIRST not in table or _LAST not in table:
        return "", False
    start = table[_FIRST].address
    try:
        bus.read_bytes(device.id, start, table[_LAST].end - start)
    except DamagedAnswers as error:
        return str(error), False
    except LostServo:
        return "", True
    except BusFault:
        pass  # it refuses this stretch, which is an answer
    return "", False
