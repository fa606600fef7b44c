"""What stops a stream: the watch over every reading and over the pace, by the robot's thresholds."""

from dataclasses import dataclass, field

import numpy as np

from hw.bus import error_name
from hw.cycle import Reading
from hw.rig import Rig
from ros_free_stack.errors import BusFault, DeadlineFault, ServoFault, StackError
from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robots import ServoSafety

HARDWARE_ERRORS = {0: "input voltage", 2: "overheating", 3: "motor encoder", 4: "electrical shock", 5: "overload"}


def hardware_errors(bits: int) -> str:
    """Names of hardware error bits."""
    return ", ".join(name for bit, name in HARDWARE_ERRORS.items() if bits >> bit & 1) or f"code {bits}"


class LostContact(Exception):
    """Servos missed too many readings; the driver finds out which of them are gone. `suspects` are indices."""

    def __init__(self, suspects: tuple[int, ...]) -> None:
        super().__init__(suspects)
        self.suspects = suspects


@dataclass
class Watch:
    """Looks at every reading and raises what must stop the robot.

    Attributes:
        min_voltage: (N,) V.
        lost_replies: readings that were asked for and did not come.
        max_following_error: rad, the worst so far.
    """

    rig: Rig
    limits: ServoSafety
    min_voltage: Floats
    lost_replies: int = 0
    max_following_error: float = 0.0
    _missed: np.ndarray = field(init=False)
    _off_track_s: np.ndarray = field(init=False)
    _strained_s: np.ndarray = field(init=False)
    _unread_s: np.ndarray = field(init=False)
    _late: int = 0

    def __post_init__(self) -> None:
        self._missed = np.zeros(len(self.rig.joints), dtype=int)
        self._off_track_s = np.zeros(len(self.rig.joints))
        self._strained_s = np.zeros(len(self.rig.joints))
        self._unread_s = np.zeros(len(self.rig.joints))
        self._strain = np.where(self.rig.measures_current, self.limits.current, self.limits.load)

    def check(self, reading: Reading, goal: Floats) -> None:
        """Judge a reading against the goal that was valid when it was taken (N,) rad.

        Raises:
            ServoFault: hardware error, temperature, voltage, torque gone, watchdog tripped, current, following error.
            BusFault: a servo refuses to be read.
            LostContact: too many readings missed.
        """
        missing = reading.asked & ~reading.fresh
        self._missed = np.where(reading.fresh, 0, self._missed + missing)
        self.lost_replies += int(missing.sum())
        if (self._missed >= self.limits.lost_after).any():
            self._blame_refusals(reading)
            raise LostContact(tuple(int(i) for i in np.flatnonzero(self._missed)))
        fault = self._fault(reading)
        if fault is not None:
            raise fault
        self._unread_s += self.rig.cycle_s
        self._load(reading)
        self._follow(reading, goal)
        self._unread_s[reading.fresh] = 0.0

    def _blame_refusals(self, reading: Reading) -> None:
        refusing = (self._missed > 0) & (reading.refusal > 0)
        if refusing.any():
            i = int(np.argmax(refusing))
            raise BusFault(f"{self.rig.label(i)} refuses to be read: {error_name(int(reading.refusal[i]))}")

    def _fault(self, reading: Reading) -> StackError | None:
        rig, limits = self.rig, self.limits
        if reading.alert.any() or reading.error.any():
            i = int(np.argmax(np.where(reading.error > 0, 2, reading.alert)))
            problem = hardware_errors(int(reading.error[i])) if reading.error[i] else "alert, cause not yet read"
            return ServoFault(rig.label(i), f"hardware error: {problem}; find the cause, then `servos reboot`")
        if reading.tripped.any():
            i = int(np.argmax(reading.tripped))
            return ServoFault(
                rig.label(i),
                f"bus watchdog tripped after {limits.watchdog_s:g} s of silence; `servos release` recovers it",
            )
        if not reading.torque.all():
            return ServoFault(rig.label(int(np.argmin(reading.torque))), "torque went off by itself: it restarted")
        hot = reading.temperature > limits.temperature
        if hot.any():
            i = int(np.argmax(hot))
            return ServoFault(rig.label(i), f"{reading.temperature[i]:.0f} deg C, limit {limits.temperature:g} deg C")
        low = reading.voltage < self.min_voltage
        if low.any():
            i = int(np.argmax(low))
            return ServoFault(rig.label(i), f"{reading.voltage[i]:.1f} V, minimum {self.min_voltage[i]:.1f} V")
        return None

    def _load(self, reading: Reading) -> None:
        strained = np.abs(reading.current) > self._strain
        self._strained_s = self._lasting(self._strained_s, strained, reading)
        if (self._strained_s > self.limits.current_s).any():
            i = int(np.argmax(self._strained_s))
            unit = "A" if self.rig.measures_current[i] else "of full load"
            raise ServoFault(
                self.rig.label(i),
                f"{abs(reading.current[i]):.2f} {unit} for {self._strained_s[i]:.2f} s, limit "
                f"{self._strain[i]:g} {unit} for {self.limits.current_s:g} s: blocked or overloaded",
            )

    def _lasting(self, seconds: Floats, bad: Bools, reading: Reading) -> Floats:
        """For how long something has been bad. An old reading says nothing; a new one speaks for the time since."""
        return np.where(reading.fresh, np.where(bad, seconds + self._unread_s, 0.0), seconds)

    def _follow(self, reading: Reading, goal: Floats) -> None:
        error = np.abs(reading.position - goal)
        self.max_following_error = max(self.max_following_error, float(error[reading.fresh].max(initial=0.0)))
        off = error > self.limits.following_error
        self._off_track_s = self._lasting(self._off_track_s, off, reading)
        if (self._off_track_s > self.limits.following_s).any():
            i = int(np.argmax(self._off_track_s))
            raise ServoFault(
                self.rig.label(i),
                f"following error {error[i]:.2f} rad for {self._off_track_s[i]:.2f} s, limit "
                f"{self.limits.following_error:g} rad for {self.limits.following_s:g} s: blocked or overloaded",
            )

    def check_pace(self, late_s: float) -> None:
        """Judge how late a cycle began.

        Raises:
            DeadlineFault: one long stall, or too many late cycles in a row.
        """
        self._late = self._late + 1 if late_s > self.rig.cycle_s else 0
        if late_s > self.limits.stall_s:
            raise DeadlineFault(f"the computer paused for {late_s:.2f} s, limit {self.limits.stall_s:g} s")
        if self._late >= self.limits.late_after:
            raise DeadlineFault(
                f"{self._late} cycles in a row were late: {1 / self.rig.cycle_s:.0f} Hz is too fast for this computer, "
                "port or baud rate"
            )
