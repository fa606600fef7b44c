"""A fixed-rate loop on absolute deadlines, with statistics of its jitter."""

import time
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class RateStatistics:
    """How well a loop kept its rate.

    Attributes:
        cycles: number of completed cycles.
        rate_hz: mean achieved rate.
        jitter_p50_ms, jitter_p99_ms, jitter_max_ms: lateness of the wake-ups against their deadlines.
        missed: cycles that began more than one period late.
    """

    cycles: int
    rate_hz: float
    jitter_p50_ms: float
    jitter_p99_ms: float
    jitter_max_ms: float
    missed: int


class Rate:
    """`sleep()` once a cycle. Deadlines are multiples of the period from the start, so that no drift builds up.

    A cycle that begins more than a period late begins a new count instead of hurrying to catch up: a loop that catches
    up would send the missed goals in a burst, and a burst of goals is a jump of the joints. The last 0.2 ms are spent
    spinning: the scheduler's wake-up is coarser than a servo cycle deserves.
    """

    _SPIN_S = 2e-4

    def __init__(self, hz: float) -> None:
        self.hz = hz
        self._lateness: list[float] = []
        self._elapsed = 0.0
        self.resume()

    @property
    def period_s(self) -> float:
        return 1.0 / self.hz

    def resume(self) -> None:
        """Count from now, after a pause that is none of the loop's."""
        self._start = self._last = time.perf_counter()
        self._cycle = 0

    def sleep(self) -> float:
        """Wait for the next deadline; return how late it was met, in seconds."""
        self._cycle += 1
        deadline = self._start + self._cycle * self.period_s
        remaining = deadline - time.perf_counter()
        if remaining > self._SPIN_S:
            time.sleep(remaining - self._SPIN_S)
        while (now := time.perf_counter()) < deadline:
            pass
        late = now - deadline
        self._lateness.append(late)
        self._elapsed, self._last = self._elapsed + now - self._last, now
        if late > self.period_s:
            self.resume()
        return late

    def statistics(self) -> RateStatistics:
        """Statistics over all cycles so far, stalls included."""
        late = np.array(self._lateness or [0.0]) * 1e3
        return RateStatistics(
            cycles=len(self._lateness),
            rate_hz=len(self._lateness) / self._elapsed if self._elapsed > 0 else 0.0,
            jitter_p50_ms=float(np.percentile(late, 50)),
            jitter_p99_ms=float(np.percentile(late, 99)),
            jitter_max_ms=float(late.max()),
            missed=int((late > 1e3 * self.period_s).sum()),
        )
