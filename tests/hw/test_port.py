"""Serial ports: one program at a time, what a person is told who is not let in, the latency timer."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest
import serial

from hw.bus import BAUD_RATES, Bus
from hw.port import claimed, lower_latency, unopened
from hw.virtual.bus import VirtualBus
from hw.virtual.servo import Servo
from ros_free_stack.errors import PortError

ROOT = Path(__file__).parents[2]
SECOND = "import sys; from hw.bus import Bus; Bus(sys.argv[1], 57600)"


def test_a_second_program_is_refused_by_name_and_the_first_goes_on() -> None:
    with VirtualBus([Servo.make(1, baud=2_000_000)], timed=True) as virtual, Bus(virtual.port, 2_000_000) as bus:
        done = subprocess.run(
            [sys.executable, "-c", SECOND, virtual.port], cwd=ROOT, capture_output=True, text=True, check=False
        )
        assert f"(process {os.getpid()})" in done.stderr and "is in use by" in done.stderr
        # The rate would have changed, and no servo heard any more.
        assert bus.ping(1) == "XM430-W350"


def test_a_port_is_free_again_once_it_is_closed() -> None:
    with VirtualBus([Servo.make(1)]) as virtual:
        with Bus(virtual.port, 1_000_000), pytest.raises(PortError, match="two programs on one bus"):
            Bus(virtual.port, 1_000_000)
        with Bus(virtual.port, 1_000_000) as bus:
            assert bus.ping(1) == "XM430-W350"


def test_a_port_that_cannot_be_opened_is_free_for_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*arguments: object, **options: object) -> None:
        raise serial.SerialException(errno.EIO, "broken")

    with VirtualBus([]) as virtual:
        with monkeypatch.context() as patch, pytest.raises(PortError, match="Input/output error"):
            patch.setattr(serial.Serial, "open", refuse)
            Bus(virtual.port, 1_000_000)
        with claimed(virtual.port):
            pass


@pytest.mark.parametrize("baud", BAUD_RATES)
def test_every_rate_of_the_servos_can_be_opened(baud: int) -> None:
    with VirtualBus([Servo.make(1, baud=baud)]) as virtual, Bus(virtual.port, baud) as bus:
        assert bus.ping(1) == "XM430-W350"


def test_who_may_not_open_a_port_is_told_what_would_help(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "ttyUSB7"
    file.write_text("")
    denied = PermissionError(errno.EACCES, "Permission denied")
    file.chmod(0o600)
    words = str(unopened(str(file), denied))
    assert "Permission denied" in words and 'KERNEL=="ttyUSB*", MODE="0666"' in words and "99-dynamixel.rules" in words
    file.chmod(0o660)
    monkeypatch.setattr("grp.getgrgid", lambda number: type("Group", (), {"gr_name": "dialout"}))
    assert "sudo usermod -aG dialout $USER" in str(unopened(str(file), denied))


def test_a_busy_port_is_no_missing_port() -> None:
    assert "is in use by another program" in str(unopened("/dev/nothing", OSError(errno.EBUSY, "Device busy")))


def timer(folder: Path, text: str) -> Path:
    file = folder / "ttyUSB7" / "latency_timer"
    file.parent.mkdir()
    file.write_text(text)
    return file


def test_the_latency_timer_is_lowered(tmp_path: Path) -> None:
    file = timer(tmp_path, "16\n")
    latency = lower_latency("/dev/ttyUSB7", tmp_path)
    assert (latency.ok, latency.words, file.read_text()) == (True, "1 ms", "1")
    assert lower_latency("/dev/ttyUSB7", tmp_path).words == "1 ms"


def test_a_latency_timer_that_may_not_be_set_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, text: str) -> None:
        raise PermissionError

    file = timer(tmp_path, "16\n")
    monkeypatch.setattr(Path, "write_text", refuse)
    latency = lower_latency("/dev/ttyUSB7", tmp_path)
    assert not latency.ok
    assert latency.words == f"not lowered to 1 ms: as root, echo 1 > {file}"


def test_a_port_without_a_latency_timer(tmp_path: Path) -> None:
    assert lower_latency("/dev/ttyUSB7", tmp_path).words == "the port has none"
