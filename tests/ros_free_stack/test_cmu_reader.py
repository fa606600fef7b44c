import json
import os
from pathlib import Path

import numpy as np
import pytest

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.formats import cmu
from ros_free_stack.formats.frames import put_on_floor, resample
from ros_free_stack.skeleton import INDEX

ENTRY = {
    "take": "09_01",
    "description": "run",
    "subject": "#9",
    "format": "bvh",
    "fps": 120,
    "clips": [
        {
            "id": "013920",
            "split": "train",
            "start_s": 0.0,
            "end_s": 1.2,
            "captions": ["a person runs."],
            "captions_mirrored": [],
        }
    ],
}


@pytest.fixture(scope="session")
def archive() -> Path:
    folder = os.environ.get("RFS_CMU")
    if folder is None:
        pytest.skip("RFS_CMU does not name a folder with the CMU motion capture archive")
    return Path(folder)


def write_index(folder: Path, data: object) -> None:
    (folder / "index.json").write_text(json.dumps(data), encoding="utf-8")


def test_index(tmp_path: Path) -> None:
    write_index(tmp_path, [ENTRY, ENTRY | {"take": "09_10"}])
    (take,) = cmu.index(tmp_path)  # 09_10 is damaged
    assert (take.name, take.fps) == ("09_01", 120)
    assert take.clips[0].captions == ("a person runs.",)


@pytest.mark.parametrize("data", [{}, [{"take": "x"}], [1]])
def test_a_bad_index_is_refused(tmp_path: Path, data: object) -> None:
    write_index(tmp_path, data if data else [ENTRY | {"clips": [{"id": "1"}]}])
    with pytest.raises(InvalidFile, match="not an index of takes"):
        cmu.index(tmp_path)


def test_unknown_take_lists_the_known_ones(tmp_path: Path) -> None:
    (tmp_path / "09").mkdir()
    (tmp_path / "09/09_02.bvh").touch()
    with pytest.raises(UnknownName, match="valid: 09_02"):
        cmu.read_take(tmp_path, "09_01")


def test_a_bvh_of_another_skeleton_names_the_missing_joint(tmp_path: Path) -> None:
    text = "HIERARCHY\nROOT hip\n{\nOFFSET 0 0 0\nCHANNELS 3 Xrotation Yrotation Zrotation\n}\nMOTION\n"
    (tmp_path / "09").mkdir()
    path = tmp_path / "09/09_01.bvh"
    path.write_text(text + "Frames: 20\nFrame Time: 0.00833333\n" + "0 0 0\n" * 20, encoding="utf-8")
    with pytest.raises(InvalidFile, match=r"09_01\.bvh: no joint 'lThigh' \(for left_hip\)"):
        cmu.read_take(tmp_path, "09_01")
    path.write_text(text + "Frames: 20\nFrame Time: 0.05\n" + "0 0 0\n" * 20, encoding="utf-8")
    with pytest.raises(InvalidFile, match=r"20\.0 frames a second"):
        cmu.read_take(tmp_path, "09_01")


def test_sound_spans_cut_where_a_joint_jumps() -> None:
    joints = np.zeros((20, 22, 3))
    joints[12:, 5] += 1
    assert cmu.sound_spans(joints) == ((0, 12), (12, 20))
    assert cmu.sound_spans(joints[:12]) == ((0, 12),)


def test_resample_is_exact_on_common_frames_and_linear_between() -> None:
    points = np.random.default_rng(0).normal(size=(121, 2, 3))
    np.testing.assert_array_equal(resample(points, fps=120, to=20), points[::6])
    ramp = np.arange(6.0)[:, None]
    np.testing.assert_allclose(resample(ramp, fps=12.5, to=20)[:, 0], np.arange(9) * 0.625)


def test_the_floor_ignores_single_frames() -> None:
    joints = np.random.default_rng(0).uniform(0.3, 2.0, size=(200, 22, 3))
    joints[:, 10, 2] = 0.25
    joints[7, 10, 2] = -1.0
    assert np.median(put_on_floor(joints)[:, 10, 2]) == pytest.approx(0)


def test_takes_are_people_on_the_floor(archive: Path) -> None:
    takes = cmu.index(archive)
    assert len(takes) > 150
    for take in takes[::4]:
        joints = cmu.read_take(archive, take.name)
        assert np.isfinite(joints).all(), take.name
        for side in ("left", "right"):
            hip, knee, ankle = (joints[:, INDEX[f"{side}_{name}"]] for name in ("hip", "knee", "ankle"))
            assert 0.3 < np.median(np.linalg.norm(knee - hip, axis=-1)) < 0.5, take.name
            assert 0.3 < np.median(np.linalg.norm(ankle - knee, axis=-1)) < 0.5, take.name
        assert -0.06 < joints[..., 2].min() < 0.02, take.name
        toes = joints[:, [10, 11]].sum(axis=1) - joints[:, [7, 8]].sum(axis=1)
        across = joints[:, INDEX["left_hip"]] - joints[:, INDEX["right_hip"]]
        left = toes[:, 0] * across[:, 1] - toes[:, 1] * across[:, 0] > 0
        assert left.mean() > 0.8, take.name
        clip_end = max((clip.end_s for clip in take.clips), default=0.0)
        assert clip_end <= len(joints) / 20 + 0.15, take.name


@pytest.mark.parametrize("take", ["02_01", "09_01", "131_03"])
def test_a_truncated_take_is_refused(archive: Path, tmp_path: Path, take: str) -> None:
    subject = take.partition("_")[0]
    (tmp_path / subject).mkdir()
    for path in (archive / subject).glob("*"):
        if path.stem in (take, subject):
            data = path.read_bytes()
            (tmp_path / subject / path.name).write_bytes(data if path.suffix == ".asf" else data[: len(data) // 2])
    with pytest.raises(InvalidFile, match=r"line \d+"):
        cmu.read_take(tmp_path, take)
