"""The servo cycle's pace: absolute deadlines, taken up anew after a stall instead of hurrying to catch up.

A loop that catches up would send the missed goals in a burst, and a burst of goals is a jump of the joints.
"""

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from ros_free_stack.rate import Rate, RateStatistics

_PRIORITY = 10


class Pace:
    """`resume()` before a run of cycles, `sleep()` once in each of `period_s`."""

    def __init__(self, period_s: float) -> None:
        self.period_s = period_s
        self._late: list[float] = []
        self._elapsed = 0.0
        self.resume()

    def resume(self) -> None:
        """Begin to count from now."""
        self._rate = Rate(1 / self.period_s)
        self._last = time.perf_counter()

    def sleep(self) -> float:
        """Wait for the next deadline; return how late it was met, in s."""
        late = self._rate.sleep()
        now = time.perf_counter()
        self._late.append(late)
        self._elapsed, self._last = self._elapsed + now - self._last, now
        if late > self.period_s:
            self.resume()
        return late

    def statistics(self) -> RateStatistics:
        """Statistics over all cycles, stalls included."""
        late = np.array(self._late or [0.0]) * 1e3
        return RateStatistics(
            cycles=len(self._late),
            rate_hz=len(self._late) / self._elapsed if self._elapsed else 0.0,
            jitter_p50_ms=float(np.percentile(late, 50)),
            jitter_p99_ms=float(np.percentile(late, 99)),
            jitter_max_ms=float(late.max()),
            missed=int((late > 1e3 * self.period_s).sum()),
        )


@contextmanager
def realtime_priority() -> Iterator[bool]:
    """Run this thread ahead of ordinary ones where the system lets us; yields whether it does."""
    try:
        before = os.sched_getscheduler(0), os.sched_getparam(0)
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    except (AttributeError, OSError):
        # Not Linux, or not permitted.
        yield False
        return
    try:
        yield True
    finally:
        os.sched_setscheduler(0, *before)
