import errno
import json
from dataclasses import replace

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


def test_a_part_of_a_file_at_its_own_pace(tmp_path, motions, capsys):
    steps = motions["steps"]
    save_motion(tmp_path / "human.npz", replace(steps, joints=steps.joints[::2]))
    given = {"motion": tmp_path / "human.npz", "balance": False, "solver": "frames"}
    assert Retarget(out=tmp_path / "slow.npz", end=1.5, **given).run() == 0
    assert "pace: 1.5 s of the person take the robot" in capsys.readouterr().err
    assert Retarget(out=tmp_path / "kept.npz", start=0.5, end=1.5, keep_timing=True, **given).run() == 0
    assert "pace:" not in capsys.readouterr().err
    assert load_trajectory(tmp_path / "kept.npz").duration_s == pytest.approx(2.8, abs=0.05)
    with pytest.raises(InvalidOption, match=r"--start: .* ends at"):
        Retarget(out=tmp_path / "a.npz", start=99.0, **given).run()


def test_time_left_is_said_every_few_seconds(monkeypatch, capsys):
    from ros_free_stack import console

    now = iter([0.0, 3.0, 6.0, 7.0, 100.0, 101.0])
    monkeypatch.setattr(console, "perf_counter", lambda: next(now))
    tell = console.time_left("retarget")
    for share in (0.1, 0.2, 0.3, 0.5, 1.0):
        tell(share)
    assert capsys.readouterr().err.splitlines() == [
        "retarget: 20 % done, about 24 s left",
        "retarget: 50 % done, about 1 min 40 s left",
    ]


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
