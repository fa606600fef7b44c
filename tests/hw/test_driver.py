"""The driver on an emulated bus: what it does when all goes well, and for each fault that it stops, and how."""

import signal
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from hw.cycle import Reading
from hw.driver import Driver
from hw.line import BLOCK
from hw.protocol import Instruction, StatusError
from hw.servos import Servos, open_ports
from hw.stop import torque_off
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import INPUT_VOLTAGE, OVERLOAD, Refused
from ros_free_stack.errors import (
    BusFault,
    DeadlineFault,
    HardwareFault,
    LostServo,
    PortError,
    ServoFault,
)
from tests.hw.streams import RIG, WAVE, assert_no_goal_outside_limits, make_bus, play, torques, with_safety


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with make_bus() as bus:
        yield bus


def test_a_stream_that_goes_well(bus: VirtualBus) -> None:
    driver = play(bus)
    assert driver.cycle.method == "fast sync read"
    assert 0 < driver.watch.max_following_error < 0.2
    assert driver.rate.statistics().cycles >= len(WAVE)
    assert torques(bus) == [False] * 3
    assert [bus.servo(i).get("Bus Watchdog") for i in RIG.ids] == [0] * 3
    assert_no_goal_outside_limits(bus)


@pytest.mark.parametrize(
    ("unsupported", "method"),
    [
        ({Instruction.FAST_SYNC_READ}, "sync read"),
        ({Instruction.FAST_SYNC_READ, Instruction.SYNC_READ}, "single reads"),
    ],
)
def test_older_firmware_is_read_another_way(unsupported: set[Instruction], method: str) -> None:
    with make_bus(unsupported=unsupported) as bus:
        assert play(bus).cycle.method == method
        assert torques(bus) == [False] * 3


def test_lost_and_damaged_packets_are_borne(bus: VirtualBus) -> None:
    bus.faults.drop = bus.faults.corrupt = bus.faults.noise = bus.faults.drop_instruction = 0.04
    seen: list[Reading] = []
    with Driver(RIG, bus.port) as driver:
        driver.enable()
        driver.move_to(WAVE[0])
        driver.follow(WAVE, lambda time_s, late_s, goal, reading: seen.append(reading))
        bus.faults.drop = bus.faults.corrupt = bus.faults.noise = bus.faults.drop_instruction = 0.0
    assert driver.watch.lost_replies > 0
    positions = np.array([reading.position for reading in seen])
    # No damaged packet was taken for a pose: the joints move in small steps.
    assert np.abs(np.diff(positions, axis=0)).max() < 0.2
    assert torques(bus) == [False] * 3
    assert_no_goal_outside_limits(bus)


def reboot(bus: VirtualBus, identity: int) -> None:
    bus.servo(identity).reboot(0.0)


def heat(bus: VirtualBus, identity: int) -> None:
    bus.servo(identity).motor.temperature = 75.0


def jam(bus: VirtualBus, identity: int) -> None:
    bus.servo(identity).motor.jammed = True
    bus.servo(identity).motor.position += 1.2


def kill(bus: VirtualBus, identity: int) -> None:
    bus.servo(identity).dead = True


def sag(bus: VirtualBus, identity: int) -> None:
    bus.servo(identity).supply_voltage = 9.0


def block(bus: VirtualBus, identity: int) -> None:
    bus.servo(identity).motor.jammed = True


FAULTS: dict[str, tuple[Callable[[VirtualBus, int], None], type[HardwareFault], str]] = {
    "overload": (lambda bus, i: bus.servo(i).fail(OVERLOAD), ServoFault, "r_el .servo 5.: hardware error: overload"),
    "alert only": (lambda bus, i: bus.servo(i).fail(INPUT_VOLTAGE), ServoFault, "r_el .* input voltage"),
    "heat": (heat, ServoFault, "r_el .* 75 deg C, limit 70 deg C"),
    "brown-out": (sag, ServoFault, "r_el .* (input voltage|9.0 V)"),
    "jam": (jam, ServoFault, "r_el .* following error"),
    "reboot": (reboot, ServoFault, "r_el .* torque went off by itself"),
    "dead": (kill, LostServo, "no answer from r_el .servo 5."),
}


@pytest.mark.parametrize("cycle", [0, 60])
@pytest.mark.parametrize("name", FAULTS)
def test_faults_stop_the_stream(bus: VirtualBus, name: str, cycle: int) -> None:
    fault, error, words = FAULTS[name]
    with pytest.raises(error, match=words) as caught:
        play(bus, at=cycle, fault=lambda: fault(bus, 5))
    alive = [identity for identity in RIG.ids if not bus.servo(identity).dead]
    assert [bus.servo(identity).torque_on for identity in alive] == [False] * len(alive)
    assert ("torque off NOT confirmed for r_el" in str(caught.value)) == (name == "dead")
    for identity in alive:
        low, high = bus.servo(identity).goal_extremes or (0, 0)
        assert 0 <= low <= high <= 4095


def test_a_bus_that_carries_only_noise(bus: VirtualBus) -> None:
    def garble() -> None:
        bus.faults.corrupt = 1.0

    with pytest.raises((BusFault, LostServo)):
        play(bus, at=30, fault=garble, rig=with_safety(lost_after=5))
    # The torque is off although no servo could confirm it: the servos hear, only their answers are damaged.
    assert torques(bus) == [False] * 3


def test_a_port_that_goes_away() -> None:
    bus = make_bus()
    bus.start()
    try:
        with pytest.raises(PortError, match=r"went away|NOT confirmed"), Driver(RIG, bus.port) as driver:
            driver.enable()
            driver.follow(WAVE[:10])
            bus.stop()
            driver.follow(WAVE[10:])
    finally:
        bus.stop()


def test_a_blocked_joint_trips_on_its_current(bus: VirtualBus) -> None:
    rig = with_safety(current=0.3, current_s=0.1, following_error=3.0)
    with pytest.raises(ServoFault, match=r"r_el .* A for .* limit 0.3 A for 0.1 s: blocked"):
        play(bus, at=20, fault=lambda: block(bus, 5), rig=rig)
    assert torques(bus) == [False] * 3


def test_a_fault_can_end_in_a_hold(bus: VirtualBus) -> None:
    with pytest.raises(ServoFault, match="75 deg C"):
        play(bus, at=20, fault=lambda: heat(bus, 5), rig=with_safety(on_fault="hold"))
    assert torques(bus) == [True] * 3
    assert [bus.servo(i).get("Bus Watchdog") for i in RIG.ids] == [0] * 3
    # It holds where it stopped, not where it was going.
    with bus.locked:
        for identity in RIG.ids:
            assert abs(bus.servo(identity).get("Goal Position") - bus.servo(identity).get("Present Position")) < 60


def test_a_tripped_watchdog_is_recovered_on_purpose_only(bus: VirtualBus) -> None:
    def trip() -> None:
        bus.servo(5).set("Bus Watchdog", 0xFF)

    with pytest.raises(ServoFault, match="watchdog tripped after"):
        play(bus, at=30, fault=trip)
    assert torques(bus) == [False] * 3
    assert bus.servo(5).get("Bus Watchdog") == 0xFF
    with pytest.raises(ServoFault, match="servos release"):
        play(bus)
    with open_ports(bus.port, RIG.baud) as buses:
        assert torque_off(Servos.find(RIG, buses), recover=True) == ()
    play(bus)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGQUIT, signal.SIGHUP])
def test_a_signal_on_a_failing_bus_ends_with_torque_off(bus: VirtualBus, number: signal.Signals) -> None:
    def fail() -> None:
        bus.faults.corrupt = 1.0
        signal.raise_signal(number)

    before = signal.getsignal(number)
    with pytest.raises(KeyboardInterrupt):
        play(bus, at=30, fault=fail)
    # The servos hear, although none of their answers arrives whole.
    assert torques(bus) == [False] * 3
    assert signal.getsignal(number) == before


def test_an_exception_of_the_caller_ends_with_torque_off(bus: VirtualBus) -> None:
    def fail() -> None:
        raise RuntimeError("the caller broke")

    with pytest.raises(RuntimeError, match="the caller broke"):
        play(bus, at=30, fault=fail)
    assert torques(bus) == [False] * 3


def test_a_servo_that_refuses_to_be_read_is_named_with_its_error_code(monkeypatch: pytest.MonkeyPatch) -> None:
    with make_bus(unsupported={Instruction.FAST_SYNC_READ}) as bus:
        servo = bus.servo(5)
        read = servo.read

        def refuse(address: int, length: int) -> bytes:
            if length == BLOCK.itemsize:
                raise Refused(StatusError.ACCESS)
            return read(address, length)

        with pytest.raises(BusFault, match=r"r_el .servo 5. refuses to be read: access"):
            play(bus, at=30, fault=lambda: monkeypatch.setattr(servo, "read", refuse))
        assert torques(bus) == [False] * 3


def test_the_alert_bit_reaches_the_caller_by_every_way_of_reading() -> None:
    ways = [set[Instruction](), {Instruction.FAST_SYNC_READ}, {Instruction.FAST_SYNC_READ, Instruction.SYNC_READ}]
    for unsupported in ways:
        with (
            make_bus(unsupported=unsupported) as bus,
            pytest.raises(ServoFault, match="input voltage"),  # on the way out, where the last goal is held
            Driver(RIG, bus.port) as driver,
        ):
            driver.enable()
            with bus.locked:
                # Not in the shutdown mask: the servo goes on, only the alert bit and its cause tell.
                bus.servo(5).set("Shutdown", 0)
                bus.servo(5).fail(INPUT_VOLTAGE)
            reading = driver.cycle.exchange(None)
            assert reading.alert.tolist() == [False, True, False], driver.cycle.method
            assert reading.error.tolist() == [0, INPUT_VOLTAGE, 0]
            assert reading.torque.all()


def test_a_fault_while_the_last_goal_is_held_is_told(bus: VirtualBus) -> None:
    with pytest.raises(ServoFault, match=r"r_el .servo 5.: hardware error: overload"):
        play(bus, at=len(WAVE) - 1, fault=lambda: bus.servo(5).fail(OVERLOAD))
    assert torques(bus) == [False] * 3


def test_a_computer_that_pauses_stops_the_stream(bus: VirtualBus) -> None:
    with pytest.raises(DeadlineFault, match=r"paused for .* s, limit 0.2 s"):
        play(bus, at=20, fault=lambda: time.sleep(0.5), rig=with_safety(stall_s=0.2))
    assert torques(bus) == [False] * 3


def test_the_servos_watchdogs_are_armed_while_the_stream_runs(bus: VirtualBus) -> None:
    armed: list[int] = []
    play(bus, at=20, fault=lambda: armed.extend(bus.servo(i).get("Bus Watchdog") for i in RIG.ids))
    assert armed == [round(RIG.safety.watchdog_s / 0.02)] * 3
