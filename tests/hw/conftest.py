"""Tests of the servo room measure no time, and must pass on a computer that is busy with other things."""

from collections.abc import Iterator

import pytest
from dynamixel_sdk import port_handler

from hw.pace import realtime_priority


@pytest.fixture(autouse=True)
def patient_sdk(monkeypatch: pytest.MonkeyPatch) -> None:
    """The SDK gives up on an answer after twice this many milliseconds of the wall clock."""
    monkeypatch.setattr(port_handler, "LATENCY_TIMER", 150)


@pytest.fixture(autouse=True)
def ahead_of_other_work() -> Iterator[None]:
    with realtime_priority():
        yield
