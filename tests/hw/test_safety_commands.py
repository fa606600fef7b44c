"""`servos release`, `reboot`, `info` and `power`: what they can do they do, and they name the rest."""

import json
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import pytest
import tyro

from hw.commands.look import ServosInfo, ServosScan
from hw.commands.safety import ServosPower, ServosReboot, ServosRelease
from hw.commands.setup import ServosConfigure
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import OVERLOAD, Servo
from ros_free_stack.errors import HardwareFault, InvalidOption, LostServo, PortError, ServoFault
from ros_free_stack.robots import load_robot

OP3 = load_robot("op3")
assert OP3.servos is not None
BENCH = replace(OP3, servos=replace(OP3.servos, board=None))
Capture = pytest.CaptureFixture[str]


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with VirtualBus.of_robot(OP3) as bus:
        stiffen(bus)
        yield bus


@pytest.fixture
def bench() -> Iterator[VirtualBus]:
    """Powered from a bench supply, without a board."""
    with VirtualBus.of_robot(BENCH) as bus:
        stiffen(bus)
        yield bus


def stiffen(bus: VirtualBus) -> None:
    with bus.locked:
        for servo in bus.network.all_servos:
            servo.set("Torque Enable", 1)


def stiff(bus: VirtualBus) -> list[int]:
    return [servo.id for servo in bus.network.all_servos if servo.torque_on]


def given(command: type, *arguments: str) -> Any:
    return tyro.cli(command, args=list(arguments))


def test_release_lets_go_and_recovers_watchdogs(bus: VirtualBus) -> None:
    with bus.locked:
        bus.servo(5).set("Bus Watchdog", 0xFF)
    assert given(ServosRelease, "--servo", bus.port).run() == 0
    assert stiff(bus) == []
    assert bus.servo(5).get("Bus Watchdog") == 0
    assert bus.network.board is not None and bus.network.board.powered, "all confirmed it: the power stays"


def wrong_model(bus: VirtualBus) -> None:
    bus.servo(5).set("Model Number", 1060)


def dead(bus: VirtualBus) -> None:
    bus.servo(5).dead = True


def mute(bus: VirtualBus) -> None:
    bus.servo(5).set("Status Return Level", 0)


def twin(bus: VirtualBus) -> None:
    bus.network.add(Servo.make(5, baud=2_000_000, position=1.0))


def stranger(bus: VirtualBus) -> None:
    other = Servo.make(77, model="XL430-W250", baud=2_000_000)
    other.set("Torque Enable", 1)
    bus.network.add(other)


@pytest.mark.parametrize(
    ("trouble", "named", "left"),
    [(dead, "r_el", [5]), (mute, "r_el", []), (wrong_model, "", []), (twin, "", []), (stranger, "", [])],
)
def test_release_frees_every_servo_that_answers(bench: VirtualBus, trouble: Any, named: str, left: list[int]) -> None:
    with bench.locked:
        trouble(bench)
    command = given(ServosRelease, "--servo", bench.port)
    if named:
        with pytest.raises(HardwareFault, match=rf"on {bench.port}, NOT confirmed for {named} .*: cut the power"):
            command.run()
    else:
        assert command.run() == 0
    assert stiff(bench) == left


def test_release_takes_the_power_where_a_servo_is_silent(bus: VirtualBus, capsys: Capture) -> None:
    with bus.locked:
        bus.servo(5).dead = True
    assert given(ServosRelease, "--servo", bus.port).run() == 0
    assert stiff(bus) == []
    assert "NOT confirmed for r_el (servo 5): OpenCR (id 200" in capsys.readouterr().err


def test_release_of_some_joints_leaves_the_others_their_power(bus: VirtualBus) -> None:
    with bus.locked:
        bus.servo(5).dead = True
    with pytest.raises(HardwareFault, match="NOT confirmed for r_el"):
        given(ServosRelease, "--servo", bus.port, "--joints", "r_el", "l_el").run()
    assert set(stiff(bus)) == set(range(1, 21)) - {6}


def test_release_of_two_ports_frees_the_one_that_is_there(bench: VirtualBus) -> None:
    with pytest.raises(HardwareFault, match="port /dev/nothing"):
        given(ServosRelease, "--servo", f"/dev/nothing,{bench.port}").run()
    assert stiff(bench) == []
    with pytest.raises(PortError, match="/dev/nothing"):
        given(ServosRelease, "--servo", "/dev/nothing").run()


@pytest.mark.parametrize("command", [ServosRelease, ServosInfo, ServosReboot, ServosPower])
def test_a_port_must_be_named(command: type, capsys: Capture) -> None:
    with pytest.raises(SystemExit) as caught:
        given(command)
    assert caught.value.code == 2
    assert "--servo" in capsys.readouterr().err


def test_info_and_reboot_do_the_others_and_name_the_dead(bench: VirtualBus, capsys: Capture) -> None:
    with bench.locked:
        bench.servo(5).dead = True
        bench.servo(6).fail(OVERLOAD)
    assert given(ServosInfo, "--servo", bench.port, "--json").run() == HardwareFault.exit_code
    shown = {row["joint"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
    assert len(shown) == 20 and shown["l_el"]["error"] == "overload"
    assert "no answer to a ping at 2000000 baud" in shown["r_el (servo 5)"]["error"]
    with pytest.raises(HardwareFault, match=r"restarted 19 servos on .*, not: r_el .servo 5. .no answer"):
        given(ServosReboot, "--servo", bench.port).run()
    assert not bench.servo(6).alert


def test_power_on_and_off_are_confirmed(capsys: Capture) -> None:
    with VirtualBus.of_robot(OP3, powered=False) as bus:
        assert given(ServosPower, "--servo", bus.port, "--json").run() == 0
        assert json.loads(capsys.readouterr().out) == {"power": "off", "voltage_v": 12.0, "pressed": []}
        with pytest.raises(ServoFault, match="power is off: `servos power on`"):
            given(ServosConfigure, "--servo", bus.port).run()
        assert given(ServosPower, "on", "--servo", bus.port).run() == 0
        assert "power on, 12.0 V" in capsys.readouterr().out
        stiffen(bus)
        assert given(ServosPower, "off", "--servo", bus.port).run() == 0
        assert stiff(bus) == []


def test_power_without_a_board(bench: VirtualBus) -> None:
    with pytest.raises(LostServo, match=r"no answer from OpenCR .id 200."):
        given(ServosPower, "off", "--servo", bench.port).run()
    with pytest.raises(InvalidOption, match="g1 has no Dynamixel servos"):
        given(ServosPower, "off", "--servo", bench.port, "--robot", "g1").run()


def test_a_scan_shows_the_board_twins_and_mute_servos(bus: VirtualBus, capsys: Capture) -> None:
    with bus.locked:
        bus.network.add(Servo.make(5, baud=2_000_000, position=1.0))
        bus.servo(6).set("Status Return Level", 0)
    assert given(ServosScan, "--servo", bus.port, "--json").run() == 0
    found = {row["id"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
    assert (found[200]["model"], found[200]["joint"], found[200]["problem"]) == ("OpenCR", "OpenCR", "")
    assert "two servos with this id" in found[5]["problem"]
    assert "status return level 0" in found[6]["problem"]
    assert found[7]["problem"] == ""


@pytest.mark.parametrize("level", [0, 1])
def test_configure_repairs_what_hides_a_servo(bench: VirtualBus, capsys: Capture, level: int) -> None:
    with bench.locked:
        for servo in bench.network.all_servos:
            servo.set("Torque Enable", 0)
        bench.servo(5).set("Status Return Level", level)
        bench.servo(5).set("Secondary(Shadow) ID", 19)
    arguments = ("--servo", bench.port, "--joints", "r_el", "--json")
    assert given(ServosConfigure, *arguments, "--write").run() == 0
    shown = {change["register"] for change in json.loads(capsys.readouterr().out)["changes"]}
    assert "Status Return Level" in shown
    assert bench.servo(5).get("Status Return Level") == 2
    assert given(ServosConfigure, *arguments, "--write").run() == 0
    assert bench.servo(5).get("Secondary(Shadow) ID") == 255
