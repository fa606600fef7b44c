"""Arrays and pickles of people as other projects save them."""

import json
import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.frames import stand, to_y_up
from ros_free_stack.formats.registry import load, load_human
from ros_free_stack.formats.smpl import posed_joints
from ros_free_stack.formats.source import SourceOptions, UpAxis
from ros_free_stack.formats.upright import turned_up
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import JOINT_NAMES

NO_OPTIONS = SourceOptions()
RATE = "files state no frame rate"


def more_joints(joints: Floats, count: int) -> Floats:
    """Joints of SMPL's successors after the first 22: hands and face, near the wrists."""
    return np.concatenate([joints, np.repeat(joints[:, -1:], count - 22, axis=1) + 0.05], axis=1)


@pytest.fixture
def joints(person) -> Floats:
    """(30, 22, 3) m, y up."""
    return to_y_up(person(30).joints)


@pytest.fixture
def skeleton(tmp_path: Path, rest: Floats) -> SourceOptions:
    path = tmp_path / "rest.json"
    path.write_text(json.dumps(dict(zip(JOINT_NAMES, rest.tolist(), strict=True))))
    return SourceOptions(skeleton=path)


SHAPES = {
    "(T, 22, 3)": lambda joints: joints,
    "(T, 24, 3)": lambda joints: more_joints(joints, 24),
    "(T, 52, 3)": lambda joints: more_joints(joints, 52),
    "(T, 127, 3)": lambda joints: more_joints(joints, 127),
    "(1, T, 22, 3)": lambda joints: joints[None],
    "(1, T, 24, 3)": lambda joints: more_joints(joints, 24)[None],
    "(T, 66)": lambda joints: joints.reshape(-1, 66),
    "(1, T, 66)": lambda joints: joints.reshape(1, -1, 66),
    "(22, 3, T)": lambda joints: np.moveaxis(joints, 0, -1),
    "(1, 22, 3, T)": lambda joints: np.moveaxis(joints, 0, -1)[None],
    "(T, 3, 22)": lambda joints: joints.swapaxes(1, 2),
    "float32": lambda joints: joints.astype(np.float32),
}


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("suffix", [".npy", ".npz", ".pkl"])
def test_joints_in_every_shape(tmp_path: Path, joints: Floats, shape: str, suffix: str) -> None:
    values, path = SHAPES[shape](joints), tmp_path / f"a{suffix}"
    if suffix == ".npy":
        np.save(path, values)
    elif suffix == ".npz":
        np.savez(path, joints=values, fps=30)
    else:
        path.write_bytes(pickle.dumps({"joints": values, "fps": 30}))
    if suffix != ".npy" and values.ndim == 2:
        with pytest.raises(InvalidFile, match="of no known format"):
            load_human(path, NO_OPTIONS)
        return
    motion, notes = load_human(path, NO_OPTIONS)
    np.testing.assert_allclose(motion.joints, stand(turned_up(joints, "y")), atol=1e-6)
    assert motion.fps == (20 if suffix == ".npy" else 30)
    assert any(RATE in note for note in notes) == (suffix == ".npy")


def test_a_square_of_axes_is_no_riddle(tmp_path: Path, person) -> None:
    """As many frames as joints, or three frames: the last axis counts."""
    for frames in (3, 22, 24):
        joints = to_y_up(person(frames).joints)
        for values in (joints, more_joints(joints, 24)):
            np.save(tmp_path / "a.npy", values)
            motion, _ = load_human(tmp_path / "a.npy", NO_OPTIONS)
            np.testing.assert_allclose(motion.joints, stand(turned_up(joints, "y")), atol=1e-6)


def test_results_of_mdm(tmp_path: Path, person) -> None:
    first, second = (to_y_up(person(frames, seed=frames).joints) for frames in (40, 30))
    padded = np.concatenate([second, np.zeros((10, 22, 3))])
    results = {
        "motion": np.moveaxis(np.stack([first, padded]), 1, -1),
        "text": ["a person walks", "a person waves"],
        "lengths": np.array([40, 30]),
        "num_samples": 2,
        "num_repetitions": 1,
    }
    np.save(tmp_path / "results.npy", results)  # pyright: ignore[reportArgumentType]
    with pytest.raises(InvalidOption, match=r"--clip: name one of the 2 clips .* by its number: 0 to 1"):
        load(tmp_path / "results.npy", NO_OPTIONS)
    with pytest.raises(UnknownName, match="valid: 0, 1"):
        load(tmp_path / "results.npy", SourceOptions(clip="2"))
    motion, notes = load_human(tmp_path / "results.npy", SourceOptions(clip="1"))
    np.testing.assert_allclose(motion.joints, stand(turned_up(second, "y")), atol=1e-9)
    assert notes[0] == "the clip's text: a person waves"


def test_an_npy_that_would_run_something_is_refused(tmp_path: Path) -> None:
    class Evil:
        def __reduce__(self):
            return (print, ("run",))

    np.save(tmp_path / "a.npy", np.array(Evil(), dtype=object))
    with pytest.raises(InvalidFile, match=r"names builtins\.print|refused"):
        load(tmp_path / "a.npy", NO_OPTIONS)


@pytest.mark.parametrize(
    ("shape", "advice"),
    [
        ((30, 17, 3), "joints of COCO or Human3.6M"),
        ((30, 25, 3), "joints of OpenPose or NTU"),
        ((30, 251), "features of KIT-ML"),
        ((30, 72), r"expected \(T, 22, 3\), more joints of SMPL"),
        ((22, 3), r"expected \(T, 22, 3\)"),
        ((30,), r"expected \(T, 22, 3\)"),
    ],
)
def test_other_arrays_are_refused_with_what_they_are(tmp_path: Path, shape: tuple[int, ...], advice: str) -> None:
    np.save(tmp_path / "a.npy", np.random.default_rng(0).normal(size=shape))
    with pytest.raises(InvalidFile, match=advice):
        load(tmp_path / "a.npy", NO_OPTIONS)


@pytest.mark.parametrize("up", ["y", "z", "y-down"])
def test_every_array_lies_on_no_side(tmp_path: Path, person, up) -> None:
    pose = person(30).joints
    points = {"y": to_y_up(pose), "z": pose, "y-down": to_y_up(pose) * (1, -1, -1)}[up]
    np.save(tmp_path / "a.npy", points)
    motion, notes = load_human(tmp_path / "a.npy", NO_OPTIONS)
    np.testing.assert_allclose(motion.joints, stand(pose), atol=1e-9)
    assert any(f"{up} up" in note for note in notes) == (up != "y")


def smpl(frames: int = 20) -> tuple[Floats, Floats]:
    """Rotation vectors (T, 22, 3) and places (T, 3) of a person who turns and waves, y up."""
    time = np.arange(frames) / 20
    rotations = np.zeros((frames, 22, 3))
    rotations[:, 0, 1] = 0.5 * time
    rotations[:, JOINT_NAMES.index("left_shoulder"), 2] = np.sin(time)
    return rotations, np.stack([0.1 * time, 0 * time, 0.8 * time], axis=1)


NAMES = {
    "AMASS": lambda turns, places: {"poses": np.pad(turns.reshape(-1, 66), ((0, 0), (0, 90))), "trans": places},
    "SMPL-X of AMASS": lambda turns, places: {
        "root_orient": turns[:, 0], "pose_body": turns[:, 1:].reshape(-1, 63), "trans": places,
    },
    "GVHMR": lambda turns, places: {
        "global_orient": turns[:, 0], "body_pose": turns[:, 1:].reshape(-1, 63), "transl": places,
        "betas": np.zeros((len(turns), 10)),
    },
    "one batch": lambda turns, places: {
        "root_orient": turns[None, :, 0], "pose_body": turns[None, :, 1:].reshape(1, -1, 63), "trans": places[None],
    },
    "AIST++": lambda turns, places: {
        "smpl_poses": np.pad(turns.reshape(-1, 66), ((0, 0), (0, 6))), "smpl_trans": 93.0 * places,
        "smpl_scaling": [93.0],
    },
    "WHAM": lambda turns, places: {
        "pose_world": np.pad(turns.reshape(-1, 66), ((0, 0), (0, 6))), "trans_world": places,
        "betas": np.zeros((20, 10)),
    },
    "matrices": lambda turns, places: {
        "body_pose": Rotation.from_rotvec(turns[:, 1:].reshape(-1, 3)).as_matrix().reshape(-1, 21, 3, 3),
        "global_orient": Rotation.from_rotvec(turns[:, 0]).as_matrix()[:, None], "transl": places,
    },
    "(T, J, 3)": lambda turns, places: {"poses": turns, "trans": places},
}  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("up", ["y", "z"])
@pytest.mark.parametrize("suffix", [".npz", ".pkl"])
def test_poses_under_every_name(tmp_path: Path, rest, skeleton, name: str, up: UpAxis, suffix: str) -> None:
    turns, places = smpl()
    wanted = stand(turned_up(posed_joints(rest, turns, places), "y"))
    if up == "z":  # the world lies on its back, the pelvis stays at its rest place in the body's own axes
        upright = Rotation.from_euler("x", 90, degrees=True)
        pelvis = rest[0]
        places = upright.apply(places + pelvis) - pelvis
        turns[:, 0] = (upright * Rotation.from_rotvec(turns[:, 0])).as_rotvec()
    entries = NAMES[name](turns, places) | {"fps": 20}
    path = tmp_path / f"a{suffix}"
    if suffix == ".npz":
        np.savez(path, **entries)  # pyright: ignore[reportArgumentType]
    else:
        path.write_bytes(pickle.dumps(entries if name == "AIST++" else {0: entries}))
    motion, _ = load_human(path, skeleton)
    np.testing.assert_allclose(motion.joints, wanted, atol=1e-6)
    assert motion.fps == 20
    told, _ = load_human(path, replace(skeleton, up=up))
    np.testing.assert_allclose(told.joints, wanted, atol=1e-6)


def test_poses_without_a_place_or_a_rate(tmp_path: Path, skeleton) -> None:
    turns, _ = smpl()
    np.savez(tmp_path / "a.npz", poses=turns)
    with pytest.raises(InvalidOption, match=r"--source-fps: name the frame rate of .*: the file does not state it"):
        load(tmp_path / "a.npz", skeleton)
    source = load(tmp_path / "a.npz", SourceOptions(skeleton=skeleton.skeleton, source_fps=60))
    assert source.notes[0] == "the file says nothing of where the person is: the pelvis stays in place"


def test_of_several_people_in_a_pickle_one_is_asked_for(tmp_path: Path, skeleton) -> None:
    turns, places = smpl()
    clip = {"pose_world": turns, "trans_world": places, "fps": 30}
    for data, names in (({0: clip, 3: clip}, "0, 3"), ([clip, clip], "0, 1")):
        (tmp_path / "a.pkl").write_bytes(pickle.dumps(data))
        with pytest.raises(InvalidOption, match=rf"--clip: name one of the 2 clips of .*: {names}"):
            load(tmp_path / "a.pkl", skeleton)
        assert load(tmp_path / "a.pkl", replace(skeleton, clip="0")).content.fps == 30
