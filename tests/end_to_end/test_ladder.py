"""The ladder through the command line: gentler until a rung passes, each rung named where none does, off on request.

The motions are authored, so no trained weights are needed: arms swung as fast as these ask more of OP3's servos than
they have, and OP3 cannot jump at any pace.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import launch
from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from generator.text.understanding import Understood
from pipeline.candidate import Sample
from pipeline.pipeline import Pipeline
from ros_free_stack.files import load_motion, load_trajectory, load_verdict, save_motion
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import FPS

INFEASIBLE = 3
RUNGS = ("1.25 times slower", "1.6 times slower", "75% of its size", "1.4 times slower and 60% of its size")


def authored(name: str, **parameters: Any) -> HumanMotion:
    scene = Scene(1)
    perform(scene, name, **parameters)
    return HumanMotion(joints(scene.solve(0.1)), FPS, f"a person does a {name}")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two motions and their trajectories on OP3: swing_arms.npz and swing_arms_op3.npz, jump.npz and jump_op3.npz."""
    folder = tmp_path_factory.mktemp("ladder")
    for name, motion in {"swing_arms": authored("swing_arms", speed=2.5), "jump": authored("jump", height=0.3)}.items():
        save_motion(folder / f"{name}.npz", motion)
        arguments = ["retarget", str(folder / f"{name}.npz"), "--robot", "op3", "--out"]
        assert launch.main([*arguments, str(folder / f"{name}_op3.npz")]) == 0
    return folder


def validate(folder: Path, name: str, capsys: pytest.CaptureFixture[str], *more: str) -> tuple[int, dict]:
    """Exit code and JSON of `validate` on one of the trajectories."""
    capsys.readouterr()
    code = launch.main(["validate", str(folder / f"{name}_op3.npz"), "--json", *more])
    return code, json.loads(capsys.readouterr().out)


def test_without_repair_nothing_is_changed(folder, capsys):
    code, result = validate(folder, "swing_arms", capsys)
    assert code == INFEASIBLE
    assert "torque_peak" in {check["name"] for check in result["checks"] if not check["passed"]}
    assert not any(note.startswith(("changed", "tried")) for note in result["notes"])


def test_slower_arms_pass(folder, tmp_path, capsys):
    repair = ("--repair", "--motion", str(folder / "swing_arms.npz"), "--out", str(tmp_path))
    code, result = validate(folder, "swing_arms", capsys, *repair)
    assert code == 0
    changed = [note for note in result["notes"] if note.startswith("changed")]
    assert len(changed) == 1 and "times slower" in changed[0]
    before, after = load_motion(folder / "swing_arms.npz"), load_motion(tmp_path / "human_motion.npz")
    assert after.duration_s > 1.2 * before.duration_s
    np.testing.assert_allclose(after.joints, before.joints, atol=1e-6)
    trajectory, verdict = load_trajectory(tmp_path / "trajectory.npz"), load_verdict(tmp_path / "verdict.json")
    assert verdict.passed and verdict.trajectory_digest == trajectory.digest
    assert changed[0].split(",")[0] in (tmp_path / "report.html").read_text()


def test_a_jump_fails_on_every_rung_and_each_is_named(folder, tmp_path, capsys):
    repair = ("--repair", "--motion", str(folder / "jump.npz"), "--out", str(tmp_path))
    code, result = validate(folder, "jump", capsys, *repair)
    assert code == INFEASIBLE and not load_verdict(tmp_path / "verdict.json").passed
    tried = [note for note in result["notes"] if note.startswith("tried")]
    assert all(any(note.startswith(f"tried {rung}, default") for note in tried) for rung in RUNGS)
    assert all("failed " in note for note in tried)
    original = load_trajectory(folder / "jump_op3.npz")
    assert load_trajectory(tmp_path / "trajectory.npz").digest == original.digest, (
        "what is kept is the motion as it was"
    )


@pytest.mark.parametrize("repair", [True, False])
def test_a_run_repairs_unless_told_not_to(repair, tmp_path, monkeypatch, capsys):
    swing = authored("swing_arms", speed=2.5)
    monkeypatch.setattr(Pipeline, "understand", lambda *_, **__: Understood(("a person swings both arms",), True))
    monkeypatch.setattr(Pipeline, "generate", lambda *_, **__: (swing,))
    monkeypatch.setattr(Pipeline, "compared", lambda _, __, motions: [Sample(m, 0, (), 0.0) for m in motions])
    switch = "--repair" if repair else "--no-repair"
    code = launch.main(["run", "a person swings both arms", switch, "--no-video", "--json", "--out", str(tmp_path)])
    notes = json.loads(capsys.readouterr().out)["verdict"]["notes"]
    assert code == (0 if repair else INFEASIBLE)
    assert any(note.startswith("changed: ") for note in notes) == repair
    assert not any(note.startswith("tried") for note in notes)
