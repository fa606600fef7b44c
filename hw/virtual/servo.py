"""One emulated X-series servo: its control table, controller and motor, and what its firmware does by itself.

Source: ROBOTIS e-Manual, X series: bus watchdog, hardware error status, shutdown, moving status, torque enable.
"""

import math
from dataclasses import dataclass, field

from hw.protocol import StatusError
from hw.registers import ControlTable, control_table
from hw.units import to_si
from hw.virtual.controller import Controller
from hw.virtual.factory import (
    BAUD_RATES,
    CURRENT,
    CURRENT_POSITION,
    INPUT_VOLTAGE,
    OVERHEATING,
    OVERLOAD,
    POSITION,
    PWM,
    TORQUE_ON_BY_GOAL,
    factory_values,
    supply_voltage,
)
from hw.virtual.goals import GoalLog
from hw.virtual.memory import GOALS, WATCHDOG_TRIPPED, Change, Memory, Refusal, Refused
from hw.virtual.motor import Motor, MotorModel
from hw.virtual.sensors import Sensors

STEP_S = 2e-3
"""Longest step of the physics, s."""

_REBOOT_S = 0.3
_START_S = 0.05
_OVERLOAD_S = 1.5
_FULL_TURN = 4096


@dataclass
class Servo:
    """An emulated servo.

    Attributes:
        table: the model's control table.
        motor: its motor.
        supply_voltage: V at the connector.
        dead: it neither hears nor answers.
        powered: it has power.
        refusals: writes that the firmware refused, in order.
        goals: every goal position it was told.
        registered: address and data of a Reg Write that waits for its Action.
        torque_changes: when (s of `clock_s`) the torque went on or off.
        clock_s: s since it was made.
    """

    table: ControlTable
    motor: Motor
    supply_voltage: float = 12.0
    dead: bool = False
    powered: bool = True
    refusals: list[Refusal] = field(default_factory=list[Refusal])
    goals: GoalLog = field(default_factory=GoalLog)
    registered: tuple[int, bytes] | None = None
    torque_changes: list[tuple[float, bool]] = field(default_factory=list[tuple[float, bool]])
    clock_s: float = 0.0

    def __post_init__(self) -> None:
        self._memory = Memory(self.table)
        self.get, self.set = self._memory.get, self._memory.set
        self._backup: list[bytes] = []
        self._baud_address = self.table["Baud Rate"].address
        self._was_on = False
        self._controller = Controller(self._memory, self.motor)
        self._sensors = Sensors(self._memory, self.motor, self._controller)
        self.power_up(factory=True)

    @classmethod
    def make(
        cls, servo_id: int, *, model: str = "XM430-W350", baud: int = 1_000_000, motor: MotorModel | None = None,
        position: float = 0.0, firmware: int | None = None,
    ) -> "Servo":  # fmt: skip
        """A servo in factory state but for its id, baud rate and a return delay of 0; horn at `position` rad."""
        volts = supply_voltage(model)
        servo = cls(
            control_table(model, firmware), Motor(motor or MotorModel(nominal_voltage=volts), position=position), volts
        )
        servo.set("ID", servo_id)
        servo.set("Baud Rate", BAUD_RATES.index(baud))
        servo.set("Return Delay Time", 0)
        return servo

    def power_up(self, *, factory: bool = False, keep: tuple[str, ...] = ()) -> None:
        """Reset the RAM area; with `factory` also EEPROM, but for the registers in `keep`."""
        kept = {name: self.get(name) for name in keep}
        self._memory.clear_ram()
        for name, value in factory_values(self.table).items():
            if factory or not self.table[name].eeprom:
                self.set(name, value)
        for name, value in kept.items():
            self.set(name, value)
        self.registered = None
        self._overloaded_s = self._silence_s = self._rebooting_s = self._up_s = 0.0
        self._reset_goals()
        self._forget_turns()
        self._settled()

    @property
    def memory(self) -> bytearray:
        """The bytes of the control table."""
        return self._memory.data

    @property
    def id(self) -> int:
        return self.memory[self.table["ID"].address]

    @property
    def baud(self) -> int:
        """Bits a second at which it hears and answers."""
        return BAUD_RATES[self.memory[self._baud_address]]

    @property
    def level(self) -> int:
        """Which instructions it answers: pings, reads too, or all."""
        return self.get("Status Return Level")

    @property
    def torque_on(self) -> bool:
        return bool(self.get("Torque Enable"))

    @property
    def alert(self) -> bool:
        return self.get("Hardware Error Status") != 0

    @property
    def answering(self) -> bool:
        return self.powered and not self.dead and self._rebooting_s <= 0

    @property
    def return_delay_s(self) -> float:
        return to_si(self.table, "Return Delay Time", self.get("Return Delay Time"))

    @property
    def goal_extremes(self) -> tuple[int, int] | None:
        """Lowest and highest raw goal position ever accepted."""
        return self.goals.accepted_extremes

    def fail(self, bits: int) -> None:
        """Raise hardware errors; those in the Shutdown mask switch the torque off."""
        self.set("Hardware Error Status", self.get("Hardware Error Status") | bits)
        if bits & self.get("Shutdown"):
            self.set("Torque Enable", 0)
        self._settled()

    def reboot(self, silent_s: float = _REBOOT_S) -> None:
        """Restart: RAM is lost, and nothing is heard for `silent_s`."""
        self.power_up()
        self._rebooting_s = silent_s

    def switch_power(self, *, on: bool) -> None:
        """Lose power, and RAM with it; or get it, and be silent until it has started."""
        self.powered = on
        self.reboot(_START_S if on else 0.0)

    def factory_reset(self, keep: tuple[str, ...]) -> None:
        """Forget everything but the registers in `keep`, then restart."""
        self.power_up(factory=True, keep=keep)
        self._rebooting_s = _REBOOT_S

    def clear_turns(self) -> None:
        """Forget whole turns: the position within one turn stays.

        Raises:
            Refused: it moves.
        """
        if self.get("Moving"):
            raise Refused(StatusError.RESULT_FAIL)
        self._forget_turns()
        self._settled()

    def store_backup(self) -> None:
        """Copy EEPROM, gains, profile and indirect addresses to the backup area; Refused while the torque is on."""
        self._refuse_under_torque()
        self._backup = [bytes(self.memory[part]) for part in self._memory.backed_up()]

    def restore_backup(self) -> None:
        """Take the EEPROM back and restart; Refused while the torque is on or where there is no backup."""
        self._refuse_under_torque()
        if not self._backup:
            raise Refused(StatusError.RESULT_FAIL)
        parts = list(zip(self._memory.backed_up(), self._backup, strict=True))
        part, data = parts[0]
        self.memory[part] = data
        self.reboot()
        for part, data in parts[1:]:
            self.memory[part] = data
        self._settled()

    def read(self, address: int, length: int) -> bytes:
        """Read bytes; Refused beyond the table."""
        return self._memory.read(address, length)

    def check_write(self, address: int, data: bytes) -> None:
        """Refused if `write` would be."""
        self._memory.plan(address, data)

    def write(self, address: int, data: bytes, *, ram_only: bool = False) -> None:
        """Write bytes, all or none; with `ram_only` the EEPROM is not open, as under a secondary id.

        Raises:
            Refused: with the firmware's error code; `refusals` keeps it.
        """
        try:
            changes = self._memory.plan(address, data)
            if ram_only and any(change.address < self._memory.ram for change in changes):
                raise Refused(StatusError.ACCESS)
        except Refused as refusal:
            self.refusals.append(Refusal(address, data, refusal.code))
            goal = self.table["Goal Position"]
            if address == goal.address and len(data) == goal.size:
                self._log_goal(goal.unpack(data), accepted=False)
            raise
        was_on = self.torque_on
        self._memory.apply(changes)
        for change in changes:
            self._written(change, was_on)

    def _written(self, change: Change, was_on: bool) -> None:
        """Consequences of a write."""
        name = change.register.name if change.register is not None else ""
        if name == "Goal Position":
            self._log_goal(self.get(name), accepted=True)
            self._controller.take_goal()
        if name in GOALS and "Drive Mode" in self.table and self.get("Drive Mode") & TORQUE_ON_BY_GOAL:
            blocked = self.get("Hardware Error Status") & self.get("Shutdown")
            self.set("Torque Enable", int(not blocked))
        if name == "Operating Mode":
            self._reset_goals()
        if name == "Bus Watchdog":
            self._silence_s = 0.0
        if name == "Goal Position" and self.torque_on == was_on:
            return
        if self.torque_on and not was_on:
            self._silence_s = 0.0
            if self.get("Operating Mode") == POSITION:
                self._forget_turns(goal=False)
            self._controller.reset()
        self._settled()

    def _log_goal(self, value: int, *, accepted: bool) -> None:
        low, high = self.get("Min Position Limit"), self.get("Max Position Limit")
        self.goals.add(self.clock_s, value, accepted=accepted, low=low, high=high)

    def hear(self) -> None:
        """An instruction packet passed on the bus: the watchdog is content."""
        self._silence_s = 0.0

    def advance(self, dt: float) -> None:
        """Let `dt` s pass: watchdog, controller, motor, hardware errors."""
        self.pass_time(dt)
        steps = math.ceil(dt / STEP_S - 1e-9)
        for _ in range(steps):
            duty = self.drive(dt / steps)
            if duty is None:
                self.motor.coast(dt / steps)
            else:
                self.motor.step(duty, self.supply_voltage, dt / steps)
        self.sense(dt)

    def pass_time(self, dt: float) -> None:
        """First part of `advance`: clocks and watchdog."""
        self.clock_s += dt
        self._up_s += dt
        self._rebooting_s -= dt
        self._silence_s += dt
        if self._torque and 0 < self._watchdog_s < self._silence_s:
            self._trip()

    def drive(self, dt: float) -> float | None:
        """Second part, once a step: the duty of the bridge, None where it is open."""
        return self._controller.step(dt) if self._torque else None

    def sense(self, dt: float) -> None:
        """Last part: hardware errors, and what the sensors see into the table."""
        loaded = abs(self.motor.current) > 0.85 * self.motor.model.stall_current and self._torque
        self._overloaded_s = self._overloaded_s + dt if loaded else 0.0
        bits = OVERLOAD if self._overloaded_s > _OVERLOAD_S else 0
        if self.motor.temperature > self._temperature_limit:
            bits |= OVERHEATING
        if not self._voltage_limits[0] <= self.supply_voltage <= self._voltage_limits[1]:
            bits |= INPUT_VOLTAGE
        if bits & ~self.get("Hardware Error Status"):
            self.fail(bits)
        self._sensors.publish(torque=self._torque, up_s=self._up_s, volts=self.supply_voltage)

    def _trip(self) -> None:
        """The host went silent: stop where the horn is, and take no goals."""
        self.set("Bus Watchdog", WATCHDOG_TRIPPED)
        stopped = ["Profile Velocity", "Profile Acceleration", "Goal Velocity"]
        stopped += {PWM: ["Goal PWM"], CURRENT: ["Goal Current"]}.get(self._controller.mode, [])
        for name in stopped:
            if name in self.table:
                self.set(name, 0)
        self.set("Goal Position", self._controller.to_table(self.motor.position))
        self._controller.load()
        self._controller.take_goal()
        self._settled()

    def _reset_goals(self) -> None:
        """Goals of a fresh start: no motion, and no more bound than the limits."""
        mode = self.get("Operating Mode")
        self.set("Goal PWM", 0 if mode == PWM else self.get("PWM Limit"))
        if "Goal Current" in self.table:
            self.set("Goal Current", self.get("Current Limit") if mode == CURRENT_POSITION else 0)
        for name in ("Goal Velocity", "Profile Velocity", "Profile Acceleration"):
            self.set(name, 0)

    def _forget_turns(self, *, goal: bool = True) -> None:
        controller = self._controller
        controller.load()
        raw = controller.to_table(self.motor.position)
        self.motor.position = self.motor.position - controller.sign * self.table.rad_per_tick * (
            raw // _FULL_TURN * _FULL_TURN
        )
        if goal:
            self.set("Goal Position", controller.to_table(self.motor.position))
        controller.reset()

    def _refuse_under_torque(self) -> None:
        if self.torque_on:
            raise Refused(StatusError.RESULT_FAIL)

    def _settled(self) -> None:
        """Registers changed: take the settings out of the table, in SI, so that the steps need not."""
        self._controller.load()
        self._torque = self.torque_on
        if self._torque != self._was_on:
            self._was_on = self._torque
            self.torque_changes.append((self.clock_s, self._torque))
            self._controller.take_goal()
        watchdog = self.get("Bus Watchdog")
        self._watchdog_s = 0.0 if watchdog == WATCHDOG_TRIPPED else to_si(self.table, "Bus Watchdog", watchdog)
        self._voltage_limits = tuple(
            to_si(self.table, name, self.get(name)) for name in ("Min Voltage Limit", "Max Voltage Limit")
        )
        self._temperature_limit = self.get("Temperature Limit")
        self._sensors.load()
        self._sensors.publish(torque=self._torque, up_s=self._up_s, volts=self.supply_voltage)
