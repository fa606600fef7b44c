"""Files that a stream will write: refused before anything moves, and no reason for the robot to do anything else."""

import json
import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest
import tyro

from hw import stream as stream_module
from hw.cli import Stream
from hw.commands.setup import ServosCalibrate
from hw.outputs import check_output
from hw.stream import stream
from hw.virtual.bus import VirtualBus
from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import save_trajectory, save_verdict
from ros_free_stack.robots import ServoSafety, load_robot
from tests.hw.verdicts import judged, motion

OP3 = load_robot("op3")
SAFETY = ServoSafety(stall_s=60, late_after=10**6, watchdog_s=2.5, hold_s=0.03, lost_after=50)
ROOT = Path(__file__).parents[2]
LIMITED = """
import resource, signal, sys
from pathlib import Path
from hw.outputs import check_output
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
check_output("--telemetry", Path(sys.argv[1]), inputs={}, size=1_000_000)
"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    trajectory = motion(OP3, seconds=0.2)
    save_trajectory(tmp_path / "trajectory.npz", trajectory)
    save_verdict(tmp_path / "verdict.json", judged(trajectory))
    return tmp_path / "trajectory.npz", tmp_path / "verdict.json"


def untouched(bus: VirtualBus) -> bool:
    return all(servo.goal_extremes is None and not servo.torque_changes for servo in bus.network.all_servos)


@pytest.mark.parametrize("name", ["trajectory.npz", "verdict.json", "../{folder}/trajectory.npz", "link.npz"])
def test_an_output_never_overwrites_an_input(files: tuple[Path, Path], tmp_path: Path, name: str) -> None:
    (tmp_path / "link.npz").symlink_to(files[0])
    before = files[0].read_bytes()
    out = tmp_path / name.format(folder=tmp_path.name)
    with VirtualBus.of_robot(OP3) as bus:
        command = tyro.cli(Stream, args=[*map(str, files), "--servo", bus.port, "--telemetry", str(out)])
        with pytest.raises(InvalidOption, match=r"--telemetry: .* that is read: name another file"):
            command.run()
        assert untouched(bus) and bus.heard == 0
    assert files[0].read_bytes() == before


def test_a_calibration_never_overwrites_the_one_that_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "c.yaml"
    path.write_text("robot: op3\njoints:\n  r_el: {id: 5, direction: 1, offset: 0.0, lower: -1.0, upper: 1.0}\n")
    monkeypatch.setattr(sys.stdin, "isatty", lambda: True, raising=False)
    arguments = ["--servo", "/dev/nothing", "--calibration", str(path), "--out", str(path)]
    with pytest.raises(InvalidOption, match="that is read"):
        tyro.cli(ServosCalibrate, args=arguments).run()


def test_a_folder_is_refused_before_anything_moves(tmp_path: Path) -> None:
    trajectory = motion(OP3, seconds=0.2)
    with VirtualBus.of_robot(OP3) as bus:
        with pytest.raises(InvalidFile, match="is a folder, expected the name of a file"):
            stream(trajectory, judged(trajectory), OP3, port=bus.port, telemetry=tmp_path)
        assert untouched(bus)


def test_a_limit_on_the_size_of_files_is_found_before_anything_moves(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(tmp_path / "t.npz")], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert "InvalidFile" in done.stderr and "File too large" in done.stderr
    assert list(tmp_path.iterdir()) == []
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] != 100_000


def test_a_full_disk_is_found_before_anything_moves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(handle: int, offset: int, length: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "posix_fallocate", full)
    with pytest.raises(InvalidFile, match=r"cannot be written \(5000 bytes\): No space left on device"):
        check_output("--telemetry", tmp_path / "t.npz", inputs={}, size=5000)
    assert list(tmp_path.iterdir()) == []


def test_telemetry_that_fails_afterwards_is_told_and_changes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    trajectory, out = motion(OP3, seconds=0.5), tmp_path / "t.npz"

    def fail(path: Path, message: object) -> None:
        raise InvalidFile(path, "cannot be written: No space left on device")

    monkeypatch.setattr(stream_module, "save_telemetry", fail)
    with VirtualBus.of_robot(OP3) as bus:
        report = stream(trajectory, judged(trajectory), OP3, port=bus.port, telemetry=out, safety=SAFETY)
        assert not any(servo.torque_on for servo in bus.network.all_servos)
    assert any("no telemetry" in note and "No space left" in note for note in report.errors)
    assert "warning: no telemetry" in capsys.readouterr().err
    json.dumps(report.as_dict())
