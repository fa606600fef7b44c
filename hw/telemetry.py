"""What a stream commanded and measured, cycle by cycle, kept for the report."""

from pathlib import Path

import numpy as np

from hw.cycle import Reading
from hw.rig import Rig
from ros_free_stack.files import atomic_path
from ros_free_stack.messages import Floats, ServoState

_MEASURED = ("position", "velocity", "current", "voltage", "temperature")


class Telemetry:
    """A recording of up to `cycles` cycles."""

    def __init__(self, rig: Rig, cycles: int) -> None:
        self._rig = rig
        self._used = 0
        shape = (cycles, len(rig.joints))
        self._time = np.zeros(cycles)
        self._late = np.zeros(cycles)
        self._goal = np.zeros(shape)
        self._fresh = np.zeros(shape, dtype=bool)
        self._measured = {name: np.zeros(shape) for name in _MEASURED}

    def add(self, time_s: float, late_s: float, goal: Floats, reading: Reading) -> None:
        """Record one cycle."""
        k = self._used
        self._time[k], self._late[k], self._goal[k], self._fresh[k] = time_s, late_s, goal, reading.fresh
        for name, values in self._measured.items():
            values[k] = getattr(reading, name)
        self._used += 1

    def column(self, name: str) -> Floats:
        """(cycles so far, N) of one measured quantity, or "goal"."""
        return (self._goal if name == "goal" else self._measured[name])[: self._used]

    def save(self, path: Path) -> None:
        """Write an `.npz`: time_s (K,), late_s (K,), joint_names (N,); goal, fresh and what was measured (K, N)."""
        used = slice(self._used)
        with atomic_path(path) as temporary, temporary.open("wb") as stream:
            np.savez_compressed(
                stream,
                kind="servo_telemetry",
                version=1,
                robot=self._rig.robot,
                joint_names=np.array(self._rig.joints),
                time_s=self._time[used],
                late_s=self._late[used],
                goal=self._goal[used],
                fresh=self._fresh[used],
                **{name: values[used] for name, values in self._measured.items()},  # pyright: ignore[reportArgumentType]
            )


def servo_state(rig: Rig, reading: Reading, time_s: float) -> ServoState:
    """A reading as the shared message, keyed by joint name."""

    def named(values: Floats) -> dict[str, float]:
        return dict(zip(rig.joints, values.tolist(), strict=True))

    return ServoState(
        time_s=time_s,
        position=named(reading.position),
        velocity=named(reading.velocity),
        current=named(reading.current),
        temperature=named(reading.temperature),
        voltage=named(reading.voltage),
        error={joint: int(bits) for joint, bits in zip(rig.joints, reading.error, strict=True)},
    )
