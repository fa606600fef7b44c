"""The whole path through the command line, with the trained weights: text to servos on the virtual bus."""

import contextlib
import io
import json
import runpy
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import launch
from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from generator.registry import DEFAULT, WEIGHTS_FOLDER
from pipeline.pipeline import Pipeline
from ros_free_stack.files import load_motion, load_telemetry, load_trajectory, load_verdict
from ros_free_stack.messages import ControllerName, HumanMotion, RobotTrajectory
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import FPS
from sim.draw.report import write_report
from sim.judge.verdict import Judgement

WAVE = ("run", "a person waves with the right hand", "--robot", "op3", "--candidates", "2", "--no-video", "--json")
EXAMPLES = Path(launch.__file__).parent / "examples"

pytestmark = pytest.mark.skipif(
    not (WEIGHTS_FOLDER / DEFAULT / "mask").is_dir(), reason="the weights folder holds no trained models"
)


@pytest.fixture(scope="module")
def wave(tmp_path_factory: pytest.TempPathFactory) -> tuple[int, dict, Path]:
    """Exit code, JSON and folder of one run on OP3 with the virtual bus."""
    out = tmp_path_factory.mktemp("wave") / "run"
    stdout = io.StringIO()
    with contextlib.redirect_stdout(stdout):
        code = launch.main(
            [*WAVE, "--servo", "sim", "--out", str(out)],
        )
    return code, json.loads(stdout.getvalue()), out


def test_wave_is_feasible_and_streamed(wave):
    code, result, _ = wave
    assert code == 0
    assert result["verdict"]["passed"]
    assert result["in_domain"]
    assert [segment["text"] for segment in result["segments"]] == ["a person waves with the right hand"]
    assert result["search"] == {"candidates": 2, "judged": len(result["candidates"]), "exhaustive": False}
    assert result["candidates"][0]["passed"]
    assert len(result["candidates"]) == 1 or not result["candidates"][1]["passed"]
    assert result["servo"]["cycles"] > 100
    assert {"rate_hz", "jitter_p99_ms", "errors"} <= set(result["servo"])
    assert {"text", "generate", "retarget", "validate", "to_verdict", "report", "servo"} <= set(result["timings_s"])
    assert {"name", "value", "unit", "limit", "passed"} <= set(result["verdict"]["checks"][0])


def test_what_a_motion_does_not_show_is_told(wave, tmp_path: Path, capsys):
    """Nobody squats three times in two seconds."""
    _, result, _ = wave
    assert [candidate["not_shown"] for candidate in result["candidates"]] == [[]] * len(result["candidates"])
    assert all(candidate["violations"] == 0 for candidate in result["candidates"])
    squats = ("generate", "a person squats three times", "--duration", "2", "--out", str(tmp_path / "squats.npz"))
    assert launch.main(list(squats)) == 0
    assert "prompt mismatch: 0.0 to 2.0 s: does not show the number of `a person squats" in capsys.readouterr().out


def test_the_right_hand_waves_above_the_shoulder_and_the_left_one_hangs(wave):
    _, _, out = wave
    places = load_motion(out / "human_motion.npz").joints
    right_lift = places[:, 21, 2] - places[:, 17, 2]
    left_lift = places[:, 20, 2] - places[:, 16, 2]
    assert right_lift.max() > 0.0
    assert left_lift.max() < -0.1


def test_run_folder_is_complete_and_consistent(wave):
    _, result, out = wave
    assert {path.name for path in out.iterdir()} == set(result["files"])
    trajectory, verdict = load_trajectory(out / "trajectory.npz"), load_verdict(out / "verdict.json")
    assert verdict.passed
    assert verdict.trajectory_digest == trajectory.digest
    assert trajectory.model_sha256 == load_robot("op3").sha256
    assert (out / "trajectory.csv").read_text().startswith("time_s,root_x")
    assert load_telemetry(out / "telemetry.npz").joint_names == load_robot("op3").joint_names
    page = (out / "report.html").read_text()
    assert 'alt="servo angles"' in page
    assert "waves with the right hand" in page
    assert "http://" not in page.replace("http://www.w3.org", "") and "https://" not in page


def test_same_seed_gives_the_same_trajectory(wave, tmp_path: Path):
    _, _, out = wave
    launch.main([*WAVE, "--out", str(tmp_path)])
    assert load_trajectory(tmp_path / "trajectory.npz").digest == load_trajectory(out / "trajectory.npz").digest


def test_an_infeasible_motion_is_reported_and_never_streamed(tmp_path: Path, monkeypatch, capsys):
    scene = Scene(1)
    perform(scene, "jump", height=0.3)
    leap = HumanMotion(joints(scene.solve(0.1)), FPS, "a person jumps")
    monkeypatch.setattr(Pipeline, "generate", lambda *_, **__: (leap,))
    told: list[str] = []

    def report(*arguments: Any, **options: Any) -> Path:
        told.append(capsys.readouterr().err)
        return write_report(*arguments, **options)

    monkeypatch.setattr("sim.draw.report.write_report", report)
    arguments = ["run", "a person jumps", "--candidates", "1", "--no-repair", "--no-video", "--servo", "sim", "--json"]
    code = launch.main([*arguments, "--out", str(tmp_path)])
    captured = capsys.readouterr()
    assert "verdict: INFEASIBLE" in told[0], "before the report is drawn"
    assert "0 of 1 candidates are feasible on op3" in (tmp_path / "report.html").read_text()
    result = json.loads(captured.out)
    assert code == 3
    assert result["verdict"]["passed"] is False and result["servo"] is None
    assert "nothing is streamed" in told[0]
    assert not load_verdict(tmp_path / "verdict.json").passed
    assert not (tmp_path / "telemetry.npz").exists()


def test_a_robot_that_only_feedback_keeps_up_is_not_streamed_to(tmp_path: Path, monkeypatch, capsys):
    """A judge who lets feedback alone keep the robot up: told with what would do."""
    judged = Pipeline.judge

    def judge(pipeline: Pipeline, trajectory: RobotTrajectory, controller: ControllerName | None = None) -> Judgement:
        found = judged(pipeline, trajectory, controller)
        if controller == "default":
            return found
        checks = (replace(c, value=9.0, passed=False) if c.name == "fall_height" else c for c in found.verdict.checks)
        return replace(found, verdict=replace(found.verdict, checks=tuple(checks)))

    monkeypatch.setattr(Pipeline, "judge", judge)
    arguments = [*WAVE, "--candidates", "1", "--no-repair", "--servo", "sim", "--out", str(tmp_path)]
    assert launch.main(arguments) == 3
    captured = capsys.readouterr()
    assert json.loads(captured.out)["verdict"]["controller"] == "pd"
    assert "only feedback keeps op3 up: hang it up and use --mount fixed" in captured.err


def test_examples_run_one_after_the_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys):
    steps = [
        ("1_text_to_motion.py", "a person raises both arms", str(tmp_path)),
        ("2_motion_to_robot.py", str(tmp_path / "human_motion.npz"), "op3", str(tmp_path / "trajectory.npz")),
        ("3_judge_a_trajectory.py", str(tmp_path / "trajectory.npz")),
        ("4_stream_to_servos.py", str(tmp_path / "trajectory.npz"), str(tmp_path / "verdict.json"), "sim"),
    ]
    for name, *arguments in steps:
        monkeypatch.setattr(sys, "argv", [name, *arguments])
        runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    out = capsys.readouterr().out
    assert "feasible" in out.splitlines()
    assert "cycles" in out
