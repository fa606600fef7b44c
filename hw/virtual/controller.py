"""The controller of one servo: from its goals and gains to the duty of the motor's bridge.

Source: ROBOTIS e-Manual, X series, "Operating Mode", "Position PID Gain", "Velocity PI Gain".
"""

from hw.units import scale, to_si
from hw.virtual.factory import CURRENT, CURRENT_POSITION, EXTENDED, POSITION, PWM, REVERSE, TIME_BASED, VELOCITY
from hw.virtual.memory import Memory
from hw.virtual.motor import Motor
from hw.virtual.profile import Profile

_POSITION_MODES = (POSITION, EXTENDED, CURRENT_POSITION)
_FULL_DUTY = 885
_CONTROL_HZ = 1000
_MS = 1e-3


class Controller:
    """Reads its settings from the memory when they change, so that the control step need not.

    Attributes:
        mode: operating mode.
        sign: 1, or -1 in reverse mode: sense of the table's values against the motor.
        profile: the reference of the position modes, rad of the motor; of the velocity mode, its velocity.
        duty: last output, -1 to 1.
    """

    def __init__(self, memory: Memory, motor: Motor) -> None:
        self._memory, self._motor = memory, motor
        self.profile = Profile()
        self.duty = self._integral = 0.0
        self.load()

    @property
    def controls_position(self) -> bool:
        """Whether a position mode is set."""
        return self.mode in _POSITION_MODES

    def reset(self) -> None:
        """Begin where the horn is, as when the torque is switched on."""
        self.profile = Profile(self._motor.position, goal=self._motor.position)
        self._integral = 0.0

    def load(self) -> None:
        """Take all settings out of the table, in SI, in the motor's own sense."""
        get, table = self._memory.get, self._memory.table
        self.mode = get("Operating Mode")
        drive = get("Drive Mode") if "Drive Mode" in table else 0
        self.sign = -1.0 if drive & REVERSE else 1.0
        self._timed = bool(drive & TIME_BASED)
        self._offset = self._si("Homing Offset")
        self._goal_velocity = self.sign * self._si("Goal Velocity")
        self._goal_current = self.sign * self._si("Goal Current")
        self._goal_duty = self.sign * self._si("Goal PWM")
        self._speed, self._acceleration = self._si("Profile Velocity"), self._si("Profile Acceleration")
        self._total_s, self._rise_s = get("Profile Velocity") * _MS, get("Profile Acceleration") * _MS
        # e-Manual: the PWM of 885 units is P / 128 per tick, I / 65,536 per tick and D / 16.
        tick = table.rad_per_tick
        self._kp = get("Position P Gain") / 128 / _FULL_DUTY / tick
        self._ki = get("Position I Gain") / 65_536 / _FULL_DUTY / tick * _CONTROL_HZ
        self._kd = get("Position D Gain") / 16 / _FULL_DUTY / tick / _CONTROL_HZ
        self._kv = get("Velocity P Gain") / 128 / _FULL_DUTY / scale(table, "Goal Velocity")[0] * 16

    def take_goal(self) -> None:
        """Head for the table's goal position."""
        goal = self.from_table(self._memory.get("Goal Position"))
        if self._timed:
            self.profile.arrive_in(goal, total_s=self._total_s, rise_s=self._rise_s)
        else:
            self.profile.head_for(goal, speed=self._speed, acceleration=self._acceleration)

    def from_table(self, raw: int) -> float:
        """Motor angle in rad of a raw position."""
        table = self._memory.table
        return self.sign * ((raw - table.zero_position) * table.rad_per_tick - self._offset)

    def to_table(self, angle: float) -> int:
        """Raw position of a motor angle in rad."""
        table = self._memory.table
        return round((self.sign * angle + self._offset) / table.rad_per_tick) + table.zero_position

    def step(self, dt: float) -> float:
        """The duty for the next `dt` s."""
        motor = self._motor
        if self.mode == PWM:
            duty = self._goal_duty
        elif self.mode == VELOCITY:
            duty = self._velocity_duty(dt)
        elif self.mode == CURRENT:
            duty = motor.duty_of(self._goal_current)
        else:
            duty = self._position_duty(dt)
        # In every mode the goal PWM bounds the output.
        limit = abs(self._goal_duty)
        self.duty = max(-limit, min(limit, duty))
        return self.duty

    def _velocity_duty(self, dt: float) -> float:
        profile, motor = self.profile, self._motor
        change = self._goal_velocity - profile.velocity
        if self._acceleration > 0:
            change = max(-self._acceleration * dt, min(self._acceleration * dt, change))
        profile.velocity += change
        return profile.velocity / motor.model.no_load_speed + self._kv * (profile.velocity - motor.velocity)

    def _position_duty(self, dt: float) -> float:
        profile, motor = self.profile, self._motor
        profile.advance(dt)
        error = profile.position - motor.position
        self._integral = max(-1.0, min(1.0, self._integral + self._ki * error * dt))
        duty = self._kp * error + self._integral - self._kd * motor.velocity
        if self.mode == CURRENT_POSITION:
            current = abs(self._goal_current)
            duty = max(motor.duty_of(-current), min(motor.duty_of(current), duty))
        return duty

    def _si(self, name: str) -> float:
        table = self._memory.table
        return to_si(table, name, self._memory.get(name)) if name in table else 0.0
