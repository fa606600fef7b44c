"""One port: alerts, refusals, and servos that the SDK does not know."""

from collections.abc import Iterator

import pytest

from hw.bus import Bus
from hw.registers import control_table
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import OVERLOAD, Servo
from ros_free_stack.errors import BusFault, InvalidOption, LostServo

TABLE = control_table("XM430-W350")


@pytest.fixture
def virtual() -> Iterator[VirtualBus]:
    with VirtualBus([Servo.make(identity, baud=2_000_000) for identity in (1, 2)]) as bus:
        yield bus


def test_alerts_are_kept_until_they_are_gone(virtual: VirtualBus) -> None:
    with Bus(virtual.port, 2_000_000) as bus:
        with virtual.locked:
            virtual.servo(2).fail(OVERLOAD)
        bus.read(1, TABLE, "Present Position")
        bus.read(2, TABLE, "Present Position")
        assert bus.alerts == {2}
        with virtual.locked:
            virtual.servo(2).set("Hardware Error Status", 0)
        bus.read(2, TABLE, "Present Position")
        assert bus.alerts == set()


def test_refusals_have_names(virtual: VirtualBus) -> None:
    with Bus(virtual.port, 2_000_000) as bus:
        with pytest.raises(BusFault, match=r"servo 1 refuses writing Operating Mode = 9: data range"):
            bus.write(1, TABLE, "Operating Mode", 9)
        with pytest.raises(BusFault, match=r"servo 1 refuses writing Present Position = 0: access"):
            bus.write(1, TABLE, "Present Position", 0)
        with pytest.raises(LostServo, match="servo 9"):
            bus.read(9, TABLE, "Present Position")


def test_a_scan_shows_models_that_the_sdk_does_not_know(virtual: VirtualBus) -> None:
    with virtual.locked:
        virtual.servo(2).set("Model Number", 4711)
    with Bus(virtual.port, 2_000_000) as bus:
        assert [(device.id, device.model) for device in bus.scan()] == [(1, "XM430-W350"), (2, "unknown model 4711")]


def test_an_odd_baud_rate_is_refused(virtual: VirtualBus) -> None:
    with pytest.raises(InvalidOption, match=r"123 is not a rate of Dynamixel servos: 9600, .*4500000"):
        Bus(virtual.port, 123)


def test_an_instruction_that_was_damaged_on_its_way_is_sent_again(virtual: VirtualBus) -> None:
    with Bus(virtual.port, 2_000_000) as bus:
        virtual.faults.corrupt_instruction = 0.1
        for value in range(40):
            bus.write(1, TABLE, "Goal Current", value)
            assert bus.read(1, TABLE, "Goal Current") == value
        virtual.faults.corrupt_instruction = 1.0
        with pytest.raises(LostServo, match="servo 1"):
            bus.read(1, TABLE, "Goal Current")
