"""What the driver checks and sets before anything moves."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from hw.driver import Driver
from hw.units import to_si
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import OVERLOAD, Servo
from ros_free_stack.errors import (
    HardwareFault,
    LostServo,
    ModelMismatch,
    PortError,
    ServoFault,
    UnsafeCommand,
)
from ros_free_stack.robots import ServoSettings
from tests.hw.streams import RIG, STAND, WAVE, make_bus, torques


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with make_bus() as bus:
        yield bus


def test_hold_at_the_end(bus: VirtualBus) -> None:
    with Driver(RIG, bus.port, at_end="hold") as driver:
        driver.enable()
        driver.move_to(WAVE[40])
    assert torques(bus) == [True] * 3
    assert [bus.servo(i).get("Bus Watchdog") for i in RIG.ids] == [0] * 3
    # A second stream takes over without letting go, since the state is mapped already.
    with Driver(RIG, bus.port) as driver:
        reading = driver.enable()
        assert np.allclose(reading.position, WAVE[40], atol=0.02)
    assert torques(bus) == [False] * 3


def test_torque_held_by_someone_else_is_not_dropped(bus: VirtualBus) -> None:
    bus.servo(5).set("Torque Enable", 1)
    with pytest.raises(UnsafeCommand, match=r"r_el .* holds torque"), Driver(RIG, bus.port) as driver:
        driver.enable()
    assert bus.servo(5).torque_on


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        (lambda servo: setattr(servo, "dead", True), LostServo, "r_el .servo 5."),
        (lambda servo: servo.set("Model Number", 1030), ModelMismatch, "XM430-W210.*XM430-W350"),
        (lambda servo: servo.fail(OVERLOAD), ServoFault, "overload.*reboot"),
        (
            lambda servo: servo.set("Operating Mode", 1),
            UnsafeCommand,
            "Operating Mode 1, op3 needs 3 .position.*configure",
        ),
        (lambda servo: servo.set("Drive Mode", 1), UnsafeCommand, "Drive Mode 1, op3 needs 0"),
        (lambda servo: servo.set("Homing Offset", 100), UnsafeCommand, "Homing Offset 100, op3 needs 0"),
        (lambda servo: servo.set("Bus Watchdog", 255), ServoFault, "watchdog tripped.*servos release.*recover"),
    ],
)
def test_what_is_checked_before_anything_moves(
    bus: VirtualBus, change: Callable[[Servo], None], error: type[HardwareFault], words: str
) -> None:
    with bus.locked:
        change(bus.servo(5))
    with pytest.raises(error, match=words), Driver(RIG, bus.port):
        pass
    assert torques(bus) == [False] * 3
    assert bus.servo(5).goal_extremes is None


def test_goals_outside_are_refused_before_the_first_is_sent(bus: VirtualBus) -> None:
    wild = WAVE.copy()
    wild[100, 2] = 3.0
    with Driver(RIG, bus.port) as driver:
        driver.enable()
        sent = [bus.servo(i).goal_extremes for i in RIG.ids]
        with pytest.raises(UnsafeCommand, match=r"l_knee .* 3.000 rad is outside"):
            driver.follow(wild)
        assert [bus.servo(i).goal_extremes for i in RIG.ids] == sent
        with bus.locked:
            bus.servo(5).set("Max Position Limit", 1700)
        with pytest.raises(UnsafeCommand, match=r"r_el .* own position limits"):
            driver.check_goals(np.array([[0.0, 0.2, 0.7]]))


def test_a_missing_port_lists_the_ports() -> None:
    with pytest.raises(PortError, match=r"/dev/nothing: cannot be opened .*serial ports here"):
        Driver(RIG, "/dev/nothing").__enter__()


def test_goals_too_far_apart_are_refused_before_the_first_is_sent(bus: VirtualBus) -> None:
    jump = WAVE.copy()
    jump[60:, 1] -= 0.2
    with Driver(RIG, bus.port) as driver:
        driver.enable()
        driver.move_to(WAVE[0])
        sent = [bus.servo(i).goal_extremes for i in RIG.ids]
        with pytest.raises(UnsafeCommand, match=rf"goal 60 of r_el .* rad/s, limit {RIG.velocity[1]:.2f} rad/s"):
            driver.follow(jump)
        assert [bus.servo(i).goal_extremes for i in RIG.ids] == sent


def test_gains_and_profile_come_from_the_description(bus: VirtualBus) -> None:
    rig = replace(RIG, settings=ServoSettings(p_gain=640, d_gain=40, profile_acceleration=40.0))
    with Driver(rig, bus.port) as driver:
        driver.enable()
        servo = bus.servo(5)
        assert [servo.get(f"Position {name} Gain") for name in "PID"] == [640, 0, 40]
        assert to_si(servo.table, "Profile Acceleration", servo.get("Profile Acceleration")) == pytest.approx(40, abs=1)


def test_current_based_position_limits_the_goal_current(bus: VirtualBus) -> None:
    rig = replace(RIG, settings=ServoSettings(mode="current-based position", current_limit=1.0))
    with pytest.raises(UnsafeCommand, match="Operating Mode 3, op3 needs 5"), Driver(rig, bus.port):
        pass
    with bus.locked:
        for identity in RIG.ids:
            bus.servo(identity).set("Operating Mode", 5)
    with Driver(rig, bus.port) as driver:
        driver.enable()
        assert to_si(bus.servo(5).table, "Goal Current", bus.servo(5).get("Goal Current")) == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("beyond", "enables"), [(0.05, True), (0.3, False)])
def test_a_joint_that_stands_far_outside_its_range_is_not_enabled(sign: int, beyond: float, enables: bool) -> None:
    """A little outside is borne: the ramp brings it back."""
    end = RIG.upper[1] if sign > 0 else RIG.lower[1]
    angles = STAND.copy()
    angles[1] = end + sign * beyond
    servos = [Servo.make(i, baud=RIG.baud, position=angle) for i, angle in zip(RIG.ids, angles, strict=True)]
    with VirtualBus(servos) as bus, Driver(RIG, bus.port) as driver:
        if enables:
            assert driver.enable().position[1] == pytest.approx(angles[1], abs=0.01)
            driver.move_to(STAND)
        else:
            with pytest.raises(UnsafeCommand, match=r"r_el .* outside its range"):
                driver.enable()
    assert torques(bus) == [False] * 3
