"""What a stream commanded and measured, cycle by cycle, kept for the report."""

import numpy as np

from hw.cycle import Reading
from hw.rig import Rig
from ros_free_stack.messages import Floats, ServoTelemetry


class Recording:
    """A recording of up to `cycles` cycles."""

    def __init__(self, rig: Rig, cycles: int) -> None:
        self._rig = rig
        self.cycles = 0
        shape = (cycles, len(rig.joints))
        self._time = np.zeros(cycles)
        self._late = np.zeros(cycles)
        self._columns = {name: np.zeros(shape) for name in ("goal", *ServoTelemetry.MEASURED)}
        self._fresh = np.zeros(shape, dtype=bool)

    @staticmethod
    def size(rig: Rig, cycles: int) -> int:
        """Bytes that a file of so many cycles takes at most; the way in is taken to last as long as the rest."""
        return 2 * cycles * len(rig.joints) * (8 * (1 + len(ServoTelemetry.MEASURED)) + 1) + 1_000_000

    def add(self, time_s: float, late_s: float, goal: Floats, reading: Reading) -> None:
        """Record one cycle."""
        k = self.cycles
        self._time[k], self._late[k], self._fresh[k] = time_s, late_s, reading.fresh
        self._columns["goal"][k] = goal
        for name in ServoTelemetry.MEASURED:
            self._columns[name][k] = getattr(reading, name)
        self.cycles += 1

    def column(self, name: str) -> Floats:
        """(cycles so far, N) of one measured quantity, or "goal"."""
        return self._columns[name][: self.cycles]

    def message(self) -> ServoTelemetry:
        """The recording so far; it must hold a cycle."""
        used = slice(self.cycles)
        return ServoTelemetry(
            robot=self._rig.robot,
            joint_names=self._rig.joints,
            time_s=self._time[used] - self._time[0],
            late_s=self._late[used],
            fresh=self._fresh[used],
            **{name: values[used] for name, values in self._columns.items()},  # pyright: ignore[reportArgumentType]
        )
