"""Files as people have them, through the command line: read and told, or one line that says what to do."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import launch
from benchmarks.walk_variants import Variant, make
from ros_free_stack.files import load_motion, load_trajectory
from ros_free_stack.skeleton import INDEX

WALK = Variant(
    rig="Unreal", prefix="", foreign_root=True, unit="cm", up="z", rest="bones along x", order="ZYX", moves="XYZ",
    all_move=False, fps=60.0, quirk="UTF-16", lead="held", tall=1.8, heading=2.0, start=0.3, seconds=2.0,
)  # fmt: skip


@pytest.fixture
def walk(tmp_path: Path) -> Path:
    path = tmp_path / "walk.bvh"
    path.write_bytes(make(WALK)[0])
    return path


def test_a_foreign_file_is_read_and_everything_assumed_is_told(tmp_path: Path, walk: Path, capsys) -> None:
    out = tmp_path / "walk.npz"
    assert launch.main(["convert", str(walk), str(out)]) == 0
    said = capsys.readouterr().err
    assert "unknown rig, joints told by their names: pelvis pelvis, left_hip thigh_l" in said
    assert "lengths in cm, z up" in said
    assert "the first 60 frames are a pose that the motion jumps from or to: left out" in said
    motion, wanted = load_motion(out), make(WALK)[1]
    knees = [INDEX["left_knee"], INDEX["right_knee"]]
    np.testing.assert_allclose(motion.joints[:, knees], wanted[:, knees], atol=1e-3)


def test_a_part_of_it_goes_to_a_robot_at_its_own_pace(tmp_path: Path, walk: Path, capsys) -> None:
    out = tmp_path / "robot.npz"
    arguments = ["retarget", str(walk), "--robot", "op3", "--solver", "frames", "--no-balance", "--keep-timing"]
    assert launch.main([*arguments, "--start", "1.5", "--end", "2.7", "--out", str(out)]) == 0
    assert "pace:" not in capsys.readouterr().err
    assert load_trajectory(out).duration_s == pytest.approx(3.0, abs=0.05)
    table = ["convert", str(out.with_suffix(".csv")), str(tmp_path / "again.npz"), "--robot", "op3", "--floor"]
    assert launch.main(table) == 0
    assert load_trajectory(tmp_path / "again.npz").duration_s == pytest.approx(3.0, abs=0.05)


@pytest.mark.parametrize(
    ("change", "options", "message"),
    [
        (
            lambda text: text.replace("Frame Time: 0.016666667", "Frame Time: 60"),
            [],
            "--source-fps: name the frame rate",
        ),
        (lambda text: text.replace("JOINT calf_l", "JOINT thing"), [], "left_knee: FILL_IN"),
        (lambda text: text[: len(text) // 2], [], "line "),
        (lambda text: text, ["--clip", "someone"], "unknown skeleton in"),
        (lambda text: text, ["--start", "60"], "--start: "),
        (lambda text: text, ["--height", "180"], "--height: expected 0.3 to 3 m"),
        (lambda text: text, ["--quaternion", "xyzw"], "--quaternion: BVH"),
        (lambda text: text, ["--floor"], "--floor: BVH"),
    ],
)
def test_what_cannot_be_read_is_one_error_and_no_file(tmp_path: Path, change, options, message: str, capsys) -> None:
    path = tmp_path / "walk.bvh"
    path.write_text(change(make(replace(WALK, quirk="plain"))[0].decode()))
    assert launch.main(["convert", str(path), str(tmp_path / "out.npz"), *options]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: ") and message in said and "Traceback" not in said
    assert [item.name for item in tmp_path.iterdir()] == ["walk.bvh"]
