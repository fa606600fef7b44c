"""The driver of one robot's servos: check, enable, follow goals at the servo cycle, stop safely whatever happens."""

import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from types import TracebackType
from typing import Self

import numpy as np

from hw.board import Board, BoardWatch, judge, without_power
from hw.bus import Bus
from hw.configure import ram_settings
from hw.cycle import Cycle, Reading
from hw.goals import ramp
from hw.pace import realtime_priority
from hw.ready import check_ready
from hw.rig import Raw, Rig
from hw.safety import LostContact, Watch
from hw.servos import Servos, open_ports
from hw.stop import disarm, hold, torque_off
from hw.units import to_raw, to_si
from ros_free_stack.console import say
from ros_free_stack.errors import BusFault, LostServo, StackError, UnsafeCommand
from ros_free_stack.interrupts import Interrupts, caught_interrupts
from ros_free_stack.messages import Floats
from ros_free_stack.rate import Rate
from ros_free_stack.robots import StopPolicy

Recorder = Callable[[float, float, Floats, Reading], None]
"""Called each cycle with time (s), lateness (s), goal (N,) rad and the reading."""

_ARRIVAL_S = 0.1
"""s that a servo may lag behind its own profile."""
_UNLIMITED = 1 << 30


class Driver:
    """Servos of one robot. Use as a context manager: leaving it is the controlled stop.

        with Driver(rig, "/dev/ttyUSB0") as driver:
            driver.enable()
            driver.move_to(goals[0])
            driver.follow(goals)

    Attributes:
        rig: joints and servos.
        servos: the servos on their open ports.
        board: what gives them their power, where it is on the bus.
        cycle: the cyclic exchange.
        watch: the judge of every reading.
        rate: the loop's timing.
        realtime: whether the system gave the loop real-time priority.
    """

    def __init__(self, rig: Rig, port: str, *, at_end: StopPolicy = "off", power_up: bool = True) -> None:
        """
        Args:
            rig: joints, servos and what stops them.
            port: the serial port, or several with commas between them.
            at_end: whether the servos go limp or hold their last goal once all went well.
            power_up: whether the board may be told to give the servos power; else that it must be on.
        """
        self.rig, self.port = rig, port
        self.at_end: StopPolicy = at_end
        self._power_up = power_up
        self._enabled = False
        self._goal: Floats | None = None
        self._interrupts = Interrupts()

    def __enter__(self) -> Self:
        """Open the ports and check every servo, without moving any.

        Raises:
            PortError: a port cannot be opened.
            LostServo: a servo does not answer.
            ModelMismatch: a servo is not the model that the robot's servo map says.
            ServoFault: the servos have no power, a button of the board is pressed, or a servo reports an error.
            UnsafeCommand: a servo is not set up for the robot, holds torque, or stands outside its joint's range.
            BusFault: two servos have one id, or the servos cannot be read.
        """
        with ExitStack() as stack:
            self._interrupts = stack.enter_context(caught_interrupts())
            self.realtime = stack.enter_context(realtime_priority())
            buses = stack.enter_context(open_ports(self.port, self.rig.baud))
            self._find_board(buses)
            self.servos = Servos.find(self.rig, buses, self._interrupts.check)
            self.cycle = Cycle(self.servos)
            min_voltage = self._min_voltage()
            check_ready(self.servos, self.cycle, min_voltage, self._interrupts.check)
            self.watch = Watch(self.rig, self.rig.safety, min_voltage)
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
                cut = policy == "off" and self.board is not None and self.board.cut()
                done = f"{self.board.label} took the servos' power" if cut and self.board else "cut the power"
                warning = f"{state} NOT confirmed for {', '.join(unconfirmed)}: {done}"
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
            ServoFault: the first reading shows a fault.
            LostServo, BusFault, PortError: a servo or the port failed.
        """
        self._map_state()
        if self.cycle.method != "fast sync read":
            say(f"warning: the firmware lacks Fast Sync Read, using {self.cycle.method}")
        self._enabled = True
        for i in range(len(self.servos)):
            self._interrupts.check()
            self._prepare(i)
        for i in range(len(self.servos)):
            self.servos.write(i, "Torque Enable", 1)
        reading = self._read_all()
        self._goal = np.clip(reading.position, self.rig.lower, self.rig.upper)
        self.watch.check(reading, reading.position)
        self._bring_in(reading)
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
        for i in range(len(self.servos)):
            low, high = self._position_limits(i)
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
            self.board_watch.check()
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

    def _find_board(self, buses: tuple[Bus, ...]) -> None:
        """See to it that the servos have power before they are looked for."""
        self.board = Board.find(self.rig.board, buses)
        self.board_watch = BoardWatch(self.board, self.rig.safety.lost_after)
        if self.board is not None:
            if self._power_up:
                self.board.power_up()
            elif fault := without_power(self.board):
                raise fault
            judge(self.board, self.board.state())
        elif self.rig.board is not None:
            say(f"note: no {self.rig.board.name} answers; the servos must have power from elsewhere")

    def _min_voltage(self) -> Floats:
        if self.rig.safety.voltage is not None:
            return np.full(len(self.servos), self.rig.safety.voltage)
        name = "Min Voltage Limit"
        return np.array([to_si(self.servos.table(i), name, self.servos.read(i, name)) for i in range(len(self.servos))])

    def _map_state(self) -> None:
        """Point the indirect addresses at the state."""
        for i, identity in enumerate(self.rig.ids):
            self._interrupts.check()
            address, mapping = self.cycle.map_state(i)
            if self.servos.bus(i).read_bytes(identity, address, len(mapping)) != mapping:
                self.servos.bus(i).write_bytes(identity, address, mapping, "indirect addresses")

    def _prepare(self, i: int) -> None:
        """Goal where the horn is, gains and profile as the robot wants them, watchdog armed."""
        servos, position = self.servos, self.servos.read(i, "Present Position")
        servos.write(i, "Bus Watchdog", 0)
        for register, value in ram_settings(self.rig, i).items():
            servos.write(i, register, value)
        low, high = self._position_limits(i)
        if low <= position <= high:
            self.servos.write(i, "Goal Position", position)
        watchdog = to_raw(servos.table(i), "Bus Watchdog", self.rig.safety.watchdog_s)
        self.servos.write(i, "Bus Watchdog", max(1, watchdog))

    def _bring_in(self, reading: Reading) -> None:
        """Let servos that stand a little outside their range return to its end at the ramp's speed.

        No goal may lie out there, and the first one inside would be a jump: so the servos' own profile does it.
        """
        rig, goal = self.rig, np.clip(reading.position, self.rig.lower, self.rig.upper)
        distance = np.abs(reading.position - goal)
        outside = [int(i) for i in np.flatnonzero(distance > rig.tick)]
        speed = rig.safety.ramp_speed
        for i in outside:
            for register, value in ("Profile Velocity", speed), ("Profile Acceleration", float(rig.acceleration[i])):
                self.servos.write(i, register, max(1, to_raw(self.servos.table(i), register, value)))
        if outside:
            seconds = float((distance / speed + speed / rig.acceleration).max()) + _ARRIVAL_S
            self.follow(np.tile(goal, (math.ceil(seconds / rig.cycle_s), 1)))
        for i in outside:
            for register, value in ram_settings(rig, i).items():
                self.servos.write(i, register, value)

    def _position_limits(self, i: int) -> tuple[int, int]:
        """The servo's own limits of a goal position."""
        if self.rig.settings.mode != "position":
            return -_UNLIMITED, _UNLIMITED
        return self.servos.read(i, "Min Position Limit"), self.servos.read(i, "Max Position Limit")

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
        if silent and (fault := without_power(self.board)):
            return fault
        if silent:
            return LostServo(silent, f"for {self.rig.safety.lost_after} readings")
        names = ", ".join(self.rig.label(i) for i in suspects)
        return BusFault(f"{self.port}: {self.rig.safety.lost_after} readings in a row of {names} came damaged")
