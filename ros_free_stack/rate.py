"""A fixed-rate loop on absolute deadlines, with statistics of its jitter."""

import time
from dataclasses import dataclass, field

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


@dataclass
class Rate:
    """`sleep()` once a cycle. Deadlines are multiples of the period from the start, so that no drift builds up.

    The last 0.2 ms are spent spinning: the scheduler's wake-up is coarser than a servo cycle deserves.
    """

    hz: float
    _start: float = field(default_factory=time.perf_counter)
    _lateness: list[float] = field(default_factory=list[float])
    _SPIN_S = 2e-4

    @property
    def period_s(self) -> float:
        return 1.0 / self.hz

    def sleep(self) -> float:
        """Wait for the next deadline; return how late it was met, in seconds."""
        deadline = self._start + (len(self._lateness) + 1) * self.period_s
        remaining = deadline - time.perf_counter()
        if remaining > self._SPIN_S:
            time.sleep(remaining - self._SPIN_S)
        while (now := time.perf_counter()) < deadline:
            pass
        self._lateness.append(now - deadline)
        return now - deadline

    def statistics(self) -> RateStatistics:
        """Statistics over all cycles so far."""
        late = np.array(self._lateness or [0.0]) * 1e3
        elapsed = len(self._lateness) * self.period_s + (self._lateness[-1] if self._lateness else 0.0)
        return RateStatistics(
            cycles=len(self._lateness),
            rate_hz=len(self._lateness) / elapsed if elapsed > 0 else 0.0,
            jitter_p50_ms=float(np.percentile(late, 50)),
            jitter_p99_ms=float(np.percentile(late, 99)),
            jitter_max_ms=float(late.max()),
            missed=int((late > 1e3 * self.period_s).sum()),
        )
