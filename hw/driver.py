"""The driver of one robot's servos: check, enable, follow goals at the servo cycle, stop safely whatever happens."""

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from types import TracebackType
from typing import Self

import numpy as np

from hw.configure import MODES, pose_settings, ram_settings
from hw.cycle import Cycle, Reading
from hw.goals import ramp
from hw.line import WATCHDOG_TRIPPED
from hw.pace import realtime_priority
from hw.rig import Raw, Rig
from hw.safety import LostContact, Watch, hardware_errors
from hw.servos import Servos, open_ports
from hw.stop import disarm, hold, torque_off
from hw.units import to_raw, to_si
from ros_free_stack.console import say
from ros_free_stack.errors import BusFault, LostServo, ServoFault, StackError, UnsafeCommand
from ros_free_stack.interrupts import Interrupts, caught_interrupts
from ros_free_stack.messages import Floats
from ros_free_stack.rate import Rate
from ros_free_stack.robots import StopPolicy

Recorder = Callable[[float, float, Floats, Reading], None]
"""Called each cycle with time (s), lateness (s), goal (N,) rad and the reading."""

_SLACK = 0.1
"""rad that a joint may stand outside its range when it is enabled; the ramp brings it back in."""


class Driver:
    """Servos of one robot. Use as a context manager: leaving it is the controlled stop.

        with Driver(rig, "/dev/ttyUSB0") as driver:
            driver.enable()
            driver.move_to(goals[0])
            driver.follow(goals)

    Attributes:
        rig: joints and servos.
        servos: the servos on their open ports.
        cycle: the cyclic exchange.
        watch: the judge of every reading.
        rate: the loop's timing.
        realtime: whether the system gave the loop real-time priority.
    """

    def __init__(self, rig: Rig, port: str, *, at_end: StopPolicy = "off") -> None:
        """
        Args:
            rig: joints, servos and what stops them.
            port: the serial port, or several with commas between them.
            at_end: whether the servos go limp or hold their last goal once all went well.
        """
        self.rig, self.port = rig, port
        self.at_end: StopPolicy = at_end
        self._enabled = False
        self._goal: Floats | None = None
        self._interrupts = Interrupts()

    def __enter__(self) -> Self:
        """Open the ports and check every servo, without moving any.

        Raises:
            PortError: a port cannot be opened.
            LostServo: a servo does not answer.
            ModelMismatch: a servo is not the model that the robot's servo map says.
            ServoFault: a servo reports a hardware error, or its watchdog tripped and nobody recovered it.
            UnsafeCommand: a servo is not set up for the robot.
        """
        with ExitStack() as stack:
            self._interrupts = stack.enter_context(caught_interrupts())
            self.realtime = stack.enter_context(realtime_priority())
            buses = stack.enter_context(open_ports(self.port, self.rig.baud))
            self.servos = Servos.find(self.rig, buses, self._interrupts.check)
            self._check_servos()
            self.cycle = Cycle(self.servos)
            self.watch = Watch(self.rig, self.rig.safety, self._min_voltage())
            self.rate = Rate(1 / self.rig.cycle_s)
            self._stack = stack.pop_all()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with self._stack:
            if not self._enabled:
                return
            fault = error or self._settle()
            policy = self.at_end if fault is None else self.rig.safety.on_fault
            if fault is not None:
                self._hold_still()
            unconfirmed = torque_off(self.servos) if policy == "off" else disarm(self.servos)
            if unconfirmed:
                state = "torque off" if policy == "off" else "hold"
                warning = f"{state} NOT confirmed for {', '.join(unconfirmed)}: cut the power"
                if isinstance(fault, StackError):
                    fault.args = (f"{fault}; {warning}",)
                elif fault is not None:
                    say(f"warning: {warning}")
                else:
                    raise LostServo(unconfirmed, f"when the stream stopped; {warning}")
            if fault is not None and fault is not error:
                raise fault

    def enable(self) -> Reading:
        """Prepare every servo (RAM only), switch the torque on where it stands, arm the watchdogs.

        Returns:
            The first reading.

        Raises:
            UnsafeCommand: a servo holds torque already and cannot be prepared without letting go, or stands outside
                its joint's range.
            ServoFault: the first reading shows a fault.
        """
        self._map_state()
        method = self.cycle.choose_method()
        if method != "fast sync read":
            say(f"warning: the firmware lacks Fast Sync Read, using {method}")
        self._enabled = True
        for i in range(len(self.servos)):
            self._interrupts.check()
            self._prepare(i)
        for i in range(len(self.servos)):
            self.servos.write(i, "Torque Enable", 1)
        reading = self._read_all()
        self._goal = np.clip(reading.position, self.rig.lower, self.rig.upper)
        self.watch.check(reading, reading.position)
        return reading

    def measure(self) -> Floats:
        """(N,) present joint angles, rad; moves and changes nothing."""
        raw = [self.servos.read(i, "Present Position") for i in range(len(self.servos))]
        return self.rig.to_angles(np.array(raw))

    def check_goals(self, goals: Floats) -> Raw:
        """Goal positions of all goals (K, N), checked against the joints' and the servos' own ranges.

        Raises:
            UnsafeCommand: a goal outside the range of the joint or of the servo's position limits.
        """
        raw = self.rig.to_raw(goals)
        for i in range(len(self.servos) if self.rig.settings.mode == "position" else 0):
            low, high = (self.servos.read(i, f"{end} Position Limit") for end in ("Min", "Max"))
            if raw[:, i].min() < low or raw[:, i].max() > high:
                raise UnsafeCommand(
                    f"{self.rig.label(i)} would go to {raw[:, i].min()}..{raw[:, i].max()}, its own position limits "
                    f"are {low}..{high}: run `servos configure`"
                )
        return raw

    def ramp_to(self, pose: Floats) -> Floats:
        """Goals (K, N) from the present goal, or where the servos stand, to a pose (N,) rad at a safe speed."""
        rig = self.rig
        start = np.clip(self.measure(), rig.lower, rig.upper) if self._goal is None else self._goal
        return ramp(start, pose, speed=rig.safety.ramp_speed, acceleration=rig.acceleration, cycle_s=rig.cycle_s)

    def move_to(self, pose: Floats) -> None:
        """Go to a pose (N,) rad at a safe speed; errors as `follow`."""
        self.follow(self.ramp_to(pose))

    def follow(self, goals: Floats, record: Recorder | None = None) -> None:
        """Command goals (K, N) rad, one a cycle, and watch every reading.

        Raises:
            UnsafeCommand: a goal outside the joint's range or too far from the one before; raised before the first is
                sent.
            ServoFault, LostServo, BusFault, DeadlineFault, PortError: the robot must stop.
            KeyboardInterrupt: Ctrl-C or SIGTERM came.
        """
        assert self._goal is not None, "enable() comes first"
        raw, valid = self.rig.to_raw(goals), self._goal
        self.rig.check_steps(valid, goals)
        self.rate.resume()
        for goal, command in zip(goals, raw, strict=True):
            self._interrupts.check()
            reading = self.cycle.exchange(command)
            try:
                self.watch.check(reading, valid)
            except LostContact as lost:
                raise self._diagnose(lost.suspects) from None
            self._goal = valid = goal
            late = self.rate.sleep()
            if record is not None:
                record(time.perf_counter(), late, goal, reading)
            self.watch.check_pace(late)

    def _settle(self) -> BaseException | None:
        """Hold the last goal for a while, watched like every cycle; return what went wrong."""
        if self._goal is None:
            return None
        try:
            self.follow(np.tile(self._goal, (math.ceil(self.rig.safety.hold_s / self.rig.cycle_s), 1)))
        except (StackError, KeyboardInterrupt) as fault:
            return fault
        return None

    def _hold_still(self) -> None:
        """After a fault: stop every servo where it is, whatever the bus does."""
        if self._goal is None:
            return
        try:
            reading = self.cycle.exchange(None)
            still = np.where(reading.fresh, reading.position, self._goal)
            goals = self.rig.to_raw(np.clip(still, self.rig.lower, self.rig.upper))
            hold(self.cycle, goals, self.rig.safety.hold_s, self.rig.cycle_s)
        except Exception as error:
            # Whatever went wrong here, what comes next is tried, and reports which servos do not answer.
            say(f"warning: could not hold still: {error}")

    def _check_servos(self) -> None:
        wanted = pose_settings(self.rig)
        for i in range(len(self.servos)):
            self._interrupts.check()
            label = self.rig.label(i)
            if error := self.servos.read(i, "Hardware Error Status"):
                raise ServoFault(label, f"hardware error: {hardware_errors(error)}; run `servos reboot`")
            if self.servos.read(i, "Bus Watchdog") == WATCHDOG_TRIPPED:
                raise ServoFault(
                    label, "its bus watchdog tripped: a stream before this one died; run `servos release` to recover it"
                )
            for register, value in wanted.items():
                if (found := self.servos.read(i, register)) != value:
                    words = f" ({self.rig.settings.mode})" if value == MODES[self.rig.settings.mode] else ""
                    raise UnsafeCommand(
                        f"{label} has {register} {found}, {self.rig.robot} needs {value}{words}; run `servos configure`"
                    )

    def _min_voltage(self) -> Floats:
        if self.rig.safety.voltage is not None:
            return np.full(len(self.servos), self.rig.safety.voltage)
        name = "Min Voltage Limit"
        return np.array([to_si(self.servos.table(i), name, self.servos.read(i, name)) for i in range(len(self.servos))])

    def _map_state(self) -> None:
        """Point the indirect addresses at the state; they are locked while the torque is on."""
        for i, identity in enumerate(self.rig.ids):
            self._interrupts.check()
            address, mapping = self.cycle.map_state(i)
            if self.servos.bus(i).read_bytes(identity, address, len(mapping)) == mapping:
                continue
            if self.servos.read(i, "Torque Enable"):
                raise UnsafeCommand(f"{self.rig.label(i)} already holds torque: support the robot, `servos release`")
            self.servos.bus(i).write_bytes(identity, address, mapping, "indirect addresses")

    def _prepare(self, i: int) -> None:
        """Goal where the horn is, gains and profile as the robot wants them, watchdog armed."""
        self.servos.write(i, "Bus Watchdog", 0)
        for register, value in ram_settings(self.rig, i).items():
            self.servos.write(i, register, value)
        position = self.servos.read(i, "Present Position")
        angle = float(self.rig.to_angles(np.full(len(self.servos), position))[i])
        if not self.rig.lower[i] - _SLACK <= angle <= self.rig.upper[i] + _SLACK:
            raise UnsafeCommand(
                f"{self.rig.label(i)} stands at {angle:.3f} rad, outside its range {self.rig.lower[i]:.3f} to "
                f"{self.rig.upper[i]:.3f} rad: move it by hand or calibrate"
            )
        self.servos.write(i, "Goal Position", position)
        watchdog = to_raw(self.servos.table(i), "Bus Watchdog", self.rig.safety.watchdog_s)
        self.servos.write(i, "Bus Watchdog", max(1, watchdog))

    def _read_all(self) -> Reading:
        """A reading in which every servo answered, or LostServo."""
        seen = np.zeros(len(self.servos), dtype=bool)
        reading = self.cycle.exchange(None)
        for _ in range(self.rig.safety.lost_after * len(self.servos)):
            seen |= reading.fresh
            if seen.all():
                return reading
            reading = self.cycle.exchange(None)
        raise self._diagnose(tuple(int(i) for i in np.flatnonzero(~seen)))

    def _diagnose(self, suspects: tuple[int, ...]) -> StackError:
        """Who is gone: one silent servo silences all behind it in a group read, so ask each."""
        silent = [self.rig.label(i) for i in suspects if not self.servos.ping(i)]
        if silent:
            return LostServo(silent, f"for {self.rig.safety.lost_after} readings")
        names = ", ".join(self.rig.label(i) for i in suspects)
        return BusFault(f"{self.port}: {self.rig.safety.lost_after} readings in a row of {names} came damaged")
