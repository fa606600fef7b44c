import pickle
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from ros_free_stack.errors import InvalidFile, InvalidOption, ModelMismatch, UnknownName
from ros_free_stack.formats import gmr, mjlab, phc, robot_csv
from ros_free_stack.formats.robot_places import configurations
from ros_free_stack.formats.robot_resample import resample_trajectory
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.messages import HumanMotion, RobotTrajectory
from ros_free_stack.robot_model import kinematic_model, standing_qpos
from ros_free_stack.robots import load_robot

OP3 = SourceOptions(robot="op3")
WRITERS = {"xyzw": robot_csv.write_unitree, "wxyz": robot_csv.write_kimodo}
READERS = {"xyzw": robot_csv.read_unitree, "wxyz": robot_csv.read_kimodo}


def content(source) -> RobotTrajectory:
    assert isinstance(source.content, RobotTrajectory)
    return source.content


def assert_same_motion(first: RobotTrajectory, second: RobotTrajectory, atol: float) -> None:
    assert (first.robot, first.joint_names, first.model_sha256) == (
        second.robot,
        second.joint_names,
        second.model_sha256,
    )
    assert first.fps == second.fps
    for name in ("root_pos", "root_quat", "joint_pos"):
        np.testing.assert_allclose(getattr(first, name), getattr(second, name), atol=atol)


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_csv_round_trip(tmp_path: Path, trajectory, order: str) -> None:
    before = trajectory()
    assert WRITERS[order](tmp_path / "a.csv", before) == (f"quaternions {order}",)
    rows = np.loadtxt(tmp_path / "a.csv", delimiter=",")
    assert rows.shape == (31, 7 + len(before.joint_names))
    np.testing.assert_allclose(rows[:, 3 + order.index("w")], before.root_quat[:, 0], atol=1e-8)
    np.testing.assert_allclose(rows[:, 3 + order.index("x")], before.root_quat[:, 1], atol=1e-8)
    source = READERS[order](tmp_path / "a.csv", OP3)
    assert source.notes[0] == "csv states no frame rate: 30 assumed (--source-fps)"
    assert_same_motion(content(source), before, atol=1e-8)


@settings(max_examples=20, deadline=None)
@given(st.lists(st.floats(-1, 1), min_size=4, max_size=4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_read_in_the_wrong_order_a_rotation_is_another_one(tmp_path_factory, trajectory, quaternion) -> None:
    path = tmp_path_factory.mktemp("csv") / "a.csv"
    unit = np.array(quaternion) / np.linalg.norm(quaternion)
    before = replace(trajectory(frames=1), root_quat=unit[None])
    robot_csv.write_unitree(path, before)
    np.testing.assert_allclose(content(robot_csv.read_unitree(path, OP3)).root_quat[0], unit, atol=1e-7)
    np.testing.assert_allclose(content(robot_csv.read_kimodo(path, OP3)).root_quat[0], np.roll(unit, -1), atol=1e-7)
    with pytest.raises(InvalidOption, match="--quaternion: this format's order is xyzw, found wxyz"):
        robot_csv.read_unitree(path, SourceOptions(robot="op3", quaternion="wxyz"))


def test_csv_is_written_at_30_fps_and_says_so(tmp_path: Path, trajectory) -> None:
    before = trajectory(frames=51, fps=50.0)
    notes = robot_csv.write_unitree(tmp_path / "a.csv", before)
    assert notes[1] == "resampled from 50 to 30 fps, linearly and by slerp"
    after = content(robot_csv.read_unitree(tmp_path / "a.csv", OP3))
    assert len(after.joint_pos) == 31
    np.testing.assert_allclose(after.joint_pos[[0, 15, 30]], before.joint_pos[[0, 25, 50]], atol=1e-8)


def test_resampling_is_linear_and_by_slerp(trajectory) -> None:
    before = trajectory(frames=11, fps=20.0)
    after = resample_trajectory(before, 50.0)
    assert len(after.joint_pos) == 26
    at, grid = np.arange(26) / 50, np.arange(11) / 20
    np.testing.assert_allclose(after.joint_pos[:, 3], np.interp(at, grid, before.joint_pos[:, 3]), atol=1e-12)
    slerp = Slerp(grid, Rotation.from_quat(before.root_quat, scalar_first=True))
    turned = Rotation.from_quat(after.root_quat, scalar_first=True) * slerp(at).inv()
    assert turned.magnitude().max() < 1e-7
    assert resample_trajectory(trajectory(frames=1), 50.0).fps == 50


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda lines: [], "no frames"),
        (lambda lines: [*lines[:2], lines[2][:40]], r"line 3: expected 27 numbers, found \d+ \(truncated"),
        (
            lambda lines: [line + ",0.0" for line in lines],
            r"joints: expected \(T, 20\) for .*OP3, found \(3, 21\)",
        ),
        (lambda lines: [",".join(line.split(",")[:5]) for line in lines], r"root rotation: expected \(T, 4\)"),
        (
            lambda lines: ["x,y,z", *lines],
            r"line 2: expected 3 numbers, found 27 \(truncated\?\)",
        ),
        (lambda lines: [lines[0], "nan" + lines[1][lines[1].index(",") :]], "line 2: a value that is not finite"),
        (lambda lines: ["0,0,0,2,0,0,0" + ",0" * 20], "frame 0: a root quaternion of length 2, expected 1"),
    ],
)
def test_csv_errors_name_the_line(tmp_path: Path, trajectory, change, message: str) -> None:
    path = tmp_path / "a.csv"
    robot_csv.write_unitree(path, trajectory(frames=3))
    path.write_text("\n".join(change(path.read_text().splitlines())))
    with pytest.raises(InvalidFile, match=message):
        robot_csv.read_unitree(path, OP3)


def test_a_robot_has_to_be_named(tmp_path: Path, trajectory) -> None:
    robot_csv.write_unitree(tmp_path / "a.csv", trajectory())
    with pytest.raises(InvalidOption, match="--robot: name the robot of"):
        robot_csv.read_unitree(tmp_path / "a.csv", SourceOptions())
    with pytest.raises(UnknownName, match="r2d2"):
        robot_csv.read_unitree(tmp_path / "a.csv", SourceOptions(robot="r2d2"))
    (tmp_path / "a.csv").write_bytes(b"\xff\x00\x80")
    with pytest.raises(InvalidFile, match="is not text"):
        robot_csv.read_unitree(tmp_path / "a.csv", OP3)


def test_gmr_reads_and_its_own_loader_would_too(tmp_path: Path, trajectory) -> None:
    before = trajectory("g1", fps=50.0)
    gmr.write(tmp_path / "a.pkl", before)
    assert_same_motion(content(gmr.read(tmp_path / "a.pkl", SourceOptions(robot="g1"))), before, atol=1e-12)
    raw = pickle.loads((tmp_path / "a.pkl").read_bytes())  # what GMR's load_robot_motion takes from it
    assert raw["fps"] == 50
    np.testing.assert_array_equal(raw["root_rot"][:, [3, 0, 1, 2]], before.root_quat)
    np.testing.assert_array_equal(raw["root_pos"], before.root_pos)
    np.testing.assert_array_equal(raw["dof_pos"], before.joint_pos)
    assert {"local_body_pos", "link_body_list"} <= raw.keys()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"root_rot": None}, r"root_rot is no array|root rotation: expected"),
        ({"dof_pos": np.zeros((31, 7))}, r"joints: expected \(T, 20\) for ROBOTIS OP3, found \(31, 7\)"),
        ({"root_pos": np.full((31, 3), np.inf)}, "root position: a value that is not finite at frame 0"),
        ({"fps": [30, 30]}, r"fps is \[30, 30\], expected a number"),
        ({"root_pos": np.zeros((0, 3)), "root_rot": np.zeros((0, 4)), "dof_pos": np.zeros((0, 20))}, r"found \(0, 3\)"),
    ],
)
def test_gmr_errors(tmp_path: Path, trajectory, changes: dict, message: str) -> None:
    gmr.write(tmp_path / "a.pkl", trajectory())
    data = pickle.loads((tmp_path / "a.pkl").read_bytes()) | changes
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(data))
    with pytest.raises(InvalidFile, match=message):
        gmr.read(tmp_path / "a.pkl", OP3)
    (tmp_path / "a.pkl").write_bytes(pickle.dumps([1]))
    with pytest.raises(InvalidFile, match="not a GMR motion"):
        gmr.read(tmp_path / "a.pkl", OP3)


def phc_file(path: Path, **clips: dict) -> Path:
    path.write_bytes(pickle.dumps(clips))
    return path


def test_phc_clips_of_a_robot(tmp_path: Path, trajectory) -> None:
    before = trajectory()
    clip = {
        "root_trans_offset": before.root_pos,
        "root_rot": before.root_quat[:, [1, 2, 3, 0]],
        "dof": before.joint_pos,
        "pose_aa": np.zeros((31, 22, 3)),
        "fps": 30,
    }
    one = phc_file(tmp_path / "one.pkl", walk=clip)
    assert_same_motion(content(phc.read(one, OP3)), before, atol=1e-12)
    two = phc_file(tmp_path / "two.pkl", walk=clip, run=clip | {"dof": before.joint_pos[..., None]})
    with pytest.raises(InvalidOption, match=r"--clip: name one of the 2 clips .*: walk, run"):
        phc.read(two, OP3)
    with pytest.raises(UnknownName, match="'jump'; valid: run, walk"):
        phc.read(two, replace(OP3, clip="jump"))
    assert_same_motion(content(phc.read(two, replace(OP3, clip="run"))), before, atol=1e-12)
    with pytest.raises(InvalidFile, match="has no root_rot"):
        phc.read(phc_file(tmp_path / "a.pkl", walk={"dof": 0, "root_trans_offset": 0, "fps": 30}), OP3)
    with pytest.raises(InvalidOption, match="--source-fps"):
        phc.read(phc_file(tmp_path / "a.pkl", walk={key: clip[key] for key in clip if key != "fps"}), OP3)
    with pytest.raises(InvalidFile, match="no clips"):
        phc.read(phc_file(tmp_path / "a.pkl", walk={"fps": 30}), OP3)


def test_phc_clips_of_a_human(tmp_path: Path, rest) -> None:
    import json

    from ros_free_stack.skeleton import JOINT_NAMES

    skeleton = tmp_path / "rest.json"
    skeleton.write_text(json.dumps(dict(zip(JOINT_NAMES, rest.tolist(), strict=True))))
    poses = np.zeros((4, 72))
    poses[:, :3] = Rotation.from_euler("xz", [90, 90], degrees=True).as_rotvec()
    clip = {"pose_aa": poses, "trans_orig": np.zeros((4, 3)), "beta": np.zeros(16), "gender": "neutral", "fps": 30}
    path = phc_file(tmp_path / "a.pkl", walk=clip)
    motion = phc.read(path, SourceOptions(skeleton=skeleton)).content
    assert isinstance(motion, HumanMotion)
    assert motion.joints[0, 15, 2] == pytest.approx(1.555 - 0.02, abs=1e-9)
    with pytest.raises(InvalidOption, match="--skeleton"):
        phc.read(path, SourceOptions())
    bad = phc_file(tmp_path / "b.pkl", walk=clip | {"trans_orig": np.zeros((3, 3))})
    with pytest.raises(InvalidFile, match=r"trans_orig: expected \(4, 3\), a row for each pose, found \(3, 3\)"):
        phc.read(bad, SourceOptions(skeleton=skeleton))


def test_feet_that_rest_on_the_floor_are_contacts(tmp_path: Path, trajectory) -> None:
    robot = load_robot("op3")
    model = kinematic_model(robot)
    qpos = np.repeat(standing_qpos(model, robot)[None], 30, axis=0)
    qpos[15:, 2] += 0.1
    still = replace(
        trajectory(frames=30),
        root_pos=qpos[:, :3],
        root_quat=qpos[:, 3:7],
        joint_pos=np.tile(robot.standing_pos, (30, 1)),
    )
    gmr.write(tmp_path / "a.pkl", still)
    contacts = content(gmr.read(tmp_path / "a.pkl", OP3)).contacts
    assert contacts[:14].all()
    assert not contacts[15:].any()


def test_mjlab_velocities_are_those_of_the_moving_bodies(tmp_path: Path, trajectory) -> None:
    before = trajectory("g1", frames=61, fps=200.0)
    mjlab.write(tmp_path / "a.npz", before)
    with np.load(tmp_path / "a.npz", allow_pickle=False) as archive:
        data = {name: archive[name].astype(np.float64) for name in archive.files}
    robot = load_robot("g1")
    model = kinematic_model(robot)
    bodies = model.nbody - 1
    assert set(data) == {
        "fps", "joint_pos", "joint_vel", "body_pos_w", "body_quat_w", "body_lin_vel_w", "body_ang_vel_w",
    }  # fmt: skip
    assert data["fps"].tolist() == [200.0]
    assert data["body_quat_w"].shape == (61, bodies, 4)
    np.testing.assert_allclose(data["joint_pos"], before.joint_pos, atol=1e-6)
    np.testing.assert_allclose(data["body_pos_w"][:, 0], before.root_pos, atol=1e-6)
    np.testing.assert_allclose(data["body_quat_w"][:, 0], before.root_quat, atol=1e-6)
    middle = slice(1, -1)
    joint_vel = np.gradient(before.joint_pos, axis=0) * 200
    np.testing.assert_allclose(data["joint_vel"], joint_vel, atol=1e-4)
    linear = np.gradient(data["body_pos_w"], axis=0) * 200
    np.testing.assert_allclose(data["body_lin_vel_w"][middle], linear[middle], atol=5e-3)
    turns = Rotation.from_quat(data["body_quat_w"].reshape(-1, 4), scalar_first=True).as_matrix()
    turns = turns.reshape(61, bodies, 3, 3)
    steps = Rotation.from_matrix((turns[2:] @ turns[:-2].swapaxes(-1, -2)).reshape(-1, 3, 3))
    angular = steps.as_rotvec().reshape(59, bodies, 3) * 100
    np.testing.assert_allclose(data["body_ang_vel_w"][middle], angular, atol=5e-3)


def test_mjlab_refuses_what_has_no_velocity_or_another_model(tmp_path: Path, trajectory) -> None:
    with pytest.raises(InvalidFile, match="one frame has no velocities"):
        mjlab.write(tmp_path / "a.npz", trajectory(frames=1))
    with pytest.raises(ModelMismatch, match="another model of op3"):
        mjlab.write(tmp_path / "a.npz", replace(trajectory(), model_sha256="0" * 64))
    assert not list(tmp_path.iterdir())


def test_configurations_put_coupled_joints_where_they_belong(trajectory) -> None:
    before = trajectory(frames=3)
    robot = load_robot("op3")
    model = kinematic_model(robot)
    qpos = configurations(model, robot, before.root_pos, before.root_quat, before.joint_pos)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos[2]
    mujoco.mj_kinematics(model, data)
    np.testing.assert_allclose(data.body(robot.root_body).xpos, before.root_pos[2])
    np.testing.assert_allclose([data.joint(name).qpos[0] for name in robot.joint_names], before.joint_pos[2])
