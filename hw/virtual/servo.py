"""One emulated X-series servo: its control table with the firmware's access rules, its controller and its faults.

Source of the rules: ROBOTIS e-Manual, "XM430-W350", control table and its descriptions.
"""

import math
import struct
from dataclasses import dataclass, field

from hw.protocol import StatusError
from hw.registers import ControlTable, Register, control_table
from hw.units import amperes_per_unit, scale, to_si
from hw.virtual.motor import Motor, MotorModel

FACTORY = {
    "Firmware Version": 52, "ID": 1, "Baud Rate": 1, "Return Delay Time": 250, "Operating Mode": 3,
    "Secondary(Shadow) ID": 255, "Protocol Type": 2, "Moving Threshold": 10, "Temperature Limit": 80,
    "Max Voltage Limit": 160, "Min Voltage Limit": 95, "PWM Limit": 885, "Current Limit": 1193,
    "Velocity Limit": 350, "Max Position Limit": 4095, "Min Position Limit": 0, "Shutdown": 52,
    "Status Return Level": 2, "Velocity I Gain": 1920, "Velocity P Gain": 100, "Position P Gain": 800,
}  # fmt: skip
"""Initial values of an XM430-W350; all others are 0."""

BAUD_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
OVERHEATING, OVERLOAD, INPUT_VOLTAGE = 1 << 2, 1 << 5, 1 << 0
WATCHDOG_TRIPPED = 0xFF
CURRENT, VELOCITY, POSITION, EXTENDED, CURRENT_POSITION, PWM = 0, 1, 3, 4, 5, 16

_STEP_S = 2e-3
_OVERLOAD_S = 1.5
_INT16, _INT32 = struct.Struct("<h"), struct.Struct("<i")
_SENSORS = ("Present Position", "Present Velocity", "Present Current", "Present Input Voltage", "Realtime Tick",
            "Present Temperature", "Moving")  # fmt: skip
_GOALS = frozenset({"Goal PWM", "Goal Current", "Goal Velocity", "Goal Position"})
_CHOICES = {
    "ID": range(253),
    "Baud Rate": range(len(BAUD_RATES)),
    "Operating Mode": (CURRENT, VELOCITY, POSITION, EXTENDED, CURRENT_POSITION, PWM),
    "Torque Enable": range(2),
    "LED": range(2),
    "Status Return Level": range(3),
    "Bus Watchdog": range(128),
    "Max Position Limit": range(4096),
    "Min Position Limit": range(4096),
    "Temperature Limit": range(101),
}
_LIMITED_BY = {"Goal PWM": "PWM Limit", "Goal Current": "Current Limit", "Goal Velocity": "Velocity Limit"}


class Refused(Exception):
    """An instruction that the firmware answers with an error code."""

    def __init__(self, code: StatusError) -> None:
        super().__init__(code.name)
        self.code = code


@dataclass(frozen=True)
class Refusal:
    """A write that did not happen."""

    address: int
    data: bytes
    code: StatusError


@dataclass
class _Profile:
    """Reference of the position controller, in rad and rad/s."""

    position: float = 0.0
    velocity: float = 0.0

    def advance(self, goal: float, speed: float, acceleration: float, dt: float) -> None:
        """Trapezoidal motion to `goal`; a speed of 0 means at once, an acceleration of 0 without limit."""
        if speed <= 0:
            self.position, self.velocity = goal, 0.0
            return
        distance = goal - self.position
        limit = min(speed, math.sqrt(2 * acceleration * abs(distance))) if acceleration > 0 else speed
        wanted = math.copysign(limit, distance)
        change = wanted - self.velocity
        if acceleration > 0:
            change = max(-acceleration * dt, min(acceleration * dt, change))
        self.velocity += change
        if abs(distance) <= abs(self.velocity) * dt:
            self.position, self.velocity = goal, 0.0
        else:
            self.position += self.velocity * dt


@dataclass
class Servo:
    """An emulated servo.

    Attributes:
        table: the model's control table.
        motor: its motor.
        supply_voltage: V at the connector.
        dead: it neither hears nor answers.
        refusals: writes that the firmware refused, in order.
        goal_extremes: lowest and highest raw goal position ever accepted.
    """

    table: ControlTable
    motor: Motor
    supply_voltage: float = 12.0
    dead: bool = False
    refusals: list[Refusal] = field(default_factory=list[Refusal])
    goal_extremes: tuple[int, int] | None = None
    registered: tuple[int, bytes] | None = None

    def __post_init__(self) -> None:
        table = self.table
        self.memory = bytearray(table.size)
        self._plain = {
            register.address: register
            for register in table.registers.values()
            if not register.name.startswith("Indirect")
        }
        self._owner = {a: r for r in self._plain.values() for a in range(r.address, r.end)}
        self._mirror = {
            block.data + i: block.address + 2 * i for block in table.indirect_blocks for i in range(block.count)
        }
        self._mapping = {a for b in table.indirect_blocks for a in range(b.address, b.address + 2 * b.count)}
        self._first_ram = table["Torque Enable"].address
        self._sensors = {name: table[name].address for name in _SENSORS if name in table}
        self._goal_address = table["Goal Position"].address
        self._velocity_unit = scale(table, "Present Velocity")[0]
        self._current_unit = amperes_per_unit(table.model)
        self._profile = _Profile()
        self._integral = 0.0
        self._overloaded_s = 0.0
        self._uptime_s = 0.0
        self._silence_s = 0.0
        self._rebooting_s = 0.0
        self.power_up(factory=True)

    @classmethod
    def make(
        cls, servo_id: int, *, model: str = "XM430-W350", baud: int = 1_000_000, motor: MotorModel | None = None,
        position: float = 0.0,
    ) -> "Servo":  # fmt: skip
        """A servo in factory state but for its id, baud rate and a return delay of 0; horn at `position` rad."""
        servo = cls(control_table(model), Motor(motor or MotorModel(), position=position))
        servo.set("ID", servo_id)
        servo.set("Baud Rate", BAUD_RATES.index(baud))
        servo.set("Return Delay Time", 0)
        servo.advance(0.0)
        servo.set("Goal Position", servo.get("Present Position"))
        return servo

    def power_up(self, *, factory: bool = False, keep: tuple[str, ...] = ()) -> None:
        """Reset the RAM area; with `factory` also EEPROM, but for the registers in `keep`."""
        kept = {name: self.get(name) for name in keep}
        self.memory[self._first_ram :] = bytes(len(self.memory) - self._first_ram)
        for name, value in FACTORY.items():
            if name in self.table and (factory or not self.table[name].eeprom):
                self.set(name, value)
        if factory:
            self.set("Model Number", self.table.number)
        for name, value in kept.items():
            self.set(name, value)
        for data, address in self._mirror.items():
            self.memory[address : address + 2] = data.to_bytes(2, "little")
        self.registered = None
        self._integral = self._overloaded_s = self._silence_s = 0.0
        self._load_settings()
        self._publish()
        self.set("Goal Position", self.get("Present Position"))
        self._load_settings()

    # State by name, without the firmware's rules.

    def get(self, name: str) -> int:
        """Raw value of a register."""
        register = self.table[name]
        return register.unpack(self.memory[register.address : register.end])

    def set(self, name: str, value: int) -> None:
        """Set a register from inside, without access rules."""
        register = self.table[name]
        self.memory[register.address : register.end] = register.pack(value)

    @property
    def id(self) -> int:
        return self.memory[self.table["ID"].address]

    @property
    def torque_on(self) -> bool:
        return bool(self.get("Torque Enable"))

    @property
    def alert(self) -> bool:
        return self.get("Hardware Error Status") != 0

    @property
    def answering(self) -> bool:
        return not self.dead and self._rebooting_s <= 0

    @property
    def return_delay_s(self) -> float:
        return to_si(self.table, "Return Delay Time", self.get("Return Delay Time"))

    def fail(self, bits: int) -> None:
        """Raise hardware errors; those in the Shutdown mask switch the torque off."""
        self.set("Hardware Error Status", self.get("Hardware Error Status") | bits)
        if bits & self.get("Shutdown"):
            self.set("Torque Enable", 0)
            self._load_settings()

    def reboot(self, silent_s: float) -> None:
        """Restart: RAM is lost, and nothing is heard for `silent_s`."""
        self.power_up()
        self._rebooting_s = silent_s

    def clear_turns(self) -> None:
        """Forget whole turns: the position within one turn stays."""
        turns = (self.get("Present Position") // 4096) * 4096
        self.motor.position -= turns * self.table.rad_per_tick
        self._profile = _Profile(self.motor.position)
        self._publish()
        self.set("Goal Position", self.get("Present Position"))
        self._load_goal()

    def restore(self, memory: bytes) -> None:
        """Take EEPROM and gains back from an earlier copy of `memory`."""
        first, last = self.table["Velocity I Gain"].address, self.table["Feedforward 1st Gain"].end
        self.memory[: self._first_ram] = memory[: self._first_ram]
        self.memory[first:last] = memory[first:last]
        self._load_settings()

    # Access as an instruction packet has it.

    def read(self, address: int, length: int) -> bytes:
        """Read bytes; Refused beyond the table."""
        if length == 0 or length > len(self.memory):
            raise Refused(StatusError.DATA_LENGTH)
        if address + length > len(self.memory):
            raise Refused(StatusError.ACCESS)
        memory, mirror = self.memory, self._mirror
        if address not in mirror and address + length - 1 not in mirror:
            return bytes(memory[address : address + length])
        return bytes(memory[self._resolve(a)] for a in range(address, address + length))

    def _resolve(self, address: int) -> int:
        """Where an address leads: indirect data lead to the address that their indirect address holds."""
        pointer = self._mirror.get(address)
        if pointer is None:
            return address
        target = int.from_bytes(self.memory[pointer : pointer + 2], "little")
        return target if target < len(self.memory) else address

    def write(self, address: int, data: bytes) -> None:
        """Write bytes, all or none.

        Raises:
            Refused: with the firmware's error code; `refusals` keeps it.
        """
        try:
            changes = self._plan(address, data)
        except Refused as refusal:
            self.refusals.append(Refusal(address, data, refusal.code))
            raise
        for start, piece, register in changes:
            self.memory[start : start + len(piece)] = piece
            if register is not None:
                self._written(register)

    def check_write(self, address: int, data: bytes) -> None:
        """Refused if `write` would be."""
        self._plan(address, data)

    def _plan(self, address: int, data: bytes) -> list[tuple[int, bytes, Register | None]]:
        """The changes that a write makes: start, bytes and register (None: mapping or spare indirect data)."""
        if not data:
            raise Refused(StatusError.DATA_LENGTH)
        changes: list[tuple[int, bytes, Register | None]] = []
        offset = 0
        while offset < len(data):
            where = address + offset
            start = self._resolve(where)
            register = self._plain.get(start)
            if register is not None:
                size = register.size
                piece = data[offset : offset + size]
                if len(piece) < size or any(self._resolve(where + i) != start + i for i in range(1, size)):
                    raise Refused(StatusError.DATA_LENGTH)
                self._check(register, register.unpack(piece))
            elif start in self._owner:
                raise Refused(StatusError.DATA_LENGTH)
            elif start in self._mapping:
                self._check_mapping(data[offset : offset + 2], start)
                size = 2
            elif start in self._mirror:
                size = 1
            else:
                raise Refused(StatusError.ACCESS)
            changes.append((start, data[offset : offset + size], register))
            offset += size
        return changes

    def _check_mapping(self, piece: bytes, start: int) -> None:
        if start % 2 or len(piece) < 2:
            raise Refused(StatusError.DATA_LENGTH)
        if self.torque_on:
            raise Refused(StatusError.ACCESS)
        if not self._first_ram <= int.from_bytes(piece, "little") < len(self.memory):
            raise Refused(StatusError.DATA_RANGE)

    def _check(self, register: Register, value: int) -> None:
        name = register.name
        if not register.writable or (register.eeprom and self.torque_on):
            raise Refused(StatusError.ACCESS)
        if name in _CHOICES and value not in _CHOICES[name]:
            raise Refused(StatusError.DATA_RANGE)
        if name in _GOALS and self.get("Bus Watchdog") == WATCHDOG_TRIPPED:
            raise Refused(StatusError.DATA_RANGE)
        if name == "Torque Enable" and value and self.get("Hardware Error Status") & self.get("Shutdown"):
            raise Refused(StatusError.RESULT_FAIL)
        if name == "Goal Position" and self._mode == POSITION and not self._lowest <= value <= self._highest:
            raise Refused(StatusError.DATA_LIMIT)
        limit = _LIMITED_BY.get(name)
        if limit is not None and limit in self.table and abs(value) > self.get(limit):
            raise Refused(StatusError.DATA_LIMIT)

    def _written(self, register: Register) -> None:
        """Consequences of a write."""
        if register.name == "Goal Position":
            value = self.get(register.name)
            low, high = self.goal_extremes or (value, value)
            self.goal_extremes = min(low, value), max(high, value)
            self._load_goal()
            return
        if register.name in ("Torque Enable", "Bus Watchdog"):
            self._silence_s = self._integral = 0.0
            self._profile = _Profile(self.motor.position)
        self._load_settings()

    # Time.

    def hear(self) -> None:
        """An instruction packet passed on the bus: the watchdog is content."""
        self._silence_s = 0.0

    def advance(self, dt: float) -> None:
        """Let `dt` s pass: controller, motor, watchdog, hardware errors."""
        self._uptime_s += dt
        if self._rebooting_s > 0:
            self._rebooting_s -= dt
        self._watch(dt)
        steps = math.ceil(dt / _STEP_S - 1e-9)
        for _ in range(steps):
            if self._torque:
                self.motor.step(self._duty(dt / steps), self.supply_voltage, dt / steps)
            else:
                self.motor.coast(dt / steps)
        self._diagnose(dt)
        self._publish()

    def _watch(self, dt: float) -> None:
        self._silence_s += dt
        if self._torque and 0 < self._watchdog_s < self._silence_s:
            self.set("Bus Watchdog", WATCHDOG_TRIPPED)
            self.set("Goal Velocity", 0)
            self.set("Goal PWM", 0)
            self._publish()
            self.set("Goal Position", self.get("Present Position"))
            self._load_settings()

    def _diagnose(self, dt: float) -> None:
        loaded = abs(self.motor.current) > 0.85 * self.motor.model.stall_current and self._torque
        self._overloaded_s = self._overloaded_s + dt if loaded else 0.0
        bits = OVERLOAD if self._overloaded_s > _OVERLOAD_S else 0
        if self.motor.temperature > self._temperature_limit:
            bits |= OVERHEATING
        if not self._voltage_limits[0] <= self.supply_voltage <= self._voltage_limits[1]:
            bits |= INPUT_VOLTAGE
        if bits:
            self.fail(bits)

    def _load_settings(self) -> None:
        """Take the controller's settings out of the table, in SI, so that the control step need not."""
        table = self.table

        def si(name: str) -> float:
            return to_si(table, name, self.get(name)) if name in table else 0.0

        self._torque = self.torque_on
        self._watchdog_s = 0.0 if self.get("Bus Watchdog") == WATCHDOG_TRIPPED else si("Bus Watchdog")
        self._voltage_limits = si("Min Voltage Limit"), si("Max Voltage Limit")
        self._temperature_limit = si("Temperature Limit")
        self._mode = self.get("Operating Mode")
        self._moving_threshold = self.get("Moving Threshold")
        self._lowest, self._highest = self.get("Min Position Limit"), self.get("Max Position Limit")
        self._offset = si("Homing Offset")
        self._goal_velocity, self._goal_duty = si("Goal Velocity"), si("Goal PWM")
        self._goal_current, self._current_limit = si("Goal Current"), si("Current Limit")
        self._duty_limit = si("PWM Limit")
        self._profile_velocity, self._profile_acceleration = si("Profile Velocity"), si("Profile Acceleration")
        # e-Manual: the PWM of 885 units is P / 128 per tick, I / 65,536 per tick and D / 16.
        tick = table.rad_per_tick
        self._kp = self.get("Position P Gain") / 128 / 885 / tick
        self._ki = self.get("Position I Gain") / 65_536 / 885 / tick * 1000
        self._kd = self.get("Position D Gain") / 16 / 885 / tick / 1000
        self._kv = self.get("Velocity P Gain") / 128 / 885 / scale(table, "Goal Velocity")[0] * 16
        self._load_goal()

    def _load_goal(self) -> None:
        """Take the goal position alone, which changes in every cycle."""
        goal = _INT32.unpack_from(self.memory, self._goal_address)[0]
        self._goal_position = (goal - self.table.zero_position) * self.table.rad_per_tick - self._offset

    def _duty(self, dt: float) -> float:
        motor = self.motor
        if self._mode == PWM:
            duty = self._goal_duty
        elif self._mode == VELOCITY:
            speed = self._goal_velocity / motor.model.no_load_speed
            duty = speed + self._kv * (self._goal_velocity - motor.velocity)
        elif self._mode == CURRENT:
            duty = self._duty_of_current(self._goal_current)
        else:
            duty = self._position_duty(dt)
        return max(-self._duty_limit, min(self._duty_limit, duty))

    def _position_duty(self, dt: float) -> float:
        profile = self._profile
        profile.advance(self._goal_position, self._profile_velocity, self._profile_acceleration, dt)
        error = profile.position - self.motor.position
        self._integral = max(-1.0, min(1.0, self._integral + self._ki * error * dt))
        duty = self._kp * error + self._integral - self._kd * self.motor.velocity
        if self._mode == CURRENT_POSITION and self._goal_current:
            low, high = sorted((self._duty_of_current(-self._goal_current), self._duty_of_current(self._goal_current)))
            duty = max(low, min(high, duty))
        return duty

    def _duty_of_current(self, current: float) -> float:
        model = self.motor.model
        return current / model.stall_current + self.motor.velocity / model.no_load_speed

    def _publish(self) -> None:
        """Write what the sensors see into the table."""
        motor, memory, sensors = self.motor, self.memory, self._sensors
        velocity = round(motor.velocity / self._velocity_unit)
        position = round((motor.position + self._offset) / self.table.rad_per_tick) + self.table.zero_position
        _INT32.pack_into(memory, sensors["Present Position"], position)
        _INT32.pack_into(memory, sensors["Present Velocity"], velocity)
        if "Present Current" in sensors:
            _INT16.pack_into(memory, sensors["Present Current"], round(motor.current / self._current_unit))
        _INT16.pack_into(memory, sensors["Present Input Voltage"], round(self.supply_voltage * 10))
        _INT16.pack_into(memory, sensors["Realtime Tick"], int(self._uptime_s * 1000) % 32768)
        memory[sensors["Present Temperature"]] = max(0, min(255, round(motor.temperature)))
        memory[sensors["Moving"]] = abs(velocity) > self._moving_threshold
