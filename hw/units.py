"""Raw register values to SI units and back: rad, rad/s, A, V, deg C, s.

Scales of position and velocity come from each model's file in the SDK. What the files leave raw has the e-Manual's
units, the same for every X-series model except that of current.
"""

import math

from hw.registers import ControlTable
from ros_free_stack.errors import UnsafeCommand

_VOLT = 0.1
_RETURN_DELAY = 2e-6
_WATCHDOG = 0.02
_PWM = 1 / 885
"""Full duty is 885 units."""
_ACCELERATION = 214.577 * 2 * math.pi / 3600
"""214.577 rev/min^2 in rad/s^2."""

_POSITIONS = frozenset(
    {"Goal Position", "Present Position", "Position Trajectory", "Max Position Limit", "Min Position Limit"}
)
_VELOCITIES = frozenset(
    {"Goal Velocity", "Present Velocity", "Velocity Trajectory", "Velocity Limit", "Profile Velocity",
     "Moving Threshold"}
)  # fmt: skip
_FIXED = {
    "Present Input Voltage": (_VOLT, "V"),
    "Max Voltage Limit": (_VOLT, "V"),
    "Min Voltage Limit": (_VOLT, "V"),
    "Present Temperature": (1.0, "deg C"),
    "Temperature Limit": (1.0, "deg C"),
    "Return Delay Time": (_RETURN_DELAY, "s"),
    "Bus Watchdog": (_WATCHDOG, "s"),
    "Realtime Tick": (1e-3, "s"),
    "Profile Acceleration": (_ACCELERATION, "rad/s^2"),
    "Goal PWM": (_PWM, ""),
    "Present PWM": (_PWM, ""),
    "PWM Limit": (_PWM, ""),
    "Present Load": (1e-3, ""),
}


_AMPERES = (("330", 1e-3), ("XH430-V", 1.34e-3), ("MX-", 3.36e-3), ("", 2.69e-3))
"""A of one unit of current by part of the model's name, the first that fits (e-Manual, "Goal Current")."""


def amperes_per_unit(model: str) -> float:
    """Current of one unit in A."""
    return next(amperes for part, amperes in _AMPERES if part in model)


def scale(table: ControlTable, register: str) -> tuple[float, int, str]:
    """SI value of one unit, raw value of SI zero, and unit; unit "raw" where the register has none.

    Raises:
        UnknownName: the model has no such register.
    """
    name = table[register].name
    if name in _POSITIONS:
        return table.rad_per_tick, table.zero_position, "rad"
    if name == "Homing Offset":
        return table.rad_per_tick, 0, "rad"
    if name in _VELOCITIES and "Present Velocity" in table.scales:
        return table.scales["Present Velocity"][0], 0, "rad/s"
    if name in ("Goal Current", "Present Current", "Current Limit"):
        return amperes_per_unit(table.model), 0, "A"
    factor, unit = _FIXED.get(name, (1.0, "raw"))
    return factor, 0, unit


def to_si(table: ControlTable, register: str, raw: int) -> float:
    """Raw value to SI."""
    factor, zero, _ = scale(table, register)
    return (raw - zero) * factor


def to_raw(table: ControlTable, register: str, value: float) -> int:
    """SI value to the nearest raw value.

    Raises:
        UnsafeCommand: not finite, or beyond what the register can hold.
    """
    factor, zero, unit = scale(table, register)
    item = table[register]
    raw = int(round(value / factor) + zero) if math.isfinite(value) else None
    if raw is None or not item.lowest <= raw <= item.highest:
        low, high = ((limit - zero) * factor for limit in (item.lowest, item.highest))
        raise UnsafeCommand(f"{table.model} {register}: {value:g} {unit} is outside {low:g} to {high:g} {unit}")
    return raw
