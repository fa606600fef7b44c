"""What the driver checks and sets before anything moves."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from hw.driver import Driver
from hw.protocol import Instruction
from hw.units import to_si
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import OVERLOAD, Servo
from ros_free_stack.errors import (
    BusFault,
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
        (lambda servo: servo.set("Status Return Level", 0), UnsafeCommand, "r_el .*pings only.*configure --write"),
        (lambda servo: servo.set("Status Return Level", 1), UnsafeCommand, "return level 1 .*configure --write"),
        (lambda servo: servo.set("Secondary(Shadow) ID", 19), UnsafeCommand, "secondary id 19 .*configure --write"),
        (lambda servo: servo.set("Torque Enable", 1), UnsafeCommand, "r_el .* already holds torque"),
        (lambda servo: setattr(servo.motor, "temperature", 75.0), ServoFault, "r_el .*75 deg C, limit 70"),
        (lambda servo: servo.set("Min Voltage Limit", 130), ServoFault, "r_el .*12.0 V, minimum 13.0 V"),
    ],
)
def test_what_is_checked_before_anything_moves(
    bus: VirtualBus, change: Callable[[Servo], None], error: type[HardwareFault], words: str
) -> None:
    """A dry run opens the same driver, and enables nothing."""
    with bus.locked:
        change(bus.servo(5))
        bus.servo(5).advance(0.01)
    held = torques(bus)
    with pytest.raises(error, match=words), Driver(RIG, bus.port):
        pass
    assert torques(bus) == held
    assert bus.servo(5).goal_extremes is None


def test_two_servos_with_one_id_are_named(bus: VirtualBus) -> None:
    with bus.locked:
        bus.network.add(Servo.make(5, baud=RIG.baud, position=1.0))
    with pytest.raises(BusFault, match=r"r_el .servo 5.: .*two servos with this id"), Driver(RIG, bus.port):
        pass


@pytest.mark.parametrize(("fast", "refused"), [(True, False), (False, True)])
def test_return_delays_that_do_not_fit_into_the_cycle_are_named_with_their_cure(fast: bool, refused: bool) -> None:
    """As they leave the factory: 0.5 ms each. One answer of all waits once."""
    rig = replace(RIG, cycle_s=0.002)
    with make_bus(unsupported=() if fast else {Instruction.FAST_SYNC_READ}) as bus:
        with bus.locked:
            for identity in RIG.ids:
                bus.servo(identity).set("Return Delay Time", 250)
        if refused:
            words = (
                r"by sync read takes .* ms, the cycle has 2 ms; head_pan .* return delay 500 us: .*configure --write"
            )
            with pytest.raises(UnsafeCommand, match=words), Driver(rig, bus.port):
                pass
        else:
            with Driver(rig, bus.port) as driver:
                assert driver.cycle.method == "fast sync read"


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


def standing(joint: int, angle: float) -> VirtualBus:
    angles = STAND.copy()
    angles[joint] = angle
    return VirtualBus([Servo.make(i, baud=RIG.baud, position=at) for i, at in zip(RIG.ids, angles, strict=True)])


@pytest.mark.parametrize("sign", [1, -1])
def test_a_joint_that_stands_far_outside_its_range_is_not_enabled(sign: int) -> None:
    end = RIG.upper[1] if sign > 0 else RIG.lower[1]
    with standing(1, end + sign * 0.3) as bus:
        with pytest.raises(UnsafeCommand, match=r"r_el .* outside its range"), Driver(RIG, bus.port):
            pass
        assert torques(bus) == [False] * 3


@pytest.mark.parametrize("configured", [False, True])
@pytest.mark.parametrize("sign", [1, -1])
def test_a_joint_a_little_outside_its_range_comes_back_at_the_speed_of_the_ramp(sign: int, configured: bool) -> None:
    """Also where its own position limits, set to the range, take no goal out there."""
    end = RIG.upper[1] if sign > 0 else RIG.lower[1]
    with standing(1, end + sign * 0.09) as bus:
        servo = bus.servo(5)
        with bus.locked:
            if configured:
                for name, at in zip(("Min", "Max"), RIG.to_raw(np.stack([RIG.lower, RIG.upper]))[:, 1], strict=True):
                    servo.set(f"{name} Position Limit", int(at))
        speeds: list[float] = []
        publish = servo.sense

        def sense(dt: float) -> None:
            speeds.append(abs(servo.motor.velocity))
            publish(dt)

        servo.sense = sense  # type: ignore[method-assign]
        with Driver(RIG, bus.port) as driver:
            assert driver.enable().position[1] == pytest.approx(end + sign * 0.09, abs=0.01)
            assert abs(servo.motor.position) <= abs(end) + 0.02
            assert servo.get("Profile Velocity") == 0, "the profile is the robot's again"
            driver.move_to(STAND)
        assert max(speeds) < 1.4 * RIG.safety.ramp_speed
        assert servo.refusals == []
        assert torques(bus) == [False] * 3
