"""The driver of one robot's servos: check, enable, follow goals at the servo cycle, stop safely whatever happens."""

import time
from collections.abc import Callable
from contextlib import ExitStack
from types import TracebackType
from typing import Literal, Self

import numpy as np

from hw.bus import Bus
from hw.cycle import Cycle, Reading
from hw.interrupts import Interrupts, caught_interrupts
from hw.pace import Pace, realtime_priority
from hw.resample import ramp
from hw.rig import Raw, Rig
from hw.safety import Limits, LostContact, Watch, hardware_errors
from hw.stop import hold, torque_off
from hw.units import to_raw, to_si
from ros_free_stack.console import say
from ros_free_stack.errors import BusFault, LostServo, ModelMismatch, ServoFault, StackError, UnsafeCommand
from ros_free_stack.messages import Floats

AtEnd = Literal["off", "hold"]
Recorder = Callable[[float, float, Floats, Reading], None]
"""Called each cycle with time (s), lateness (s), goal (N,) rad and the reading."""

_POSITION_MODES = {3: "position", 4: "extended position", 5: "current-based position"}


class Driver:
    """Servos of one robot on one port. Use as a context manager: leaving it is the controlled stop.

        with Driver(rig, "/dev/ttyUSB0") as driver:
            driver.enable()
            driver.move_to(goals[0])
            driver.follow(goals)

    Attributes:
        rig: joints and servos.
        bus: the open port.
        cycle: the cyclic exchange.
        watch: the judge of every reading.
        pace: the loop's timing.
        realtime: whether the system gave the loop real-time priority.
    """

    def __init__(self, rig: Rig, port: str, *, limits: Limits | None = None, at_end: AtEnd = "off") -> None:
        """`at_end` says whether the servos go limp or hold their last goal once all went well; a fault ends limp."""
        self.rig, self.port = rig, port
        self.limits = limits or Limits()
        self.at_end: AtEnd = at_end
        self._enabled = False
        self._goal: Floats | None = None
        self._interrupts = Interrupts()

    def __enter__(self) -> Self:
        """Open the port and check every servo, without moving any.

        Raises:
            PortError: the port cannot be opened.
            LostServo: a servo does not answer.
            ModelMismatch: a servo is not the model that the robot's servo map says.
            ServoFault: a servo reports a hardware error.
            UnsafeCommand: a servo is not in a position mode.
        """
        with ExitStack() as stack:
            self._interrupts = stack.enter_context(caught_interrupts())
            self.realtime = stack.enter_context(realtime_priority())
            self.bus = stack.enter_context(Bus(self.port, self.rig.baud))
            self._check_models()
            self._check_servos()
            self.cycle = Cycle(self.bus, self.rig)
            self.watch = Watch(self.rig, self.limits, self._min_voltage())
            self.pace = Pace(self.rig.cycle_s)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._stack:
            if not self._enabled:
                return
            unconfirmed = self._stop(limp=error is not None or self.at_end == "off")
            if not unconfirmed:
                return
            warning = f"torque off NOT confirmed for {', '.join(unconfirmed)}: cut the power"
            if isinstance(error, StackError):
                error.args = (f"{error}; {warning}",)
            elif error is not None:
                say(f"warning: {warning}")
            else:
                raise LostServo(unconfirmed, f"when the torque was switched off; {warning}")

    def enable(self) -> Reading:
        """Prepare every servo (RAM only), switch the torque on where it stands, arm the watchdogs.

        Returns:
            The first reading.

        Raises:
            UnsafeCommand: a servo holds torque already and cannot be prepared without letting go.
        """
        self._map_state()
        method = self.cycle.choose_method()
        if method != "fast sync read":
            say(f"warning: the firmware lacks Fast Sync Read, using {method}")
        self._enabled = True
        for i in range(len(self.rig.ids)):
            self._interrupts.check()
            self._prepare(i)
        for identity in self.rig.ids:
            self.bus.write(identity, self.rig.table, "Torque Enable", 1)
        reading = self._read_all()
        self._goal = np.clip(reading.position, self.rig.lower, self.rig.upper)
        return reading

    def measure(self) -> Floats:
        """(N,) present joint angles, rad; moves and changes nothing."""
        raw = [self.bus.read(identity, self.rig.table, "Present Position") for identity in self.rig.ids]
        return self.rig.to_angles(np.array(raw))

    def check_goals(self, goals: Floats) -> Raw:
        """Goal positions of all goals (K, N), checked against the joints' and the servos' own ranges.

        Raises:
            UnsafeCommand: a goal outside the range of the joint or of the servo's position limits.
        """
        raw = self.rig.to_raw(goals)
        for i, identity in enumerate(self.rig.ids):
            if self.bus.read(identity, self.rig.table, "Operating Mode") != 3:
                continue
            low, high = (self.bus.read(identity, self.rig.table, f"{end} Position Limit") for end in ("Min", "Max"))
            if raw[:, i].min() < low or raw[:, i].max() > high:
                raise UnsafeCommand(
                    f"{self.rig.label(i)} would go to {raw[:, i].min()}..{raw[:, i].max()}, its own position limits "
                    f"are {low}..{high}: run `servos configure`"
                )
        return raw

    def move_to(self, pose: Floats, record: Recorder | None = None) -> int:
        """Ramp from the present goal to a pose (N,) rad at a safe speed; return the number of cycles.

        Raises: as `follow`.
        """
        assert self._goal is not None, "enable() comes first"
        path = ramp(self._goal, pose, speed=self.limits.ramp_speed, cycle_s=self.rig.cycle_s)
        self.follow(path, record)
        return len(path)

    def follow(self, goals: Floats, record: Recorder | None = None) -> None:
        """Command goals (K, N) rad, one a cycle, and watch every reading.

        Raises:
            UnsafeCommand: a goal outside the joint's range; raised before the first is sent.
            ServoFault, LostServo, BusFault, DeadlineFault, PortError: the robot must stop.
            KeyboardInterrupt: Ctrl-C or SIGTERM came.
        """
        assert self._goal is not None, "enable() comes first"
        raw, valid = self.rig.to_raw(goals), self._goal
        self.pace.resume()
        for goal, command in zip(goals, raw, strict=True):
            self._interrupts.check()
            reading = self.cycle.exchange(command)
            try:
                self.watch.check(reading, valid)
            except LostContact as lost:
                raise self._diagnose(lost.suspects) from None
            self._goal = valid = goal
            late = self.pace.sleep()
            if record is not None:
                record(time.perf_counter(), late, goal, reading)
            self.watch.check_pace(late)

    def _stop(self, *, limp: bool) -> tuple[str, ...]:
        """Hold, then let go; return the servos that did not confirm."""
        try:
            if self._goal is not None:
                reading = self.cycle.exchange(None)
                still = np.where(reading.fresh, reading.position, self._goal) if limp else self._goal
                still = np.clip(still, self.rig.lower, self.rig.upper)
                hold(self.cycle, self.rig, self.rig.to_raw(still), self.limits.hold_s)
            if not limp:
                for identity in self.rig.ids:
                    self.bus.write(identity, self.rig.table, "Bus Watchdog", 0)
                return ()
        except Exception as error:
            # Whatever went wrong here, letting go comes next, and reports which servos do not answer.
            say(f"warning: could not hold still: {error}")
        return torque_off(self.bus, self.rig)

    def _check_models(self) -> None:
        silent: list[str] = []
        for i, identity in enumerate(self.rig.ids):
            self._interrupts.check()
            found = self.bus.ping(identity)
            if found is None:
                silent.append(self.rig.label(i))
            elif found != self.rig.table.model:
                raise ModelMismatch(
                    f"{self.rig.label(i)} is an {found}, the servo map of {self.rig.robot} says {self.rig.table.model}"
                )
        if silent:
            raise LostServo(silent, f"to a ping at {self.rig.baud} baud on {self.port}")

    def _check_servos(self) -> None:
        for i, identity in enumerate(self.rig.ids):
            error = self.bus.read(identity, self.rig.table, "Hardware Error Status")
            if error:
                raise ServoFault(self.rig.label(i), f"hardware error: {hardware_errors(error)}; run `servos reboot`")
            mode = self.bus.read(identity, self.rig.table, "Operating Mode")
            if mode not in _POSITION_MODES:
                valid = ", ".join(f"{number} ({name})" for number, name in _POSITION_MODES.items())
                raise UnsafeCommand(
                    f"{self.rig.label(i)} is in operating mode {mode}, valid: {valid}; run `servos configure`"
                )

    def _min_voltage(self) -> Floats:
        if self.limits.voltage is not None:
            return np.full(len(self.rig.ids), self.limits.voltage)
        table = self.rig.table
        raw = [self.bus.read(identity, table, "Min Voltage Limit") for identity in self.rig.ids]
        return np.array([to_si(table, "Min Voltage Limit", value) for value in raw])

    def _map_state(self) -> None:
        """Point the indirect addresses at the state; they are locked while the torque is on."""
        address, mapping = self.cycle.mapping
        for i, identity in enumerate(self.rig.ids):
            self._interrupts.check()
            if self.bus.read_bytes(identity, address, len(mapping)) == mapping:
                continue
            if self.bus.read(identity, self.rig.table, "Torque Enable"):
                raise UnsafeCommand(f"{self.rig.label(i)} already holds torque: support the robot, `servos release`")
            self.bus.write_bytes(identity, address, mapping, "indirect addresses")

    def _prepare(self, i: int) -> None:
        """Goal where the horn is, no profile, watchdog armed."""
        identity, table = self.rig.ids[i], self.rig.table
        self.bus.write(identity, table, "Bus Watchdog", 0)
        for register in ("Profile Acceleration", "Profile Velocity"):
            self.bus.write(identity, table, register, 0)
        position = self.bus.read(identity, table, "Present Position")
        angle = float(self.rig.to_angles(np.full(len(self.rig.ids), position))[i])
        if not self.rig.lower[i] - 0.1 <= angle <= self.rig.upper[i] + 0.1:
            raise UnsafeCommand(
                f"{self.rig.label(i)} stands at {angle:.3f} rad, outside its range {self.rig.lower[i]:.3f} to "
                f"{self.rig.upper[i]:.3f} rad: move it by hand or calibrate"
            )
        self.bus.write(identity, table, "Goal Position", position)
        self.bus.write(identity, table, "Bus Watchdog", to_raw(table, "Bus Watchdog", self.limits.watchdog_s))

    def _read_all(self) -> Reading:
        """A reading in which every servo answered, or LostServo."""
        seen = np.zeros(len(self.rig.ids), dtype=bool)
        reading = self.cycle.exchange(None)
        for _ in range(self.limits.lost_after * len(self.rig.ids)):
            seen |= reading.fresh
            if seen.all():
                return reading
            reading = self.cycle.exchange(None)
        raise self._diagnose(tuple(int(i) for i in np.flatnonzero(~seen)))

    def _diagnose(self, suspects: tuple[int, ...]) -> StackError:
        """Who is gone: one silent servo silences all behind it in a group read, so ask each."""
        silent = [self.rig.label(i) for i in suspects if self.bus.ping(self.rig.ids[i]) is None]
        if silent:
            return LostServo(silent, f"for {self.limits.lost_after} cycles")
        names = ", ".join(self.rig.label(i) for i in suspects)
        return BusFault(f"{self.port}: {self.limits.lost_after} readings in a row of {names} came damaged")
