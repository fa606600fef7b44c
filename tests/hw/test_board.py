"""The board that powers the servos, as the driver uses it."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from hw.board import Board, BoardState, judge
from hw.bus import Bus
from hw.cycle import Reading
from hw.driver import Driver
from hw.rig import Rig
from hw.stream import stream
from hw.virtual.board import Board as VirtualBoard
from hw.virtual.bus import VirtualBus
from ros_free_stack.errors import BusFault, LostServo, ServoFault, StackError
from ros_free_stack.robots import load_robot
from tests.hw.streams import RIG, WAVE, make_bus, torques
from tests.hw.verdicts import judged, motion

OP3 = load_robot("op3")
assert OP3.servos is not None and OP3.servos.board is not None
SETTINGS = OP3.servos.board
Capture = pytest.CaptureFixture[str]


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with make_bus(board=VirtualBoard(SETTINGS, RIG.baud)) as bus:
        yield bus


def virtual(bus: VirtualBus) -> VirtualBoard:
    assert bus.network.board is not None
    return bus.network.board


def play(bus: VirtualBus, fault: Callable[[], None] = lambda: None, rig: Rig = RIG) -> None:
    count = 0

    def record(time_s: float, late_s: float, goal: np.ndarray, reading: Reading) -> None:
        nonlocal count
        count += 1
        if count == 20:
            with bus.locked:
                fault()

    with Driver(rig, bus.port) as driver:
        driver.enable()
        driver.move_to(WAVE[0])
        driver.follow(WAVE, record)


def test_the_driver_gives_the_servos_power_before_it_looks_for_them(bus: VirtualBus, capsys: Capture) -> None:
    assert not virtual(bus).powered
    play(bus)
    assert "OpenCR (id 200 on " in (told := capsys.readouterr().err) and "switched the servos' power on" in told
    assert torques(bus) == [False] * 3
    assert virtual(bus).powered
    play(bus)
    assert "switched" not in capsys.readouterr().err, "it was on already"


def test_a_dry_run_switches_nothing() -> None:
    trajectory = motion(OP3, seconds=0.2)
    with VirtualBus.of_robot(OP3, powered=False) as bus:
        with pytest.raises(ServoFault, match="power is off: `servos power on` gives it"):
            stream(trajectory, judged(trajectory), OP3, port=bus.port, dry_run=True)
        assert not virtual(bus).powered
    assert stream(trajectory, judged(trajectory), OP3, port="sim", dry_run=True).dry_run


@pytest.mark.parametrize("button", SETTINGS.button_names)
def test_a_button_stops_the_robot(bus: VirtualBus, button: str) -> None:
    with pytest.raises(ServoFault, match=rf"OpenCR .*: button {button} is pressed, which stops the robot"):
        play(bus, lambda: virtual(bus).press(button))
    assert torques(bus) == [False] * 3
    with pytest.raises(ServoFault, match=f"button {button} is pressed"), Driver(RIG, bus.port):
        pass


def test_power_that_goes_off_is_named(bus: VirtualBus) -> None:
    def cut() -> None:
        virtual(bus).write(SETTINGS.power, b"\0", bus.network.all_servos)

    with pytest.raises(ServoFault, match=r"OpenCR .*: the servos' power (went|is) off"):
        play(bus, cut)
    assert torques(bus) == [False] * 3


def test_the_emergency_stop_takes_the_power_where_a_servo_does_not_confirm(bus: VirtualBus) -> None:
    def die() -> None:
        bus.servo(5).dead = True

    words = r"torque off NOT confirmed for r_el .servo 5.: OpenCR .* took the servos' power"
    with pytest.raises(StackError, match=words):
        play(bus, die)
    assert not virtual(bus).powered
    assert not any(servo.torque_on for servo in bus.network.all_servos), "the dead one too"


def test_a_stop_that_holds_takes_no_power(bus: VirtualBus) -> None:
    def heat() -> None:
        bus.servo(5).motor.temperature = 75.0

    with pytest.raises(ServoFault, match="75 deg C"):
        play(bus, heat, replace(RIG, safety=replace(RIG.safety, on_fault="hold")))
    assert virtual(bus).powered and torques(bus) == [True] * 3


def test_a_low_battery_is_told(bus: VirtualBus, capsys: Capture) -> None:
    with bus.locked:
        virtual(bus).voltage = 10.4
        virtual(bus).advance(0.0, ())
    with Driver(RIG, bus.port) as driver:
        assert driver.board is not None and driver.board.lowest_v == pytest.approx(10.4)
    assert "10.4 V, low below 11 V: charge it" in capsys.readouterr().err


def test_a_board_that_falls_silent_stops_the_robot(bus: VirtualBus) -> None:
    def die() -> None:
        virtual(bus).dead = True

    with pytest.raises(LostServo, match="no answer from OpenCR"):
        play(bus, die, replace(RIG, safety=replace(RIG.safety, lost_after=5)))
    assert torques(bus) == [False] * 3


def test_servos_with_power_from_elsewhere_are_driven_with_a_note(capsys: Capture) -> None:
    with make_bus() as bus:
        play(bus)
    assert "note: no OpenCR answers" in capsys.readouterr().err


def test_a_switch_that_does_not_move_is_no_success(bus: VirtualBus, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(virtual(bus), "write", lambda *arguments: None)
    with Bus(bus.port, RIG.baud) as port:
        board = Board.find(SETTINGS, (port,))
        assert board is not None
        with pytest.raises(BusFault, match="power is still off"):
            board.switch(on=True)
        virtual(bus).memory[SETTINGS.power] = 1
        assert not board.cut()


def test_only_buttons_and_power_stop(bus: VirtualBus) -> None:
    with Bus(bus.port, RIG.baud) as port:
        judge(Board(SETTINGS, port), BoardState(power=True, pressed=(), voltage=3.0))
