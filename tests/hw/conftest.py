"""Tests of the servo package measure no time, and must pass on a computer that is busy with other things."""

from collections.abc import Iterator

import pytest
from dynamixel_sdk import port_handler

from hw.pace import realtime_priority

LATE = ("DeadlineFault", "LostServo", "BusFault", "readings were lost", "TimeoutExpired")
"""What a driver or a client says that came too late to its turn. Nothing else is tried again."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Bus and driver here run on the clock of the wall: what a busy computer was late for is repeated."""
    for item in items:
        if "tests/hw/" in item.path.as_posix():
            item.add_marker(pytest.mark.realtime)
            item.add_marker(pytest.mark.flaky(reruns=3, reruns_delay=1, only_rerun=list(LATE)))


@pytest.fixture(autouse=True)
def patient_sdk(monkeypatch: pytest.MonkeyPatch) -> None:
    """The SDK gives up on an answer after twice this many milliseconds of the wall clock."""
    monkeypatch.setattr(port_handler, "LATENCY_TIMER", 150)


@pytest.fixture(autouse=True)
def ahead_of_other_work() -> Iterator[None]:
    with realtime_priority():
        yield
