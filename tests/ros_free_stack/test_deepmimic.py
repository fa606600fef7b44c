import json
from pathlib import Path

import numpy as np
import pytest

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.deepmimic import JOINTS, WIDTH, read
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import INDEX


def row(duration: float = 1 / 30, root: tuple[float, float, float] = (0, 0.9, 0), **turns: float) -> list[float]:
    """A frame of the standing humanoid with some joints turned about z by an angle in rad."""
    values = [duration, *root]
    for name, width in (("root", 4), *JOINTS):
        half = turns.get(name, 0.0) / 2
        values += [np.cos(half), 0, 0, np.sin(half)] if width == 4 else [turns.get(name, 0.0)]
    return values


def write(path: Path, frames: list) -> Path:
    path.write_text(json.dumps({"Loop": "wrap", "Frames": frames}))
    return path


def joints(path: Path) -> np.ndarray:
    motion = read(path, SourceOptions()).content
    assert isinstance(motion, HumanMotion)
    return motion.joints


def test_a_standing_row_is_a_standing_person(tmp_path: Path) -> None:
    assert len(row()) == WIDTH == 44
    pose = joints(write(tmp_path / "a.txt", [row()]))[0]
    assert pose[INDEX["left_foot"], 2] == pytest.approx(0, abs=1e-9)
    assert pose[INDEX["left_hip"], 1] == pytest.approx(0.084887)
    assert pose[INDEX["right_hip"], 1] == pytest.approx(-0.084887)
    hip, knee, ankle = (pose[INDEX[f"left_{name}"]] for name in ("hip", "knee", "ankle"))
    assert (hip - knee)[2] == pytest.approx(0.421546)
    assert (knee - ankle)[2] == pytest.approx(0.409870)
    assert pose[INDEX["left_foot"], 0] > pose[INDEX["left_ankle"], 0] + 0.1
    heights = [pose[INDEX[name], 2] for name in ("left_hip", "pelvis", "spine1", "spine2", "spine3", "neck", "head")]
    assert heights == sorted(heights)


def test_knees_and_elbows_turn_about_the_axis_to_the_right(tmp_path: Path) -> None:
    pose = joints(write(tmp_path / "a.txt", [row(right_knee=-np.pi / 2, left_elbow=np.pi / 2)]))[0]
    shank = pose[INDEX["right_ankle"]] - pose[INDEX["right_knee"]]
    np.testing.assert_allclose(shank, (-0.409870, 0, 0), atol=1e-9)  # the heel to the back
    forearm = pose[INDEX["left_wrist"]] - pose[INDEX["left_elbow"]]
    np.testing.assert_allclose(forearm, (0.258947, 0, 0), atol=1e-9)  # the hand to the front


def test_walking_to_the_right_is_walking_to_minus_y(tmp_path: Path) -> None:
    moved = joints(write(tmp_path / "a.txt", [row(root=(0, 0.9, 0)), row(root=(0.2, 0.9, 0.5))]))
    np.testing.assert_allclose(moved[1, 0, :2] - moved[0, 0, :2], (0.2, -0.5), atol=1e-9)


def test_frames_of_unequal_duration_are_resampled_and_said(tmp_path: Path) -> None:
    frames = [row(0.05, (x, 0.9, 0)) for x in (0, 0.05)] + [row(0.1, (0.1, 0.9, 0)), row(0.05, (0.2, 0.9, 0))]
    source = read(write(tmp_path / "a.txt", frames), SourceOptions())
    assert isinstance(source.content, HumanMotion)
    assert source.content.fps == 20
    assert source.notes == ("frames of unequal duration: resampled to 20 fps, linearly",)
    np.testing.assert_allclose(source.content.joints[:, 0, 0], [0, 0.05, 0.1, 0.15, 0.2], atol=1e-9)
    even = read(write(tmp_path / "b.txt", [row(1 / 30)] * 4 + [row(0)]), SourceOptions())
    assert even.content.fps == 30
    assert not even.notes


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        ([], "no frames"),
        ([row(), row()[:-1]], "frame 1: expected 44 numbers, found 43"),
        ([row(), 3], "frame 1: expected 44 numbers, found int"),
        ([row(), ["x"] * 44], "something other than numbers"),
        ([row(), row(root=(0, float("nan"), 0))], "Frames: a value that is not finite at frame 1"),
        ([row(0), row()], "frame 0 lasts 0 s"),
        ([[*row()[:4], 2, 0, 0, 0, *row()[8:]]], "frame 0: the quaternion of root has length 2"),
    ],
)
def test_errors_name_the_frame(tmp_path: Path, frames: list, message: str) -> None:
    with pytest.raises(InvalidFile, match=message):
        read(write(tmp_path / "a.txt", frames), SourceOptions())


@pytest.mark.parametrize("text", ["", '{"Frames": [[0.1, 2', "[1, 2]", '{"Loop": "wrap"}', '{"Frames": 3}'])
def test_a_file_that_is_no_such_motion(tmp_path: Path, text: str) -> None:
    (tmp_path / "a.txt").write_text(text)
    with pytest.raises(InvalidFile, match="not a DeepMimic motion"):
        read(tmp_path / "a.txt", SourceOptions())
