"""What an X-series servo holds when it leaves the factory, and which values its registers take.

Source: ROBOTIS e-Manual, X series, control tables.
"""

from hw.bus import BAUD_RATES
from hw.registers import ControlTable

CURRENT, VELOCITY, POSITION, EXTENDED, CURRENT_POSITION, PWM = 0, 1, 3, 4, 5, 16
REVERSE, TIME_BASED, TORQUE_ON_BY_GOAL = 1 << 0, 1 << 2, 1 << 3
"""Bits of Drive Mode."""
INPUT_VOLTAGE, OVERHEATING, ENCODER, SHOCK, OVERLOAD = 1 << 0, 1 << 2, 1 << 3, 1 << 4, 1 << 5
"""Bits of Hardware Error Status and Shutdown."""
MULTI_TURN = 1_048_575
"""Largest position of the modes that turn more than once."""

_XM430 = {
    "ID": 1, "Baud Rate": 1, "Return Delay Time": 250, "Operating Mode": POSITION,
    "Secondary(Shadow) ID": 255, "Protocol Type": 2, "Moving Threshold": 10, "Temperature Limit": 80,
    "Max Voltage Limit": 160, "Min Voltage Limit": 95, "PWM Limit": 885, "Current Limit": 1193,
    "Velocity Limit": 350, "Max Position Limit": 4095, "Min Position Limit": 0, "Shutdown": 52,
    "Status Return Level": 2, "Velocity I Gain": 1920, "Velocity P Gain": 100, "Position P Gain": 800,
}  # fmt: skip
_VOLTAGES = {"XL330": (5.0, 35, 70), "XC330-M": (5.0, 35, 70), "XH430-V": (24.0, 110, 300), "XH540-V": (24.0, 110, 300),
             "XW540": (24.0, 110, 300)}  # fmt: skip
"""First letters of a model to its nominal V, and its limits in 0.1 V; all others run on 12 V."""

CHOICES: dict[str, range | tuple[int, ...]] = {
    "ID": range(253),
    "Baud Rate": range(len(BAUD_RATES)),
    "Return Delay Time": range(255),
    "Drive Mode": tuple(mode for mode in range(16) if not mode & 2),
    "Operating Mode": (CURRENT, VELOCITY, POSITION, EXTENDED, CURRENT_POSITION, PWM),
    "Protocol Type": (2,),
    "Homing Offset": range(-1_044_479, 1_044_480),
    "Moving Threshold": range(1024),
    "Temperature Limit": range(101),
    "PWM Limit": range(886),
    "Velocity Limit": range(1024),
    "Max Position Limit": range(4096),
    "Min Position Limit": range(4096),
    "Torque Enable": range(2),
    "LED": range(2),
    "Status Return Level": range(3),
    "Bus Watchdog": range(128),
    "Profile Acceleration": range(32768),
    "Profile Velocity": range(32768),
} | {f"{loop} Gain": range(16384) for loop in (
    "Velocity I", "Velocity P", "Position D", "Position I", "Position P", "Feedforward 2nd", "Feedforward 1st",
)}  # fmt: skip
"""Values that a register takes; where it is not listed, all that fit into it."""


def supply_voltage(model: str) -> float:
    """Nominal voltage, V."""
    return _row(model)[0]


def factory_values(table: ControlTable) -> dict[str, int]:
    """Register to its value; all others are 0. Model number included."""
    _, low, high = _row(table.model)
    values = _XM430 | {
        "Model Number": table.number,
        "Firmware Version": table.firmware,
        "Min Voltage Limit": low,
        "Max Voltage Limit": high,
    }
    return {name: value for name, value in values.items() if name in table}


def _row(model: str) -> tuple[float, int, int]:
    found = (row for prefix, row in _VOLTAGES.items() if model.startswith(prefix))
    return next(found, (12.0, _XM430["Min Voltage Limit"], _XM430["Max Voltage Limit"]))
