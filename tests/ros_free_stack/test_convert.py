import json
import os
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import launch
from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.files import load_motion, load_trajectory, save_motion, save_trajectory
from ros_free_stack.formats import gmr, robot_csv
from ros_free_stack.formats.catalogue import FORMATS, READABLE, WRITABLE
from ros_free_stack.formats.features import encode
from ros_free_stack.formats.frames import stand, to_y_up
from ros_free_stack.formats.registry import load, load_human, save
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.messages import HumanMotion, RobotTrajectory

NO_OPTIONS = SourceOptions()


@pytest.fixture
def human(tmp_path: Path, person) -> Path:
    save_motion(tmp_path / "human.npz", person(20))
    return tmp_path / "human.npz"


@pytest.fixture
def robot(tmp_path: Path, trajectory) -> Path:
    save_trajectory(tmp_path / "robot.npz", trajectory(frames=31, fps=30.0))
    return tmp_path / "robot.npz"


def test_every_format_names_functions_that_exist() -> None:
    from ros_free_stack.formats.registry import _function

    for item in FORMATS.values():
        for name in filter(None, (item.read, item.write)):
            assert callable(_function(name))
        assert set(item.options) <= set(vars(NO_OPTIONS))
    assert set(READABLE) | set(WRITABLE) == set(FORMATS)


def test_human_motion_there_and_back(tmp_path: Path, human: Path, capsys) -> None:
    assert launch.main(["convert", str(human), str(tmp_path / "a.bvh")]) == 0
    assert launch.main(["convert", str(tmp_path / "a.bvh"), str(tmp_path / "new" / "b.npz"), "--json"]) == 0
    result = json.loads(capsys.readouterr().out.partition("\n")[2])
    assert (result["format"], result["kind"]) == ("native", "human motion")
    np.testing.assert_allclose(load_motion(tmp_path / "new" / "b.npz").joints, load_motion(human).joints, atol=1e-3)


@pytest.mark.parametrize("suffix", [".csv", ".pkl"])
def test_robot_trajectory_there_and_back(tmp_path: Path, robot: Path, suffix: str, capsys) -> None:
    between = str(tmp_path / f"a{suffix}")
    assert launch.main(["convert", str(robot), between]) == 0
    options = ["--quaternion", "xyzw"] if suffix == ".csv" else []
    assert launch.main(["convert", between, str(tmp_path / "b.npz"), "--robot", "op3", *options]) == 0
    before, after = load_trajectory(robot), load_trajectory(tmp_path / "b.npz")
    np.testing.assert_allclose(after.joint_pos, before.joint_pos, atol=1e-8)
    np.testing.assert_allclose(after.root_quat, before.root_quat, atol=1e-8)


def test_another_frame_rate_is_said(tmp_path: Path, human: Path, robot: Path, capsys) -> None:
    assert launch.main(["convert", str(human), str(tmp_path / "a.npz"), "--fps", "50"]) == 0
    assert "resampled from 20 to 50 fps" in capsys.readouterr().err
    before, after = load_motion(human), load_motion(tmp_path / "a.npz")
    assert (after.fps, len(after.joints)) == (50, 48)
    np.testing.assert_allclose(after.joints[5], before.joints[2], atol=1e-9)
    assert launch.main(["convert", str(robot), str(tmp_path / "b.npz"), "--to", "mjlab", "--fps", "50"]) == 0
    with np.load(tmp_path / "b.npz") as archive:
        assert archive["fps"].tolist() == [50.0]
        assert archive["joint_pos"].shape == (51, 20)


def test_formats_are_recognised_by_suffix_and_content(tmp_path: Path, person, trajectory) -> None:
    motion = person(60)
    np.save(tmp_path / "joints.npy", to_y_up(motion.joints).astype(np.float32))
    np.save(tmp_path / "features.npy", encode(motion.joints).astype(np.float32))
    for name, atol in (("joints", 1e-6), ("features", 1e-4)):
        read, notes = load_human(tmp_path / f"{name}.npy", NO_OPTIONS)
        assert read.fps == 20
        assert notes == (f"HumanML3D {name[:-1]} files state no frame rate: 20 assumed (--source-fps)",)
        np.testing.assert_allclose(stand(read.joints), stand(motion.joints[: len(read.joints)]), atol=atol)
    gmr.write(tmp_path / "gmr.pkl", trajectory())
    robot_csv.write_kimodo(tmp_path / "a.csv", trajectory())
    wxyz = SourceOptions(robot="op3", quaternion="wxyz")
    for path, options in ((tmp_path / "gmr.pkl", SourceOptions(robot="op3")), (tmp_path / "a.csv", wxyz)):
        content = load(path, options).content
        assert isinstance(content, RobotTrajectory)
        np.testing.assert_allclose(content.root_quat, trajectory().root_quat, atol=1e-8)
    (tmp_path / "renamed.xyz").write_bytes((tmp_path / "joints.npy").read_bytes())
    assert isinstance(load(tmp_path / "renamed.xyz", NO_OPTIONS, "humanml3d-joints").content, HumanMotion)


@pytest.mark.parametrize(
    ("name", "data", "message"),
    [
        ("a.xyz", b"", "of no known format .*asf-amc.*unitree-csv"),
        ("a.fbx", b"", r"\.fbx files are not read: export BVH"),
        ("a.pt", b"", r"\.pt files are not read: save its arrays with numpy"),
        ("a.c3d", b"", "they hold markers, not joints"),
        ("a.asf", b"", "it is a skeleton: name the .amc file"),
        ("a.npz", b"\x00\xff" * 30, "not a readable .npz"),
        ("a.npy", b"\x93NUMPY\x01\x00", "not a readable .npy"),
        ("a.npy", "array", r"joints of shape \(4, 17, 3\): these are joints of COCO .* expected \(T, 22, 3\)"),
        ("a.npz", "archive", r"of no known format \(holds x\)"),
        ("a.pkl", pickle.dumps({"a": 1}), r"of no known format \(a pickle of a\)"),
        ("a.pkl", b"\x80\x05garbage", "not a readable pickle"),
        ("a.txt", b"hello", r"of no known format \(no JSON object with 'Frames'\)"),
        ("a.txt", b"[1]", r"of no known format \(no JSON"),
        ("a.bvh", bytes(range(256)), "no line 'MOTION'"),
    ],
)
def test_what_is_no_motion_file(tmp_path: Path, name: str, data: bytes | str, message: str) -> None:
    path = tmp_path / name
    if data == "array":
        np.save(path, np.zeros((4, 17, 3)))
    elif data == "archive":
        np.savez(path, x=np.zeros(3))
    else:
        path.write_bytes(data if isinstance(data, bytes) else b"")
    with pytest.raises(InvalidFile, match=f"(?s){message}"):
        load(path, NO_OPTIONS)


@pytest.mark.parametrize("format_name", READABLE)
@pytest.mark.parametrize("data", [b"", b"\x00\x01\xfe\xff" * 99], ids=["empty", "garbage"])
def test_every_reader_takes_rubbish_with_one_clear_error(tmp_path: Path, format_name: str, data: bytes) -> None:
    path = tmp_path / "rubbish"
    path.write_bytes(data)
    with pytest.raises((InvalidFile, InvalidOption), match="rubbish"):
        load(path, NO_OPTIONS, format_name)


@pytest.mark.parametrize(("shape", "name"), [((3, 22, 3), "joints"), ((3, 263), "features")])
def test_bad_values_in_arrays(tmp_path: Path, shape: tuple[int, ...], name: str) -> None:
    values = np.zeros(shape)
    values[1] = np.nan
    np.save(tmp_path / "a.npy", values)
    with pytest.raises(InvalidFile, match=r"not finite at (row|frame) 1"):
        load(tmp_path / "a.npy", NO_OPTIONS)
    np.save(tmp_path / "a.npy", values[:0])
    with pytest.raises(InvalidFile, match=r"expected floats of shape|joints of shape \(0, 22, 3\)"):
        load(tmp_path / "a.npy", NO_OPTIONS, f"humanml3d-{name}")


def test_arrays_in_another_unit_and_features_that_are_standardised(tmp_path: Path, person) -> None:
    motion = person(30)
    np.save(tmp_path / "millimetres.npy", 1000 * to_y_up(motion.joints))
    read, notes = load_human(tmp_path / "millimetres.npy", NO_OPTIONS)
    np.testing.assert_allclose(read.joints, stand(motion.joints), atol=1e-6)
    assert notes[-1] == "skeleton: HumanML3D joint; lengths in mm, y up"
    features = encode(motion.joints)
    np.save(tmp_path / "standardised.npy", (features - features.mean(axis=0)) / (features.std(axis=0) + 1e-9))
    with pytest.raises(InvalidFile, match="are the features standardised"):
        load(tmp_path / "standardised.npy", NO_OPTIONS)


def test_a_csv_does_not_tell_its_quaternions(tmp_path: Path, trajectory) -> None:
    robot_csv.write_unitree(tmp_path / "a.csv", trajectory())
    with pytest.raises(InvalidOption, match=r"--quaternion: name the order .* xyzw \(as Unitree .* wxyz \(Kimodo"):
        load(tmp_path / "a.csv", SourceOptions(robot="op3"))
    assert load(tmp_path / "a.csv", SourceOptions(robot="op3"), "unitree-csv").content.fps == 30


def test_own_files_with_a_rate_that_cannot_be_are_refused(tmp_path: Path, person, trajectory) -> None:
    save_motion(tmp_path / "a.npz", replace(person(5), fps=1 / 30))
    save_trajectory(tmp_path / "b.npz", replace(trajectory(), fps=1e5))
    for name in ("a.npz", "b.npz"):
        with pytest.raises(InvalidFile, match=r"states .* frames a second, expected 5 to 1000"):
            load(tmp_path / name, NO_OPTIONS)


def test_options_in_vain_are_refused(human: Path) -> None:
    with pytest.raises(
        InvalidOption, match="--units: this project's own has no use for it; options of native: --floor"
    ):
        load(human, SourceOptions(units="cm"))
    with pytest.raises(InvalidOption, match="--source-fps: expected 5 to 1000 frames a second, found -1"):
        load(human, SourceOptions(source_fps=-1))


def test_pairs_that_make_no_sense(tmp_path: Path, human: Path, robot: Path, trajectory) -> None:
    out = tmp_path / "out"
    with pytest.raises(InvalidOption, match=r"gmr cannot hold a human motion; valid: native, bvh; .*retarget"):
        save(out.with_suffix(".pkl"), load_motion(human))
    with pytest.raises(InvalidOption, match="bvh cannot hold a robot trajectory; valid: native, gmr, unitree-csv"):
        save(out.with_suffix(".bvh"), trajectory())
    with pytest.raises(InvalidOption, match=r"mjlab goes into a \.npz file"):
        save(out.with_suffix(".csv"), trajectory(), "mjlab")
    with pytest.raises(UnknownName, match=r"suffix to write '\.fbx'; valid: \.bvh, \.csv, \.npz, \.pkl"):
        save(out.with_suffix(".fbx"), trajectory())
    with pytest.raises(UnknownName, match="format to write 'amass'"):
        save(out.with_suffix(".npz"), trajectory(), "amass")
    with pytest.raises(UnknownName, match="format to read 'fbx'; valid: amass, asf-amc"):
        load(human, NO_OPTIONS, "fbx")
    with pytest.raises(InvalidFile, match="holds a robot trajectory, expected human motion"):
        load_human(robot, NO_OPTIONS)
    assert not list(tmp_path.glob("out*"))


@pytest.mark.parametrize("suffix", [".csv", ".pkl"])
def test_where_human_motion_is_wanted_a_robot_file_is_named_as_such(tmp_path: Path, trajectory, suffix: str) -> None:
    save(tmp_path / f"a{suffix}", trajectory())
    with pytest.raises(InvalidFile, match="holds a robot trajectory, expected human motion"):
        load_human(tmp_path / f"a{suffix}", NO_OPTIONS)


def test_the_command_line_says_it_in_one_line_and_writes_nothing(tmp_path: Path, human: Path, capsys) -> None:
    assert launch.main(["convert", str(human), str(tmp_path / "a.pkl")]) == 2
    assert launch.main(["convert", str(tmp_path / "none.bvh"), str(tmp_path / "a.npz")]) == 2
    assert launch.main(["convert", str(human), str(tmp_path / "a.npz"), "--fps", "0"]) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 3
    assert all(line.startswith("error: ") for line in errors)
    assert not list(tmp_path.glob("a*"))


def test_help_shows_examples(capsys) -> None:
    with pytest.raises(SystemExit):
        launch.main(["convert", "--help"])
    assert "python launch.py convert walk1_subject1.bvh walk.npz" in capsys.readouterr().out


@pytest.mark.skipif("RFS_CMU" not in os.environ, reason="RFS_CMU does not name a folder with the CMU archive")
def test_recorded_takes_of_every_kind(tmp_path: Path) -> None:
    folder = Path(os.environ["RFS_CMU"])
    for path in (folder / "09" / "09_01.bvh", folder / "131" / "131_01.bvh", next(folder.glob("*/*.amc"))):
        motion, notes = load_human(path, NO_OPTIONS)
        assert motion.fps == 120
        assert notes
        save(tmp_path / "a.bvh", motion)
        again, _ = load_human(tmp_path / "a.bvh", NO_OPTIONS)
        np.testing.assert_allclose(again.joints, motion.joints, atol=1e-3)
