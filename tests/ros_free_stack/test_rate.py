"""The fixed-rate loop keeps absolute deadlines and counts what it misses."""

import time

import pytest

from ros_free_stack.rate import Rate


def test_deadlines_are_absolute_so_a_late_cycle_does_not_shift_the_rest():
    rate = Rate(200.0)
    start = time.perf_counter()
    rate.sleep()
    time.sleep(0.012)  # more than two periods late
    late = rate.sleep()
    assert late > 0.005
    for _ in range(8):
        rate.sleep()
    assert time.perf_counter() - start >= 10 / 200
    statistics = rate.statistics()
    assert statistics.cycles == 10
    assert statistics.missed >= 1
    assert statistics.jitter_max_ms >= statistics.jitter_p99_ms >= statistics.jitter_p50_ms >= 0


def test_statistics_before_the_first_cycle():
    statistics = Rate(100.0).statistics()
    assert (statistics.cycles, statistics.rate_hz, statistics.missed) == (0, 0.0, 0)


def test_never_returns_before_the_deadline():
    rate = Rate(500.0)
    assert all(rate.sleep() >= 0 for _ in range(20))
    assert rate.period_s == pytest.approx(0.002)
