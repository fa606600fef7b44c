"""Set-up of servos: what their registers should hold for a robot, what differs, and writing just that.

What is kept without power is written on request only (`apply_changes`); gains, profile and goal current live in RAM and
are written by the driver each time (`ram_settings`).
"""

from collections.abc import Iterable
from dataclasses import dataclass

from hw.registers import ControlTable
from hw.rig import Rig
from hw.servos import Servos
from hw.units import scale, to_raw, to_si
from ros_free_stack.errors import BusFault, StackError, UnsafeCommand
from ros_free_stack.robots import ServoMode

MODES: dict[ServoMode, int] = {"position": 3, "extended position": 4, "current-based position": 5}
"""Operating modes by their number in the register."""

SECONDARY_ID, NO_SECONDARY_ID = "Secondary(Shadow) ID", 253
"""A servo with a secondary id below this one obeys what another servo is told."""
_NEVER = 255
_FULL_TURN = 4095
_LEVEL = "Status Return Level"


@dataclass(frozen=True)
class Change:
    """One register that differs from what the robot needs; raw values."""

    index: int
    servo: str
    id: int
    register: str
    now: int
    wanted: int

    def describe(self, table: ControlTable) -> tuple[str, str]:
        """Present and wanted value with their unit."""
        _, _, unit = scale(table, self.register)
        if unit == "raw":
            return str(self.now), str(self.wanted)
        now, wanted = (f"{to_si(table, self.register, raw):.4g} {unit}" for raw in (self.now, self.wanted))
        return now, wanted


def pose_settings(rig: Rig) -> dict[str, int]:
    """Registers that decide where a goal position leads: the driver moves no servo where they differ."""
    return {"Operating Mode": MODES[rig.settings.mode], "Drive Mode": 0, "Homing Offset": 0}


def ram_settings(rig: Rig, i: int) -> dict[str, int]:
    """Registers that a servo forgets without power, and what the robot wants in them."""
    settings, table = rig.settings, rig.tables[i]
    gains = {
        "Position P Gain": settings.p_gain, "Position I Gain": settings.i_gain, "Position D Gain": settings.d_gain,
    }  # fmt: skip
    wanted = {name: value for name, value in gains.items() if value is not None}
    wanted["Profile Acceleration"] = to_raw(table, "Profile Acceleration", settings.profile_acceleration)
    wanted["Profile Velocity"] = to_raw(table, "Profile Velocity", settings.profile_velocity)
    if settings.mode == "current-based position" and settings.current_limit is not None:
        wanted["Goal Current"] = to_raw(table, "Goal Current", settings.current_limit)
    return wanted


def planned_changes(servos: Servos) -> tuple[Change, ...]:
    """What `apply_changes` would write: answers at once, operating mode, position and current limits.

    A servo that answers pings alone shows its other differences once it answers.
    """
    rig = servos.rig
    changes: list[Change] = []
    for i, identity in enumerate(rig.ids):
        if i in servos.mute:
            changes.append(Change(i, rig.label(i), identity, _LEVEL, 0, 2))
            continue
        for register, wanted in _wanted(rig, i).items():
            if register == SECONDARY_ID and (SECONDARY_ID not in servos.table(i) or _has_no_second(servos, i)):
                continue
            now = servos.read(i, register)
            if now != wanted:
                changes.append(Change(i, rig.label(i), identity, register, now, wanted))
    return tuple(changes)


def apply_changes(servos: Servos, changes: Iterable[Change]) -> None:
    """Write the changes and read each back.

    Raises:
        UnsafeCommand: a servo holds torque, which locks its EEPROM; nothing was written.
        BusFault: a register did not take its value; says how many were written before.
        LostServo, PortError: likewise, where a servo or the port went away.
    """
    changes = tuple(sorted(changes, key=lambda change: change.register != _LEVEL))
    for change in changes:
        if change.register == _LEVEL:
            # Such a servo confirms nothing before; afterwards it must.
            servos.write_together([change.index], _LEVEL, change.wanted)
    for i in dict.fromkeys(change.index for change in changes):
        if servos.read(i, "Torque Enable"):
            raise UnsafeCommand(f"{servos.rig.label(i)} holds torque: support the robot, then `servos release`")
    for done, change in enumerate(changes):
        try:
            servos.write(change.index, change.register, change.wanted)
            found = servos.read(change.index, change.register)
            if found != change.wanted:
                raise BusFault(f"{change.servo}: {change.register} is {found} after writing {change.wanted}")
        except StackError as error:
            error.args = (f"{error}; {done} of {len(changes)} changes were written before",)
            raise


def _wanted(rig: Rig, i: int) -> dict[str, int]:
    wanted = {_LEVEL: 2, "Return Delay Time": 0, SECONDARY_ID: _NEVER, **pose_settings(rig)}
    if rig.settings.mode == "position":
        wanted |= _position_limits(rig, i)
    if rig.settings.current_limit is not None and "Current Limit" in rig.tables[i]:
        wanted["Current Limit"] = to_raw(rig.tables[i], "Current Limit", rig.settings.current_limit)
    return wanted


def _has_no_second(servos: Servos, i: int) -> bool:
    return servos.read(i, SECONDARY_ID) >= NO_SECONDARY_ID


def _position_limits(rig: Rig, i: int) -> dict[str, int]:
    """The joint's range in servo positions, a tick wider so that rounding never meets it."""
    table = rig.tables[i]
    ends = [
        round((rig.direction[i] * angle + rig.offset[i]) / table.rad_per_tick) + table.zero_position
        for angle in (rig.lower[i], rig.upper[i])
    ]
    return {
        "Min Position Limit": max(0, min(ends) - 1),
        "Max Position Limit": min(_FULL_TURN, max(ends) + 1),
    }
