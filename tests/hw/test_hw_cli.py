"""The `servos` and `stream` commands as a user gives them, on an emulated bus."""

import io
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import tyro

from hw.commands.look import ServosInfo, ServosRead, ServosScan
from hw.commands.safety import ServosReboot
from hw.commands.setup import ServosCalibrate, ServosConfigure
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import OVERLOAD
from ros_free_stack.errors import HardwareFault, InvalidOption, LostServo, UnknownName
from ros_free_stack.robots import load_robot

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def bus() -> Iterator[VirtualBus]:
    with VirtualBus.of_robot(load_robot("op3")) as bus:
        yield bus


def given(command: type, *arguments: str) -> Any:
    return tyro.cli(command, args=list(arguments))


def rows(bus: VirtualBus, capsys: Capture, command: type, *arguments: str) -> list[dict[str, Any]]:
    assert given(command, *arguments, "--servo", bus.port, "--json").run() == 0
    return json.loads(capsys.readouterr().out)["rows"]


def test_scan_names_the_joints(bus: VirtualBus, capsys: Capture) -> None:
    found = rows(bus, capsys, ServosScan)
    assert len(found) == 21, "20 servos and their board"
    assert found[4] | {"firmware": 0} == {
        "id": 5, "model": "XM430-W350", "firmware": 0, "baud": 2_000_000, "port": bus.port, "joint": "r_el",
        "problem": "",
    }  # fmt: skip


def test_scan_of_a_silent_port_ends_with_a_hardware_fault(capsys: Capture) -> None:
    with VirtualBus([]) as bus:
        assert given(ServosScan, "--servo", bus.port).run() == HardwareFault.exit_code


def test_info_shows_errors_and_says_who_is_alarmed(bus: VirtualBus, capsys: Capture) -> None:
    with bus.locked:
        bus.servo(5).fail(OVERLOAD)
        bus.servo(6).set("Bus Watchdog", 0xFF)
    assert given(ServosInfo, "--servo", bus.port, "--json").run() == 0
    shown = capsys.readouterr()
    found = {row["joint"]: row for row in json.loads(shown.out)["rows"]}
    assert found["r_el"]["error"] == "overload"
    assert found["l_el"]["error"] == "watchdog tripped"
    assert found["head_pan"]["error"] == ""
    assert f"warning: servo 5 on {bus.port} raises its alert" in shown.err


def test_info_as_a_table(bus: VirtualBus, capsys: Capture) -> None:
    assert given(ServosInfo, "--servo", bus.port, "--joints", "r_el").run() == 0
    shown = capsys.readouterr().out
    assert "r_el" in shown and "l_el" not in shown


def test_read_a_register_and_a_whole_table(bus: VirtualBus, capsys: Capture) -> None:
    found = rows(bus, capsys, ServosRead, "5", "Present Input Voltage")
    assert [(row["address"], row["value"], row["unit"]) for row in found] == [(144, 12.0, "V")]
    assert len(rows(bus, capsys, ServosRead, "5")) > 40
    with pytest.raises(UnknownName, match="Present Position"):
        given(ServosRead, "5", "Position", "--servo", bus.port).run()
    with pytest.raises(LostServo, match="servo 99"):
        given(ServosRead, "99", "--servo", bus.port).run()


def test_configure_writes_on_request_only(bus: VirtualBus, capsys: Capture) -> None:
    bus.servo(5).set("Return Delay Time", 250)
    arguments = ("--servo", bus.port, "--joints", "r_el", "--json")
    assert given(ServosConfigure, *arguments).run() == 0
    shown = json.loads(capsys.readouterr().out)
    assert not shown["written"] and "Return Delay Time" in {change["register"] for change in shown["changes"]}
    assert bus.servo(5).get("Return Delay Time") == 250
    assert given(ServosConfigure, *arguments, "--write").run() == 0
    assert json.loads(capsys.readouterr().out)["written"]
    assert bus.servo(5).get("Return Delay Time") == 0
    assert given(ServosConfigure, *arguments).run() == 0
    assert json.loads(capsys.readouterr().out)["changes"] == []


def test_reboot_clears_errors_of_the_named_servos(bus: VirtualBus) -> None:
    with bus.locked:
        bus.servo(5).fail(OVERLOAD)
        bus.servo(6).fail(OVERLOAD)
    assert given(ServosReboot, "5", "--servo", bus.port).run() == 0
    assert (bus.servo(5).alert, bus.servo(6).alert) == (False, True)
    with pytest.raises(HardwareFault, match=r"restarted 1 servos on .*, not: servo 99 .no answer."):
        given(ServosReboot, "6", "99", "--servo", bus.port).run()
    assert not bus.servo(6).alert


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_calibrate_needs_a_terminal(bus: VirtualBus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with pytest.raises(InvalidOption, match="needs a terminal"):
        given(ServosCalibrate, "--servo", bus.port, "--out", str(tmp_path / "c.yaml")).run()


@pytest.mark.parametrize("stop", [KeyboardInterrupt, EOFError])
def test_an_interrupted_calibration_leaves_nothing(
    bus: VirtualBus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stop: type[BaseException]
) -> None:
    asked: list[str] = []

    def answer(text: str) -> str:
        asked.append(text)
        if len(asked) == 2:
            raise stop
        return ""

    monkeypatch.setattr(sys, "stdin", Terminal())
    monkeypatch.setattr("builtins.input", answer)
    with pytest.raises((KeyboardInterrupt, InvalidOption)):
        given(ServosCalibrate, "--servo", bus.port, "--joints", "r_el", "--out", str(tmp_path / "c.yaml")).run()
    assert list(tmp_path.iterdir()) == []


def test_calibrate_writes_what_it_measured(bus: VirtualBus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    elbow = bus.servo(5)
    zero = elbow.motor.position

    def answer(text: str) -> str:
        with bus.locked:
            elbow.motor.position = zero + (1.0 if "positive" in text else -0.5 if "negative" in text else 0.0)
            elbow.advance(0.0)
        return ""

    monkeypatch.setattr(sys, "stdin", Terminal())
    monkeypatch.setattr("builtins.input", answer)
    out = tmp_path / "c.yaml"
    assert given(ServosCalibrate, "--servo", bus.port, "--joints", "r_el", "--out", str(out)).run() == 0
    assert given(ServosInfo, "--servo", bus.port, "--joints", "r_el", "--calibration", str(out)).run() == 0
