"""Every bad input ends in one line on stderr, the documented exit code, and no file."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import launch
from pipeline.commands import COMMANDS
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


@pytest.mark.parametrize(
    ("typed", "wanted"),
    [
        (("rnu", "waves"), "did you mean run?"),
        (("fly",), "--help lists them all"),
        (("robots", "lst"), "did you mean list?"),
        (("wave with the hand",), "run 'wave with the hand'"),
        (("run", "waves", "--robt", "op3"), "did you mean --robot?"),
        (("run", "waves", "with", "a", "hand"), "quotation marks"),
        (("run", "waves", "--mount", "fred"), "did you mean free?"),
        (("run", "waves", "--candidates", "x"), "expected a whole number, found 'x'"),
        (("run", "waves", "--candidates"), "needs a value"),
        (("run", "waves", "--robot", "op4"), "did you mean op3?"),
        (("run", "waves", "--out", "/proc/nowhere"), "writable"),
        (("generate", "waves", "--out", "x.txt"), "ends in .npz"),
        (("generate", "waves", "--candidates", "0"), "expected 1 to"),
        (("validate",), "trajectory must be given"),
        (("validate", "absent.npz"), "no such file"),
        (("retarget", "absent.bvh"), "no such file"),
        (("render", "absent.npz", "--out", "x.gif"), "ends in .mp4"),
    ],
)
def test_a_likely_mistake_is_answered_with_what_to_do(typed: tuple[str, ...], wanted: str, capsys):
    code, out, error = run(*typed, capsys=capsys)
    assert code == 2
    assert out == ""
    assert_one_error_line(error)
    assert wanted in error
    code, out, _ = run(*typed, "--json", capsys=capsys)
    found = json.loads(out)["error"]
    assert found["exit_code"] == code == 2
    assert wanted in found["message"] and found["type"]


@pytest.mark.parametrize(
    "typed",
    [("run", ""), ("run", "waves", "--robot", "op4"), ("generate", "waves", "--out", "x.txt"), ("validate", "x")],
)
def test_a_refusal_loads_nothing_slow(typed: tuple[str, ...]):
    code = f"""
import sys, launch
launch.main({list(typed)!r})
sys.exit(bool({{'torch', 'mujoco', 'casadi', 'spacy', 'matplotlib', 'scipy'}} & set(sys.modules)))
"""
    folder = Path(launch.__file__).parent
    finished = subprocess.run([sys.executable, "-c", code], check=False, cwd=folder, capture_output=True)
    assert finished.returncode == 0, finished.stderr.decode()


def test_version_and_doctor_need_no_dependency(tmp_path: Path):
    root = Path(launch.__file__).parent
    bare = [sys.executable, "-S", "-E", str(root / "launch.py")]
    version = subprocess.run([*bare, "--version"], capture_output=True, text=True, check=True).stdout
    assert version.startswith("ros-free-stack ")
    done = subprocess.run([*bare, "doctor", "--json"], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.returncode == 2
    found = json.loads(done.stdout)
    assert found["python"]["ok"] and not found["packages"]["ok"] and found["weights"]["ok"]


def test_doctor_tells_a_compiler_that_fails(tmp_path: Path, monkeypatch, capsys):
    broken = tmp_path / "broken-cc"
    broken.write_text("#!/bin/sh\necho 'no space left' >&2; exit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    code, out, _ = run("doctor", "--json", capsys=capsys)
    found = json.loads(out)
    assert code == 0  # the stack works without one
    assert not found["compiler"]["ok"] and "no space left" in found["compiler"]["detail"]
    assert "torch" in found["packages"]["detail"]


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_knows_commands_options_and_robots(shell: str, capsys):
    code, out, _ = run("completion", shell, capsys=capsys)
    assert code == 0
    assert "op3" in out and "calibrate" in out and "no-video" in out


def test_bash_completes(tmp_path: Path, capsys):
    _, script, _ = run("completion", "bash", capsys=capsys)
    ask = 'COMP_WORDS=(rfs {}); COMP_CWORD={}; _rfs; echo "${{COMPREPLY[@]}}"'
    for words, index, wanted in (("va", 1, "validate"), ("servos sc", 2, "scan"), ("run --robot op", 3, "op3")):
        typed = f"{script}\n{ask.format(words, index)}"
        done = subprocess.run(["bash", "-c", typed], capture_output=True, text=True, check=True, cwd=tmp_path)
        assert done.stdout.split() == [wanted]


def test_actions_are_listed_and_found(capsys):
    code, out, _ = run("actions", "kick", "--json", capsys=capsys)
    names = [row["name"] for row in json.loads(out)["actions"]]
    assert code == 0
    assert names and all(row["examples"] for row in json.loads(out)["actions"])
    assert len(names) < 30
    code, _, error = run("actions", "teleport", capsys=capsys)
    assert code == 2
    assert_one_error_line(error)


def test_help_names_every_command_and_imports_no_stage(capsys):
    code, out, _ = run("--help", capsys=capsys)
    assert code == 0
    assert all(name in out for name in COMMANDS)


def test_debug_shows_the_traceback(capsys):
    code, _, error = run("robots", "show", "r2d2", "--debug", capsys=capsys)
    assert code == 2
    assert "Traceback" in error


@pytest.mark.parametrize("name", sorted(COMMANDS))
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
    code = "import sys, launch; launch.main(['--help']); sys.exit('torch' in sys.modules or 'mujoco' in sys.modules)"
    finished = subprocess.run(
        [sys.executable, "-c", code], check=False, cwd=Path(launch.__file__).parent, capture_output=True
    )
    assert finished.returncode == 0
