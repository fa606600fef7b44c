"""Set-up of servos: what their registers should hold for a robot, what differs, and writing just that."""

from dataclasses import dataclass

from hw.bus import Bus
from hw.rig import Rig
from hw.units import scale, to_si
from ros_free_stack.errors import BusFault, UnsafeCommand

_WANTED = {
    "Return Delay Time": 0,
    "Drive Mode": 0,
    "Operating Mode": 3,
    "Homing Offset": 0,
    "Status Return Level": 2,
}
_FULL_TURN = 4095


@dataclass(frozen=True)
class Change:
    """One register that differs from what the robot needs; raw values."""

    servo: str
    id: int
    register: str
    now: int
    wanted: int

    def describe(self, rig: Rig) -> tuple[str, str]:
        """Present and wanted value with their unit."""
        _, _, unit = scale(rig.table, self.register)
        if unit == "raw":
            return str(self.now), str(self.wanted)
        now, wanted = (f"{to_si(rig.table, self.register, raw):.4g} {unit}" for raw in (self.now, self.wanted))
        return now, wanted


def planned_changes(bus: Bus, rig: Rig) -> tuple[Change, ...]:
    """What `apply_changes` would write: immediate answers, position mode, position limits from the joint ranges."""
    changes: list[Change] = []
    for i, identity in enumerate(rig.ids):
        for register, wanted in (_WANTED | _position_limits(rig, i)).items():
            now = bus.read(identity, rig.table, register)
            if now != wanted:
                changes.append(Change(rig.label(i), identity, register, now, wanted))
    return tuple(changes)


def apply_changes(bus: Bus, rig: Rig, changes: tuple[Change, ...]) -> None:
    """Write the changes and read each back.

    Raises:
        UnsafeCommand: a servo holds torque, which locks its EEPROM; nothing was written.
        BusFault: a register did not take its value.
    """
    for change in changes:
        if bus.read(change.id, rig.table, "Torque Enable"):
            raise UnsafeCommand(f"{change.servo} holds torque: support the robot, then `servos release`")
    for change in changes:
        bus.write(change.id, rig.table, change.register, change.wanted)
        found = bus.read(change.id, rig.table, change.register)
        if found != change.wanted:
            raise BusFault(f"{change.servo}: {change.register} is {found} after writing {change.wanted}")


def _position_limits(rig: Rig, i: int) -> dict[str, int]:
    """The joint's range in servo positions, a tick wider so that rounding never meets it."""
    table = rig.table
    ends = [
        round((rig.direction[i] * angle + rig.offset[i]) / table.rad_per_tick) + table.zero_position
        for angle in (rig.lower[i], rig.upper[i])
    ]
    return {
        "Min Position Limit": max(0, min(ends) - 1),
        "Max Position Limit": min(_FULL_TURN, max(ends) + 1),
    }
