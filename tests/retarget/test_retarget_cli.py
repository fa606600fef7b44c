import errno
import json

import numpy as np
import pytest

from retarget.cli import Retarget
from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.files import load_trajectory, save_motion, save_trajectory
from ros_free_stack.formats.registry import save


def test_writes_trajectory_and_table_and_reports(tmp_path, motions, capsys):
    save_motion(tmp_path / "human.npz", motions["wave"])
    out = tmp_path / "new" / "robot.npz"
    assert Retarget(motion=tmp_path / "human.npz", out=out, balance=False, json=True).run() == 0
    result = json.loads(capsys.readouterr().out)
    trajectory = load_trajectory(out)
    assert result["frames"] == len(trajectory.joint_pos) == len(out.with_suffix(".csv").read_text().splitlines()) - 1
    assert set(result["report"]["position_error_cm"]) >= {"pelvis", "right_wrist", "left_sole"}


def test_takes_a_motion_in_another_format(tmp_path, motions, capsys):
    files = {"human.npz": "a.npz", "human.bvh": "b.npz"}
    for name, out in files.items():
        save(tmp_path / name, motions["stand"])
        assert Retarget(motion=tmp_path / name, out=tmp_path / out, balance=False).run() == 0
    assert "this project's own skeleton; lengths in cm, y up" in capsys.readouterr().err
    first, second = (load_trajectory(tmp_path / out) for out in files.values())
    np.testing.assert_allclose(second.joint_pos, first.joint_pos, atol=1e-3)
    save_trajectory(tmp_path / "robot.npz", first)
    with pytest.raises(InvalidFile, match="holds a robot trajectory, expected human motion"):
        Retarget(motion=tmp_path / "robot.npz", out=tmp_path / "c.npz").run()
    with pytest.raises(InvalidOption, match=r"--units: .* has no use for it"):
        Retarget(motion=tmp_path / "human.npz", out=tmp_path / "c.npz", units="cm").run()


@pytest.mark.parametrize(
    ("options", "error"),
    [
        ({"robot": "r2d2"}, UnknownName),
        ({"out": "robot.txt"}, InvalidOption),
        ({"motion": "missing.npz"}, InvalidFile),
        ({"fps": -1.0}, InvalidOption),
    ],
)
def test_bad_input_is_one_clear_error_and_writes_nothing(tmp_path, motions, options, error):
    save_motion(tmp_path / "human.npz", motions["stand"])
    arguments = {"motion": "human.npz", "out": "out/robot.npz"} | options
    paths = {name: tmp_path / arguments[name] for name in ("motion", "out")}
    with pytest.raises(error):
        Retarget(**(arguments | paths)).run()
    assert not list(tmp_path.rglob("robot*"))


@pytest.mark.parametrize(
    ("damage", "words"),
    [
        (lambda joints: np.where(np.arange(len(joints))[:, None, None] == 7, np.nan, joints), "nan"),
        (lambda joints: joints[:0], "is empty"),
        (lambda joints: joints[:, :21], "21"),
    ],
)
def test_damaged_joints_are_named_and_nothing_is_written(tmp_path, motions, damage, words):
    source = tmp_path / "human.npz"
    save_motion(source, motions["stand"])
    with np.load(source) as archive:
        arrays = dict(archive)
    np.savez(source, **(arrays | {"joints": damage(arrays["joints"])}))
    with pytest.raises(InvalidFile, match=rf"human\.npz: .*joints.*{words}"):
        Retarget(motion=source, out=tmp_path / "robot.npz").run()
    assert [path.name for path in tmp_path.iterdir()] == ["human.npz"]


def test_a_disk_that_is_full_leaves_no_part_of_a_trajectory(tmp_path, motions, monkeypatch):
    source, out = tmp_path / "human.npz", tmp_path / "robot.npz"
    save_motion(source, motions["stand"])

    def full(stream, **_arrays):
        stream.write(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(np, "savez_compressed", full)
    with pytest.raises(InvalidFile, match=r"robot.*cannot be written: No space left"):
        Retarget(motion=source, out=out, balance=False, solver="frames").run()
    assert not out.exists() and not [path for path in tmp_path.iterdir() if path.name.startswith(".")]
