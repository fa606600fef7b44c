"""The servo cycle's pace: absolute deadlines, taken up anew after a stall instead of hurrying to catch up.

A loop that catches up would send the missed goals in a burst, and a burst of goals is a jump of the joints.
"""

import time
from dataclasses import dataclass, field

import numpy as np

from ros_free_stack.rate import Rate, RateStatistics


@dataclass
class Pace:
    """`sleep()` once a cycle of `period_s`."""

    period_s: float
    _rate: Rate = field(init=False)
    _late: list[float] = field(default_factory=list[float])
    _start: float = field(default_factory=time.perf_counter)

    def __post_init__(self) -> None:
        self._rate = Rate(1 / self.period_s)

    def sleep(self) -> float:
        """Wait for the next deadline; return how late it was met, in s."""
        late = self._rate.sleep()
        self._late.append(late)
        if late > self.period_s:
            self._rate = Rate(1 / self.period_s)
        return late

    def statistics(self) -> RateStatistics:
        """Statistics over all cycles, stalls included."""
        late = np.array(self._late or [0.0]) * 1e3
        elapsed = time.perf_counter() - self._start
        return RateStatistics(
            cycles=len(self._late),
            rate_hz=len(self._late) / elapsed,
            jitter_p50_ms=float(np.percentile(late, 50)),
            jitter_p99_ms=float(np.percentile(late, 99)),
            jitter_max_ms=float(late.max()),
            missed=int((late > 1e3 * self.period_s).sum()),
        )
