"""Robot trajectories by names: tables and arrays, their units, orders and rates; jumps and the floor."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import save_trajectory_csv
from ros_free_stack.formats.registry import load
from ros_free_stack.formats.robot_names import understand_column
from ros_free_stack.messages import RobotTrajectory
from tests.ros_free_stack.robot_files import G1, ROOT, assert_same, read, values, write_csv


def test_columns_are_found_by_name_in_any_order(tmp_path: Path, before) -> None:
    columns = values(before)
    shuffled = {name: columns[name] for name in np.random.default_rng(3).permutation(list(columns))}
    for separator in (",", ";", "\t"):
        path = write_csv(tmp_path / "a.csv", {"time": np.arange(31) / 50} | shuffled, separator)
        assert_same(read(path), before)
    save_trajectory_csv(tmp_path / "own.csv", before)  # what `retarget` leaves beside its trajectory
    assert_same(read(tmp_path / "own.csv"), before)


@pytest.mark.parametrize(
    "rename",
    [
        lambda name: f"{name}_dof" if name not in ROOT else f"root_{name}",
        lambda name: name.removesuffix("_joint") if name not in ROOT else f"root_pos_{name}" if len(name) < 2 else name,
        lambda name: name.upper() if name not in ROOT else name,
        lambda name: (
            f"joint_{name}_pos" if name not in ROOT else f"base_quat_{name[1]}" if len(name) > 1 else f"base_{name}"
        ),
        lambda name: f"{name} (rad)" if name not in ROOT else f"{name}_m" if len(name) < 2 else name,
        lambda name: f"# {name}" if name == "x" else name,
    ],
)
def test_names_with_other_endings_are_the_same_joints(tmp_path: Path, before, rename) -> None:
    columns = {rename(name): column for name, column in values(before).items()}
    path = write_csv(tmp_path / "a.csv", columns | {"left_knee_vel": np.zeros(31)})
    source = load(path, replace(G1, source_fps=50))
    assert isinstance(source.content, RobotTrajectory)
    assert_same(source.content, before)
    assert any("columns left out: left_knee_vel" in note for note in source.notes)


def test_a_named_order_needs_no_word_and_bears_no_other(tmp_path: Path, before) -> None:
    path = write_csv(tmp_path / "a.csv", values(before))
    assert_same(read(path, replace(G1, quaternion="wxyz", source_fps=50)), before)
    with pytest.raises(InvalidOption, match=r"--quaternion: the columns of .* name the order wxyz, found xyzw"):
        load(path, replace(G1, quaternion="xyzw"))
    qpos = np.concatenate([before.root_pos, before.root_quat[:, [1, 2, 3, 0]], before.joint_pos], axis=1)
    np.savez(tmp_path / "a.npz", qpos=qpos, fps=50)
    assert_same(read(tmp_path / "a.npz", replace(G1, quaternion="xyzw")), before)


def test_seed_tables_are_in_centimetres_and_degrees(tmp_path: Path, before) -> None:
    turns = Rotation.from_quat(before.root_quat, scalar_first=True).as_euler("xyz", degrees=True)
    columns = {"Frame": np.arange(31.0)}
    columns |= {f"root_translate{axis}": 100 * before.root_pos[:, i] for i, axis in enumerate("XYZ")}
    columns |= {f"root_rotate{axis}": turns[:, i] for i, axis in enumerate("XYZ")}
    columns |= {f"{name}_dof": np.rad2deg(before.joint_pos[:, i]) for i, name in enumerate(before.joint_names)}
    source = load(write_csv(tmp_path / "a.csv", columns), G1)
    assert isinstance(source.content, RobotTrajectory)
    assert_same(source.content, before, fps=120)
    assert "columns of BONES-SEED: centimetres and degrees" in source.notes
    assert "csv states no frame rate: 120 assumed (--source-fps)" in source.notes


def test_units_are_named_or_asked_for(tmp_path: Path, before) -> None:
    columns = values(before)
    degrees = {name: column if name in ROOT else np.rad2deg(column) for name, column in columns.items()}
    path = write_csv(tmp_path / "a.csv", degrees)
    with pytest.raises(InvalidOption, match=r"--angles: name the unit of angles in .* its range is .* rad"):
        load(path, G1)
    assert_same(read(path, replace(G1, angles="deg", source_fps=50)), before)
    with pytest.raises(InvalidOption, match="--angles"):
        load(write_csv(tmp_path / "b.csv", {f"{n}_rad" if n == "qw" else n: c for n, c in degrees.items()}), G1)
    named = {f"{name}_deg" if name not in ROOT else name: column for name, column in degrees.items()}
    assert_same(read(write_csv(tmp_path / "c.csv", named), replace(G1, source_fps=50)), before)
    far = {name: 100 * column if name in "xyz" else column for name, column in columns.items()}
    path = write_csv(tmp_path / "d.csv", far)
    with pytest.raises(
        InvalidOption, match=r"--units: name the unit of lengths in .*: the root is 4\d(\.\d)? high, 0.77 m when"
    ):
        load(path, G1)
    assert_same(read(path, replace(G1, units="cm", source_fps=50)), before)
    rpy = {name: column for name, column in columns.items() if not name.startswith("q")}
    turns = Rotation.from_quat(before.root_quat, scalar_first=True).as_euler("xyz", degrees=True)
    rpy |= {name: 100 * turns[:, i] for i, name in enumerate(("roll", "pitch", "yaw"))}
    with pytest.raises(InvalidOption, match=r"--angles: .* the root turns by"):
        load(write_csv(tmp_path / "e.csv", rpy), G1)


def test_times_give_the_rate_or_are_refused(tmp_path: Path, before) -> None:
    columns = values(before)
    assert_same(read(write_csv(tmp_path / "a.csv", {"time_ms": 20.0 * np.arange(31)} | columns)), before)
    with pytest.raises(
        InvalidOption, match=r"--source-fps: .* states 0.05 frames a second, 20 s each \(perhaps 20 or 50"
    ):
        load(write_csv(tmp_path / "a.csv", {"time": 20.0 * np.arange(31)} | columns), G1)
    late = np.arange(31) / 50
    late[20:] += 0.5
    with pytest.raises(InvalidFile, match=r"times do not rise evenly: 0\.38 is followed by 0\.9"):
        load(write_csv(tmp_path / "a.csv", {"t": late} | columns), G1)
    bare = np.stack(list(columns.values()), axis=1)
    np.savetxt(tmp_path / "b.csv", np.column_stack([np.arange(31) / 50, bare]), delimiter=",")
    source = load(tmp_path / "b.csv", replace(G1, quaternion="wxyz"))
    assert isinstance(source.content, RobotTrajectory)
    assert_same(source.content, before)
    assert source.notes[0] == "the first column is taken for times in s"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda c: {n: v for n, v in c.items() if n != "left_knee_joint"},
            "has no joint left_knee_joint of Unitree G1",
        ),
        (lambda c: c | {"left_knee_joint_pos": c["x"], "left_knee": c["x"], "left_knee_joint": c["x"]}, ""),
        (
            lambda c: {n: v for n, v in c.items() if n != "qw"},
            "one column for w of the root's quaternion, there is none",
        ),
        (lambda c: c | {"root_x": c["x"]}, "one column for x of the root's position, there are x, root_x"),
        (lambda c: {n: v * 2 if n == "qw" else v for n, v in c.items()}, "a root quaternion of length"),
    ],
)
def test_faults_of_tables_are_named(tmp_path: Path, before, change, message: str) -> None:
    path = write_csv(tmp_path / "a.csv", change(values(before)))
    if not message:
        assert_same(read(path, replace(G1, source_fps=50)), replace(before), atol=10)
        return
    with pytest.raises(InvalidFile, match=message):
        load(path, G1)


def test_words_of_columns() -> None:
    said = {
        name: understand_column(name)
        for name in ("root_translateX", "Pelvis_qw", "base_pos_z (cm)", "time [ms]", "knee")
    }
    assert [(column.part, column.axis, column.unit) for column in said.values()] == [
        ("position", "x", ""),
        ("quaternion", "w", ""),
        ("position", "z", "cm"),
        ("time", "", "ms"),
        ("joint", "", ""),
    ]
    assert understand_column("head_yaw", ("head_yaw",)).part == "joint"
    assert understand_column("body_yaw", ("body_yaw",)).part == "joint"


# --- arrays ---
