"""Native files: exact round trips, one clear error for anything else, nothing half-written."""

import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import (
    atomic_path,
    load_motion,
    load_telemetry,
    load_trajectory,
    load_verdict,
    make_folder,
    save_motion,
    save_telemetry,
    save_trajectory,
    save_trajectory_csv,
    save_verdict,
    write_text,
)
from ros_free_stack.messages import Check, HumanMotion, RobotTrajectory, Segment, ServoTelemetry, Verdict


def make_trajectory(joint_pos: np.ndarray) -> RobotTrajectory:
    frames = len(joint_pos)
    return RobotTrajectory(
        robot="op3",
        model_sha256="ab" * 32,
        joint_names=tuple(f"joint_{i}" for i in range(joint_pos.shape[1])),
        fps=50.0,
        root_pos=np.zeros((frames, 3)),
        root_quat=np.tile([1.0, 0, 0, 0], (frames, 1)),
        joint_pos=joint_pos,
        contacts=np.ones((frames, 2), bool),
        foot_names=("left", "right"),
    )


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None)
@given(joints=arrays(np.float64, (3, 22, 3), elements=st.floats(-5, 5)), prompt=st.text(max_size=20))
def test_motion_round_trip(tmp_path: Path, joints, prompt):
    prompt = prompt.replace("\0", "")
    motion = HumanMotion(joints=joints, fps=20, prompt=prompt, segments=(Segment("a person bows", 0, 0.15),))
    save_motion(tmp_path / "motion.npz", motion)
    back = load_motion(tmp_path / "motion.npz")
    assert np.array_equal(back.joints, motion.joints)
    assert (back.fps, back.prompt, back.segments) == (motion.fps, motion.prompt, motion.segments)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=25, deadline=None)
@given(joint_pos=arrays(np.float64, (4, 3), elements=st.floats(-3, 3)))
def test_trajectory_round_trip_keeps_the_digest(tmp_path: Path, joint_pos):
    trajectory = make_trajectory(joint_pos)
    save_trajectory(tmp_path / "t.npz", trajectory)
    assert load_trajectory(tmp_path / "t.npz").digest == trajectory.digest


def test_verdict_round_trip(tmp_path: Path):
    verdict = Verdict("op3", "a", "b", (Check("range", 0.1, "rad", 0.0, False, 3, "l_knee", "Beyond its range."),))
    save_verdict(tmp_path / "v.json", verdict)
    assert load_verdict(tmp_path / "v.json") == verdict


def test_csv_has_a_header_with_joint_names(tmp_path: Path):
    save_trajectory_csv(tmp_path / "t.csv", make_trajectory(np.ones((2, 2))))
    header, first, _ = (tmp_path / "t.csv").read_text().splitlines()
    assert header.split(",")[-2:] == ["joint_0", "joint_1"]
    assert [float(value) for value in first.split(",")[-2:]] == [1.0, 1.0]


@pytest.mark.parametrize("keep", [0, 10, 200])
def test_truncated_file_is_one_clear_error(tmp_path: Path, keep):
    path = tmp_path / "t.npz"
    save_trajectory(path, make_trajectory(np.ones((2, 2))))
    path.write_bytes(path.read_bytes()[:keep])
    with pytest.raises(InvalidFile, match=r"t\.npz"):
        load_trajectory(path)


def test_wrong_kind_and_missing_file_say_so(tmp_path: Path):
    save_motion(tmp_path / "m.npz", HumanMotion(joints=np.zeros((2, 22, 3)), fps=20))
    with pytest.raises(InvalidFile, match="human_motion"):
        load_trajectory(tmp_path / "m.npz")
    with pytest.raises(InvalidFile, match="no such file"):
        load_motion(tmp_path / "absent.npz")


def test_nan_in_a_file_is_refused(tmp_path: Path):
    path = tmp_path / "t.npz"
    save_trajectory(path, make_trajectory(np.ones((2, 2))))
    with np.load(path) as archive:
        data = dict(archive)
    data["joint_pos"] = np.full((2, 2), np.nan)
    np.savez(path, **data)
    with pytest.raises(InvalidFile, match="joint_pos"):
        load_trajectory(path)


def test_pickled_arrays_are_never_loaded(tmp_path: Path):
    path = tmp_path / "t.npz"
    np.savez(path, kind="robot_trajectory", version=1, joint_pos=np.array([{"evil": 1}], dtype=object))
    with pytest.raises(InvalidFile):
        load_trajectory(path)


def test_verdict_with_unknown_fields_is_refused(tmp_path: Path):
    path = tmp_path / "v.json"
    path.write_text('{"passed": true, "checks": [], "surprise": 1}')
    with pytest.raises(InvalidFile, match="not a verdict"):
        load_verdict(path)


def test_failed_write_leaves_nothing(tmp_path: Path):
    path = tmp_path / "out.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), atomic_path(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_disk_without_room_is_one_clear_error(tmp_path: Path):
    """A limit on the size of files stands for the end of the disk: the kernel refuses the write in the same way."""
    resource = pytest.importorskip("resource")
    path, before = tmp_path / "m.npz", resource.getrlimit(resource.RLIMIT_FSIZE)
    noise = np.random.default_rng(0).normal(size=(50, 22, 3))
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (4096, before[1]))
        with pytest.raises(InvalidFile, match=r"m\.npz: cannot be written: File too large"):
            save_motion(path, HumanMotion(joints=noise, fps=20))
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert not list(tmp_path.iterdir())


def test_other_faults_of_a_writer_stay_what_they_are(tmp_path: Path):
    with pytest.raises(FileNotFoundError), atomic_path(tmp_path / "out.txt") as temporary:
        temporary.write_bytes((tmp_path / "absent").read_bytes())
    assert not list(tmp_path.iterdir())


def test_a_folder_in_the_way_is_one_clear_error(tmp_path: Path):
    (tmp_path / "out.txt").mkdir()
    with pytest.raises(InvalidFile, match="cannot be written"):
        write_text(tmp_path / "out.txt", "text")


def test_unwritable_folder_is_one_clear_error(tmp_path: Path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(InvalidFile, match="not a writable folder"):
        make_folder(blocked / "sub")
    with pytest.raises(InvalidFile, match="cannot be written"):
        save_motion(tmp_path / "absent" / "m.npz", HumanMotion(joints=np.zeros((2, 22, 3)), fps=20))


@pytest.mark.parametrize("change", [{"physics": "false"}, {"mount": "sideways"}])
def test_a_verdict_with_words_for_truth_is_refused(tmp_path: Path, change: dict[str, str]):
    path = tmp_path / "verdict.json"
    save_verdict(path, Verdict("op3", "a", "b", (Check("joint_range", 0.0, "rad", 1.0, True),), physics=True))
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(InvalidFile, match=next(iter(change))):
        load_verdict(path)


def test_telemetry_round_trip(tmp_path: Path):
    rng = np.random.default_rng(0)
    columns = {name: rng.normal(size=(5, 2)) for name in ("goal", *ServoTelemetry.MEASURED)}
    fresh = rng.random((5, 2)) < 0.5
    telemetry = ServoTelemetry("op3", ("a", "b"), np.arange(5) / 125, np.zeros(5), fresh=fresh, **columns)  # type: ignore[arg-type]
    save_telemetry(tmp_path / "telemetry.npz", telemetry)
    back = load_telemetry(tmp_path / "telemetry.npz")
    for item in fields(ServoTelemetry):
        assert np.array_equal(getattr(back, item.name), getattr(telemetry, item.name)), item.name
    with pytest.raises(InvalidFile, match="robot_trajectory"):
        load_trajectory(tmp_path / "telemetry.npz")


def test_a_file_of_another_version_is_refused(tmp_path: Path):
    path = tmp_path / "t.npz"
    save_trajectory(path, make_trajectory(np.ones((2, 2))))
    with np.load(path) as archive:
        data = dict(archive)
    np.savez(path, **{**data, "version": np.array(int(data["version"]) + 1)})
    with pytest.raises(InvalidFile, match="version"):
        load_trajectory(path)


@pytest.mark.parametrize("passed", [True, False])
def test_a_verdict_whose_word_is_not_that_of_its_checks_is_refused(tmp_path: Path, passed):
    path = tmp_path / "v.json"
    save_verdict(path, Verdict("op3", "a", "b", (Check("range", 0.1, "rad", 0.0 if passed else 1.0, not passed),)))
    content = json.loads(path.read_text())
    assert content["passed"] is not passed
    path.write_text(json.dumps({**content, "passed": passed}))
    with pytest.raises(InvalidFile, match="passed"):
        load_verdict(path)
