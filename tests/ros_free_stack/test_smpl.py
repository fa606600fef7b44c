import json
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats import amass
from ros_free_stack.formats.frames import from_y_up, stand
from ros_free_stack.formats.smpl import posed_joints, rest_joints
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import INDEX, JOINT_NAMES

UPRIGHT = Rotation.from_euler("xz", [90, 90], degrees=True)
"""SMPL's y-up body, facing z, put into AMASS's z-up world, facing x: the root's rotation in every file."""


def write_skeleton(path: Path, rest: Floats) -> Path:
    path.write_text(json.dumps(dict(zip(JOINT_NAMES, rest.tolist(), strict=True))))
    return path


def write_model(path: Path, rest: Floats, **changes: object) -> Path:
    """A model of 60 vertices whose joints are the given ones, one of them moved by the second shape number."""
    rng = np.random.default_rng(0)
    regressor = rng.normal(size=(24, 60))
    joints = np.concatenate([rest, rest[-2:]])
    shapes = np.zeros((60, 3, 10))
    shapes[..., 1] = np.linalg.pinv(regressor) @ np.eye(24)[[INDEX["head"]]].T @ [[0.0, 0.1, 0.0]]
    arrays = {"J_regressor": regressor, "v_template": np.linalg.pinv(regressor) @ joints, "shapedirs": shapes}
    np.savez(path, **(arrays | changes))  # pyright: ignore[reportArgumentType]
    return path


def write_motion(path: Path, frames: int = 5, **changes: object) -> Path:
    poses = np.zeros((frames, 156))
    poses[:, :3] = UPRIGHT.as_rotvec()
    poses[:, 3 * INDEX["left_elbow"] + 1] = np.linspace(0, -1.5, frames)
    trans = np.linspace(0, 1, frames)[:, None] * (0.5, 0.0, 0.0)
    arrays = {"poses": poses, "trans": trans, "betas": np.zeros(16), "mocap_framerate": 120.0, "gender": "female"}
    np.savez(path, **{name: value for name, value in (arrays | changes).items() if value is not None})  # pyright: ignore
    return path


def test_forward_kinematics(rest: Floats) -> None:
    rotations = np.zeros((2, 22, 3))
    rotations[1, INDEX["left_shoulder"]] = (0, 0, np.pi / 2)  # the left arm, along x, goes up
    points = posed_joints(rest, rotations, np.array([[0, 0, 0], [0, 0, 1.0]]))
    np.testing.assert_allclose(points[0], rest, atol=1e-12)
    arm = rest[INDEX["left_wrist"]] - rest[INDEX["left_shoulder"]]
    raised = rest[INDEX["left_shoulder"]] + (-arm[1], arm[0], arm[2]) + (0, 0, 1)
    np.testing.assert_allclose(points[1, INDEX["left_wrist"]], raised, atol=1e-12)
    np.testing.assert_allclose(points[1, INDEX["right_wrist"]], rest[INDEX["right_wrist"]] + (0, 0, 1), atol=1e-12)


@pytest.mark.parametrize("split", [False, True])
def test_amass_motion_with_rest_joints(tmp_path: Path, rest: Floats, split: bool) -> None:
    skeleton = write_skeleton(tmp_path / "rest.json", rest)
    path = write_motion(tmp_path / "a.npz")
    if split:  # as SMPL-X files of AMASS have it
        poses = np.load(path)["poses"]
        parts = {"poses": None, "root_orient": poses[:, :3], "pose_body": poses[:, 3:66]}
        path = write_motion(tmp_path / "b.npz", mocap_framerate=None, mocap_frame_rate=60, **parts)
    motion = amass.read(path, SourceOptions(skeleton=skeleton)).content
    assert isinstance(motion, HumanMotion)
    assert motion.fps == (60 if split else 120)
    np.testing.assert_allclose(motion.joints[0], stand(from_y_up(rest)[None])[0], atol=1e-9)
    np.testing.assert_allclose(motion.joints[-1, 0, :2], (0.5, 0), atol=1e-9)
    forearm = motion.joints[-1, INDEX["left_wrist"]] - motion.joints[-1, INDEX["left_elbow"]]
    assert forearm[0] / np.linalg.norm(forearm) > 0.95  # bent forward


def test_a_model_gives_the_body_of_the_shape_numbers(tmp_path: Path, rest: Floats) -> None:
    model = write_model(tmp_path / "SMPL.npz", rest)
    np.testing.assert_allclose(rest_joints(tmp_path, model, np.zeros(16)), rest, atol=1e-9)
    taller = rest_joints(tmp_path, model, np.array([0.0, 2.0]))
    np.testing.assert_allclose(taller[INDEX["head"]] - rest[INDEX["head"]], (0, 0.2, 0), atol=1e-9)
    motion = amass.read(write_motion(tmp_path / "a.npz"), SourceOptions(skeleton=model)).content
    assert isinstance(motion, HumanMotion)


def test_without_a_skeleton_the_error_says_what_to_supply(tmp_path: Path) -> None:
    with pytest.raises(InvalidOption, match=r"--skeleton: .*SMPL-X model \.npz .*or a \.json of the 22 rest joints"):
        amass.read(write_motion(tmp_path / "a.npz"), SourceOptions())


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"poses": np.zeros((5, 60))}, InvalidFile, r"poses: expected \(T, 66 or more\)"),
        ({"poses": np.zeros((0, 156)), "trans": np.zeros((0, 3))}, InvalidFile, r"found \(0, 156\)"),
        ({"trans": np.zeros((4, 3))}, InvalidFile, r"trans: expected \(5, 3\), .* found \(4, 3\)"),
        ({"trans": np.full((5, 3), np.nan)}, InvalidFile, "trans: a value that is not finite at frame 0"),
        ({"mocap_framerate": None}, InvalidOption, "--source-fps"),
        ({"mocap_framerate": np.nan}, InvalidOption, "--source-fps"),
        ({"poses": None}, InvalidFile, "neither poses nor root_orient"),
        ({"poses": np.array(["a"])}, InvalidFile, "poses is no array of numbers"),
        ({"betas": np.zeros((5, 10)), "smpl_scaling": np.zeros(1)}, InvalidFile, "smpl_scaling: expected one positive"),
        ({"mocap_framerate": np.zeros(2)}, InvalidFile, "mocap_framerate is .* expected a number"),
    ],
)
def test_errors_of_a_motion(tmp_path: Path, rest: Floats, changes: dict, error: type, message: str) -> None:
    skeleton = write_skeleton(tmp_path / "rest.json", rest)
    with pytest.raises(error, match=message):
        amass.read(write_motion(tmp_path / "a.npz", **changes), SourceOptions(skeleton=skeleton))


def test_errors_of_a_skeleton(tmp_path: Path, rest: Floats) -> None:
    def problem(skeleton: Path) -> str:
        with pytest.raises(InvalidFile) as error:
            rest_joints(tmp_path, skeleton, np.zeros(10))
        return str(error.value)

    assert "no such file" in problem(tmp_path / "none.npz")
    assert "has no v_template" in problem(_lacking(tmp_path))
    assert "parts that do not fit" in problem(write_model(tmp_path / "b.npz", rest, v_template=np.zeros((59, 3))))
    assert "not finite" in problem(write_model(tmp_path / "c.npz", rest, v_template=np.full((60, 3), np.nan)))
    assert "plain arrays" in problem(write_model(tmp_path / "d.npz", rest, J_regressor=np.array([{}], dtype=object)))
    (tmp_path / "e.npz").write_bytes(b"\x00\xff" * 50)
    assert "not an SMPL model" in problem(tmp_path / "e.npz")
    big = write_skeleton(tmp_path / "big.json", 100 * rest)
    assert "rest joints of a person 170 m tall: are they in m?" in problem(big)
    (tmp_path / "a.json").write_text("{}")
    assert "no rest joint 'pelvis'" in problem(tmp_path / "a.json")
    (tmp_path / "b.json").write_text(json.dumps({name: [0, 1] for name in JOINT_NAMES}))
    assert "three numbers a joint" in problem(tmp_path / "b.json")
    (tmp_path / "c.json").write_text('{"pelvis": [0')
    assert "not a JSON object" in problem(tmp_path / "c.json")


def _lacking(folder: Path) -> Path:
    np.savez(folder / "lacking.npz", J_regressor=np.zeros((24, 60)), shapedirs=np.zeros((60, 3, 10)))
    return folder / "lacking.npz"
