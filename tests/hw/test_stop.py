"""Letting go: only a servo that says so is taken to be limp."""

from collections.abc import Iterator

import pytest

from hw.servos import Servos, open_ports
from hw.stop import disarm, torque_off
from hw.virtual.bus import VirtualBus
from tests.hw.streams import RIG, make_bus, torques


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with make_bus() as bus:
        with bus.locked:
            for servo in bus.network.all_servos:
                servo.set("Torque Enable", 1)
        yield bus


def test_a_servo_whose_torque_stays_on_is_named(bus: VirtualBus, monkeypatch: pytest.MonkeyPatch) -> None:
    elbow = bus.servo(5)
    torque = elbow.table["Torque Enable"].address
    write = elbow.write

    def stuck(address: int, data: bytes, *, ram_only: bool = False) -> None:
        if address != torque:
            write(address, data, ram_only=ram_only)

    monkeypatch.setattr(elbow, "write", stuck)
    with open_ports(bus.port, RIG.baud) as buses:
        assert torque_off(Servos.find(RIG, buses)) == ("r_el (servo 5)",)
    assert torques(bus) == [False, True, False]


def test_a_torque_that_only_the_second_command_reaches_is_confirmed(bus: VirtualBus) -> None:
    with open_ports(bus.port, RIG.baud) as buses:
        servos = Servos.find(RIG, buses)
        bus.faults.drop_instruction = 0.3
        assert torque_off(servos) == ()
    assert torques(bus) == [False] * 3


def test_who_does_not_confirm_that_its_watchdog_is_off_is_named(bus: VirtualBus) -> None:
    with open_ports(bus.port, RIG.baud) as buses:
        servos = Servos.find(RIG, buses)
        with bus.locked:
            bus.servo(5).dead = True
        assert disarm(servos) == ("r_el (servo 5)",)
