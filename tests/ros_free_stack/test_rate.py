"""The fixed-rate loop keeps absolute deadlines and counts what it misses."""

import pytest

from ros_free_stack import rate as rate_module
from ros_free_stack.rate import Rate


class Clock:
    """Time that passes only in `sleep`, and by a microsecond at each look."""

    def __init__(self) -> None:
        self.now = 100.0

    def perf_counter(self) -> float:
        self.now += 1e-6
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    clock = Clock()
    monkeypatch.setattr(rate_module, "time", clock)
    return clock


def test_deadlines_are_absolute_so_a_little_lateness_does_not_shift_the_rest(clock: Clock):
    rate = Rate(200.0)
    start = clock.now
    for _ in range(1000):
        clock.now += 0.003
        rate.sleep()
    clock.now += 0.006
    assert rate.sleep() == pytest.approx(0.001, abs=1e-4)
    rate.sleep()
    assert clock.now - start == pytest.approx(1002 / 200, abs=1e-4)
    statistics = rate.statistics()
    assert statistics.cycles == 1002
    assert statistics.missed == 0
    assert statistics.rate_hz == pytest.approx(200, rel=1e-3)
    assert statistics.jitter_max_ms >= statistics.jitter_p99_ms >= statistics.jitter_p50_ms >= 0


def test_a_stall_begins_a_new_count_instead_of_a_burst(clock: Clock):
    rate = Rate(200.0)
    clock.now += 0.052
    assert rate.sleep() == pytest.approx(0.047, abs=1e-4)
    before = clock.now
    rate.sleep()
    assert clock.now - before == pytest.approx(0.005, abs=1e-4)
    assert rate.statistics().missed == 1


def test_a_pause_between_runs_is_not_counted(clock: Clock):
    rate = Rate(200.0)
    rate.sleep()
    clock.now += 10
    rate.resume()
    rate.sleep()
    assert rate.statistics().missed == 0
    assert rate.statistics().rate_hz == pytest.approx(200, rel=1e-2)


def test_statistics_before_the_first_cycle():
    statistics = Rate(100.0).statistics()
    assert (statistics.cycles, statistics.rate_hz, statistics.missed) == (0, 0.0, 0)


def test_never_returns_before_the_deadline():
    rate = Rate(500.0)
    assert all(rate.sleep() >= 0 for _ in range(20))
    assert rate.period_s == pytest.approx(0.002)
