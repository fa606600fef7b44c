"""Every bad input ends in one line on stderr, the documented exit code, and no file."""

import sys
from pathlib import Path

import numpy as np
import pytest

import launch
from ros_free_stack.files import save_trajectory
from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robots import load_robot


def run(*arguments: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str, str]:
    """Exit code, stdout and stderr of a command line."""
    code = launch.main(list(arguments))
    captured = capsys.readouterr()
    return code, captured.out, captured.err


def assert_one_error_line(error: str) -> None:
    lines = [line for line in error.splitlines() if line.strip()]
    assert len(lines) == 1, error
    assert lines[0].startswith("error: ")
    assert "Traceback" not in error


@pytest.mark.parametrize(
    ("prompt", "reason"),
    [
        ("", "empty"),
        ("   ", "empty"),
        ("wave " * 2000, "10000 characters"),
        ("eine Person winkt mit der rechten Hand", "English"),
        ("人が右手を振る", "English"),
        ("?!", "no words"),
    ],
)
def test_unusable_prompt(prompt: str, reason: str, tmp_path: Path, capsys):
    code, out, error = run("run", prompt, "--out", str(tmp_path / "out"), capsys=capsys)
    assert code == 2
    assert out == ""
    assert_one_error_line(error)
    assert reason in error or reason.replace("10000", "9999") in error
    assert not (tmp_path / "out").exists()


def test_sentence_outside_the_domain_names_the_nearest_actions(tmp_path: Path, capsys):
    code, _, error = run("run", "a person climbs a ladder", "--out", str(tmp_path / "out"), capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "nearest known actions" in error and "--anyway" in error
    assert not (tmp_path / "out").exists()


def test_unknown_robot_lists_the_known(tmp_path: Path, capsys):
    code, _, error = run("run", "wave", "--robot", "r2d2", "--out", str(tmp_path / "out"), capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "op3" in error and "g1" in error
    assert not (tmp_path / "out").exists()


def test_unwritable_folder(tmp_path: Path, capsys):
    blocker = tmp_path / "file"
    blocker.write_text("")
    code, _, error = run("run", "wave", "--out", str(blocker / "out"), capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "writable" in error


def test_missing_port_is_found_before_any_work(tmp_path: Path, capsys):
    code, _, error = run("run", "wave", "--servo", "/dev/does-not-exist", "--out", str(tmp_path / "out"), capsys=capsys)
    assert code == 4
    assert_one_error_line(error)
    assert "/dev/does-not-exist" in error
    assert not (tmp_path / "out").exists()


def test_a_joint_that_the_robot_lacks_fails_before_the_work(tmp_path: Path, capsys):
    arguments = ("run", "wave", "--servo", "sim", "--joints", "tail", "--out", str(tmp_path / "out"))
    code, _, error = run(*arguments, capsys=capsys)
    assert code == 2
    assert "unknown joint of op3 'tail'" in error and "r_el" in error
    assert not (tmp_path / "out").exists()


def test_a_dry_run_needs_servos(tmp_path: Path, capsys):
    code, _, error = run("run", "wave", "--dry-run", "--out", str(tmp_path / "out"), capsys=capsys)
    assert code == 2
    assert "--servo: is missing" in error


def test_robot_without_servos_cannot_stream(tmp_path: Path, capsys):
    arguments = ("run", "wave", "--robot", "g1", "--servo", "sim", "--out", str(tmp_path / "out"))
    code, _, error = run(*arguments, capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "g1" in error
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("candidates", ["0", "-1", "1000"])
def test_senseless_number_of_candidates(candidates: str, tmp_path: Path, capsys):
    arguments = ("run", "wave", "--candidates", candidates, "--out", str(tmp_path / "out"))
    code, _, error = run(*arguments, capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "--candidates" in error


def standing(frames: int = 20) -> RobotTrajectory:
    robot = load_robot("op3")
    return RobotTrajectory(
        robot="op3",
        model_sha256=robot.sha256,
        joint_names=robot.joint_names,
        fps=50.0,
        root_pos=np.tile([0, 0, 0.266], (frames, 1)),
        root_quat=np.tile([1.0, 0, 0, 0], (frames, 1)),
        joint_pos=np.tile(robot.standing_pos, (frames, 1)),
        contacts=np.ones((frames, 2), bool),
        foot_names=robot.foot_names,
    )


@pytest.mark.parametrize(("command", "out_name"), [("validate", "out"), ("render", "out.mp4")])
def test_truncated_trajectory(command: str, out_name: str, tmp_path: Path, capsys):
    path = tmp_path / "trajectory.npz"
    save_trajectory(path, standing())
    path.write_bytes(path.read_bytes()[:300])
    code, out, error = run(command, str(path), "--out", str(tmp_path / out_name), capsys=capsys)
    assert code == 2
    assert out == ""
    assert_one_error_line(error)
    assert "trajectory.npz" in error
    assert list(tmp_path.iterdir()) == [path]


def test_nan_in_a_trajectory(tmp_path: Path, capsys):
    path = tmp_path / "trajectory.npz"
    save_trajectory(path, standing())
    with np.load(path) as archive:
        data = dict(archive)
    data["joint_pos"][3, 4] = np.nan
    np.savez(path, **data)
    code, _, error = run("validate", str(path), capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "joint_pos" in error and "nan" in error


def test_retarget_needs_an_existing_motion(tmp_path: Path, capsys):
    arguments = ("retarget", str(tmp_path / "absent.npz"), "--out", str(tmp_path / "t.npz"))
    code, _, error = run(*arguments, capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "absent.npz" in error
    assert not (tmp_path / "t.npz").exists()


def test_unknown_command_lists_the_known(capsys):
    code, _, error = run("fly", capsys=capsys)
    assert code == 2
    assert_one_error_line(error)
    assert "run" in error and "stream" in error


def test_help_names_every_command_and_imports_no_stage(capsys):
    code, out, _ = run("--help", capsys=capsys)
    assert code == 0
    assert all(name in out for name in launch.COMMANDS)


def test_debug_shows_the_traceback(capsys):
    code, _, error = run("robots", "show", "r2d2", "--debug", capsys=capsys)
    assert code == 2
    assert "Traceback" in error


@pytest.mark.parametrize("name", sorted(launch.COMMANDS))
def test_every_command_has_help(name: str, capsys):
    with pytest.raises(SystemExit) as caught:
        launch.main([*name.split(), "--help"])
    assert caught.value.code == 0
    assert "--json" in capsys.readouterr().out


@pytest.mark.parametrize("asked", [[], ["--help"], ["-h"]])
def test_a_group_lists_its_commands(asked: list[str], capsys):
    assert launch.main(["servos", *asked]) == 0
    shown = capsys.readouterr().out
    assert "servos scan" in shown and "data build" not in shown


def test_help_is_quick_to_import():
    """The table of commands alone pulls in no model library."""
    import subprocess

    code = "import sys, launch; launch.main(['--help']); sys.exit('torch' in sys.modules or 'mujoco' in sys.modules)"
    finished = subprocess.run(
        [sys.executable, "-c", code], check=False, cwd=Path(launch.__file__).parent, capture_output=True
    )
    assert finished.returncode == 0
