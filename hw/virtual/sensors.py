"""What a servo's sensors and its trajectory generator report in the control table.

Source: ROBOTIS e-Manual, X series, "Moving", "Moving Status" and the Present registers.
"""

import struct

from hw.units import amperes_per_unit, scale
from hw.virtual.controller import Controller
from hw.virtual.memory import Memory
from hw.virtual.motor import Motor

_IN_POSITION_RAD, _OFF_TRACK_RAD = 0.02, 0.2
_FULL_DUTY, _FULL_LOAD, _TICK_ROUND = 885, 1000, 32768
_PACK = {1: struct.Struct("<B"), 2: struct.Struct("<h"), 4: struct.Struct("<i")}
_REPORTED = ("Present Position", "Present Velocity", "Present Current", "Present Load", "Present PWM", "Realtime Tick",
             "Present Input Voltage", "Present Temperature", "Moving", "Moving Status", "Velocity Trajectory",
             "Position Trajectory")  # fmt: skip


class Sensors:
    """Writes the registers that report into a servo's memory."""

    def __init__(self, memory: Memory, motor: Motor, controller: Controller) -> None:
        self._memory, self._motor, self._controller = memory, motor, controller
        table = memory.table
        registers = {name: table[name] for name in _REPORTED if name in table}
        self._places = {name: (_PACK[item.size].pack_into, item.address) for name, item in registers.items()}
        self._velocity_unit = scale(table, "Present Velocity")[0]
        self._current_unit = amperes_per_unit(table.model)
        self.load()

    def load(self) -> None:
        """Take the settings out of the table."""
        self._threshold = self._memory.get("Moving Threshold")

    def publish(self, *, torque: bool, up_s: float, volts: float) -> None:
        """Report the present state; `up_s` counts from the last restart."""
        motor, controller = self._motor, self._controller
        sign, profile = controller.sign, controller.profile
        velocity = round(sign * motor.velocity / self._velocity_unit)
        ongoing = torque and controller.controls_position and not profile.done
        load = sign * motor.current / motor.model.stall_current
        values = {
            "Present Position": controller.to_table(motor.position),
            "Present Velocity": velocity,
            "Present Current": round(sign * motor.current / self._current_unit),
            "Present Load": max(-_FULL_LOAD, min(_FULL_LOAD, round(_FULL_LOAD * load))),
            "Present PWM": round(_FULL_DUTY * sign * controller.duty) if torque else 0,
            "Realtime Tick": int(up_s * 1000) % _TICK_ROUND,
            "Present Input Voltage": round(volts * 10),
            "Present Temperature": max(0, min(255, round(motor.temperature))),
            "Moving": ongoing or abs(velocity) > self._threshold,
            "Moving Status": self._moving_status(ongoing=ongoing),
            "Velocity Trajectory": round(sign * profile.velocity / self._velocity_unit),
            "Position Trajectory": controller.to_table(profile.position),
        }
        for name, (pack_into, address) in self._places.items():
            pack_into(self._memory.data, address, values[name])

    def _moving_status(self, *, ongoing: bool) -> int:
        if not self._controller.controls_position:
            return 0
        profile, position = self._controller.profile, self._motor.position
        arrived = abs(profile.goal - position) < _IN_POSITION_RAD
        off_track = abs(profile.position - position) > _OFF_TRACK_RAD
        return arrived | ongoing << 1 | off_track << 3 | (profile.kind if ongoing else 0) << 4
