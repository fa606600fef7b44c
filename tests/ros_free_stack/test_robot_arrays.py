"""Arrays and pickles of robot trajectories as their programs save them; floors, jumps and parts."""

import pickle
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import launch
from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.files import load_trajectory, save_trajectory, save_trajectory_csv
from ros_free_stack.formats import mjlab
from ros_free_stack.formats.registry import load
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robot_model import kinematic_model, sole_corners, standing_qpos
from ros_free_stack.robots import load_robot
from tests.ros_free_stack.robot_files import G1, assert_same, read


def test_what_mjlab_writes_is_read(tmp_path: Path, before) -> None:
    mjlab.write(tmp_path / "a.npz", before)
    source = load(tmp_path / "a.npz", G1)
    assert isinstance(source.content, RobotTrajectory)
    assert_same(source.content, before)
    assert "the file names no joints: they are taken in the order of the robot's model" in source.notes
    assert launch.main(["convert", str(tmp_path / "a.npz"), str(tmp_path / "b.npz"), "--robot", "g1"]) == 0
    assert_same(load_trajectory(tmp_path / "b.npz"), before)


def test_joints_in_isaacs_order_are_known_by_the_bodies(tmp_path: Path, before) -> None:
    robot = load_robot("g1")
    model = kinematic_model(robot)
    mjlab.write(tmp_path / "a.npz", before)
    arrays = dict(np.load(tmp_path / "a.npz"))
    depth = [0] * model.nbody
    for body in range(1, model.nbody):
        depth[body] = depth[int(model.body_parentid[body])] + 1
    bodies = sorted(range(1, model.nbody), key=lambda body: (depth[body], body))
    of_joint = [int(model.joint(name).bodyid[0]) for name in robot.joint_names]
    joints = sorted(range(len(of_joint)), key=lambda joint: bodies.index(of_joint[joint]))
    for name in arrays:
        if name.startswith("body"):
            arrays[name] = arrays[name][:, [body - 1 for body in bodies]]
        elif name.startswith("joint"):
            arrays[name] = arrays[name][:, joints]
    np.savez(tmp_path / "b.npz", **arrays)
    source = load(tmp_path / "b.npz", G1)
    assert isinstance(source.content, RobotTrajectory)
    assert_same(source.content, before)
    assert "the bodies show that joints come breadth first, as Isaac has them" in source.notes
    names = [robot.joint_names[joint] for joint in joints]
    np.savez(tmp_path / "c.npz", joint_names=np.array(names), **{k: v for k, v in arrays.items() if k != "body_pos_w"},
             body_pos_w=arrays["body_pos_w"][:, :1].repeat(len(bodies), axis=1))  # fmt: skip
    assert_same(read(tmp_path / "c.npz"), before)


@pytest.mark.parametrize("suffix", [".npz", ".pkl"])
def test_qpos_by_names_or_in_the_models_order(tmp_path: Path, before, suffix: str) -> None:
    qpos = np.concatenate([before.root_pos, before.root_quat, before.joint_pos], axis=1)
    order = np.random.default_rng(1).permutation(len(before.joint_names))
    shuffled = np.concatenate([qpos[:, :7], qpos[:, 7:][:, order]], axis=1)
    names = ["root", *(before.joint_names[i] for i in order)]
    for arrays in (
        {"qpos": qpos, "fps": 50},
        {"qpos": shuffled, "joint_names": np.array(names), "frequency": 50.0},
        {"qpos": qpos[None], "dt": 0.02},
    ):
        path = tmp_path / f"a{suffix}"
        if suffix == ".npz":
            np.savez(path, **arrays)  # pyright: ignore[reportArgumentType]
        else:
            path.write_bytes(pickle.dumps(arrays))
        assert_same(read(path), before)
    box = np.tile([1.0, 0, 0.5, 1, 0, 0, 0], (31, 1))
    np.savez(tmp_path / "box.npz", qpos=np.concatenate([qpos, box], axis=1), fps=50)
    source = load(tmp_path / "box.npz", G1)
    assert isinstance(source.content, RobotTrajectory)
    assert_same(source.content, before)
    assert source.notes[0].startswith("the last 7 columns of qpos are an object's pose: left out")
    path = tmp_path / "b.npz"
    np.savez(path, qpos=np.concatenate([shuffled, shuffled]), joint_names=np.array(names), frequency=50.0,
             split_points=np.array([0, 31, 62]))  # fmt: skip
    with pytest.raises(InvalidOption, match=r"--clip: name one of the 2 clips .* by its number: 0 to 1"):
        load(path, G1)
    with pytest.raises(UnknownName, match="valid: 0, 1"):
        load(path, replace(G1, clip="2"))
    assert_same(read(path, replace(G1, clip="1")), before)


def test_the_order_of_quaternions_is_never_guessed(tmp_path: Path, before) -> None:
    parts = {"root_pos": before.root_pos, "dof_pos": before.joint_pos, "fps": 50}
    path = tmp_path / "a.npz"
    np.savez(path, root_rot=before.root_quat[:, [1, 2, 3, 0]], **parts)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidOption, match="--quaternion: name the order of root_rot in"):
        load(path, G1)
    assert_same(read(path, replace(G1, quaternion="xyzw")), before)
    np.savez(path, root_quat_wxyz=before.root_quat, **parts)  # pyright: ignore[reportArgumentType]
    assert_same(read(path), before)


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"qpos": np.zeros((3, 5))}, r"qpos: expected \(T, 7 \+ joints\)"),
        ({"qpos": np.zeros((3, 30)), "joint_names": np.array(["a"])}, "joint_names names 1 joints, there are 23"),
        ({"qpos": np.eye(30)[[3, 3, 3]]}, r"joints: expected \(T, 29\) for Unitree G1, found \(3, 23\)"),
        (
            {"joint_pos": np.zeros((3, 29)), "body_pos_w": np.zeros((3, 3)), "body_quat_w": np.zeros((3, 4))},
            "body_pos_w",
        ),
    ],
)
def test_faults_of_arrays_are_named(tmp_path: Path, arrays: dict, message: str) -> None:
    np.savez(tmp_path / "a.npz", fps=50, **arrays)
    with pytest.raises(InvalidFile, match=message):
        load(tmp_path / "a.npz", G1)


def test_mimickit_pickles(tmp_path: Path, before) -> None:
    turns = Rotation.from_quat(before.root_quat, scalar_first=True).as_rotvec()
    frames = np.concatenate([before.root_pos, turns, before.joint_pos], axis=1)
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps({"loop_mode": 0, "fps": 50, "frames": frames.tolist()}))
    assert_same(read(path), before)
    path.write_bytes(pickle.dumps({"loop_mode": 0, "fps": 50, "frames": frames[:, :20].tolist()}))
    with pytest.raises(InvalidFile, match=r"joints: expected \(T, 29\) for Unitree G1, found \(31, 14\)"):
        load(path, G1)


# --- the floor, jumps, parts ---


def standing(height: float, frames: int = 30) -> RobotTrajectory:
    """G1 standing so high over the floor."""
    robot = load_robot("g1")
    qpos = standing_qpos(kinematic_model(robot), robot)
    return RobotTrajectory(
        robot="g1",
        model_sha256=robot.sha256,
        joint_names=robot.joint_names,
        fps=30.0,
        root_pos=np.tile(qpos[:3] + np.array([0, 0, height]), (frames, 1)),
        root_quat=np.tile(qpos[3:7], (frames, 1)),
        joint_pos=np.tile(robot.standing_pos, (frames, 1)),
        contacts=np.ones((frames, len(robot.foot_names)), dtype=bool),
        foot_names=robot.foot_names,
    )


def lowest(trajectory: RobotTrajectory) -> float:
    robot = load_robot("g1")
    model = kinematic_model(robot)
    data = mujoco.MjData(model)
    data.qpos[:3], data.qpos[3:7] = trajectory.root_pos[0], trajectory.root_quat[0]
    for name, value in zip(trajectory.joint_names, trajectory.joint_pos[0], strict=True):
        data.joint(name).qpos[0] = value
    mujoco.mj_kinematics(model, data)
    return min(float(points[:, 2].min()) for points in sole_corners(model, data, robot).values())


@pytest.mark.parametrize("height", [0.02, -0.03, 0.3])
@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_a_robot_that_floats_is_told_and_put_down_on_request(
    tmp_path: Path, height: float, suffix: str, capsys
) -> None:
    path, out = tmp_path / f"a{suffix}", tmp_path / "out.npz"
    (save_trajectory_csv if suffix == ".csv" else save_trajectory)(path, standing(height))
    options = ["--robot", "g1"] if suffix == ".csv" else []
    assert launch.main(["convert", str(path), str(out), *options]) == 0
    assert lowest(load_trajectory(out)) == pytest.approx(height, abs=1e-6)
    where = "above" if height > 0 else "below"
    hint = f"the lowest sole is {100 * abs(height):.1f} cm {where} the floor: --floor puts it there"
    assert (hint in capsys.readouterr().err) == (suffix == ".csv")
    assert launch.main(["convert", str(path), str(out), "--floor", *options]) == 0
    assert lowest(load_trajectory(out)) == pytest.approx(0, abs=1e-6)
    assert load_trajectory(out).contacts.all()
    said = capsys.readouterr().err
    assert (
        f"{'lowered' if height > 0 else 'raised'} by {100 * abs(height):.1f} cm" in said and "puts it there" not in said
    )


def test_frames_before_a_jump_are_left_out_and_told(tmp_path: Path) -> None:
    motion = standing(0.0, frames=40)
    root = np.array(motion.root_pos)
    root[:, 0] += np.linspace(0, 0.5, 40)
    root[0] += (3, 0, 0)
    save_trajectory_csv(tmp_path / "a.csv", replace(motion, root_pos=root))
    source = load(tmp_path / "a.csv", G1)
    assert isinstance(source.content, RobotTrajectory)
    assert len(source.content.joint_pos) == 39
    assert "the first 1 frame is a pose that the motion jumps from or to: left out" in source.notes
    root[20:] += (1, 0, 0)
    save_trajectory_csv(tmp_path / "a.csv", replace(motion, root_pos=root))
    assert any("the motion jumps by 1.01 m at 0.6" in note for note in load(tmp_path / "a.csv", G1).notes)


def test_a_part_of_every_kind_of_file(tmp_path: Path, before, person) -> None:
    from ros_free_stack.files import save_motion
    from ros_free_stack.messages import HumanMotion, Segment

    save_trajectory(tmp_path / "a.npz", before)
    save_trajectory_csv(tmp_path / "a.csv", before)
    for path, options in ((tmp_path / "a.npz", SourceOptions()), (tmp_path / "a.csv", G1)):
        part = read(path, replace(options, start=0.2, end=0.4))
        np.testing.assert_allclose(part.joint_pos, before.joint_pos[10:21], atol=1e-6)
    motion = replace(person(40), segments=(Segment("walk", 0.0, 1.0), Segment("wave", 1.0, 1.9)))
    save_motion(tmp_path / "b.npz", motion)
    found = load(tmp_path / "b.npz", SourceOptions(start=0.5, end=1.5)).content
    assert isinstance(found, HumanMotion)
    np.testing.assert_allclose(found.joints, motion.joints[10:31])
    assert [(item.text, item.start_s, item.end_s) for item in found.segments] == [
        ("walk", 0.0, 0.5),
        ("wave", 0.5, 1.0),
    ]
    with pytest.raises(InvalidOption, match=r"--start: .* ends at 1.95 s, found 3"):
        load(tmp_path / "b.npz", SourceOptions(start=3))
    with pytest.raises(InvalidOption, match="--floor: is for robot trajectories"):
        load(tmp_path / "b.npz", SourceOptions(floor=True))
