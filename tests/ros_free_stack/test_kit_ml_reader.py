from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.features import KIT
from ros_free_stack.formats.humanml3d import PublishedDataset
from ros_free_stack.formats.kit_ml import open_kit_ml, read_joints
from ros_free_stack.skeleton import INDEX

DIRECTIONS = {"left": (0, 1, 0), "right": (0, -1, 0), "up": (0, 0, 1), "down": (0, 0, -1), "forward": (1, 0, 0)}


def walk() -> NDArray[np.float64]:
    """26 frames (2 s) of a person in mm who slides forward along x at 1 m/s, z up."""
    pose = np.zeros((21, 3))
    for joint, parent in enumerate(KIT.parents, start=1):
        length = 100 if KIT.directions[joint] in ("left", "right", "forward") else 300
        pose[joint] = pose[parent] + length * np.array(DIRECTIONS[KIT.directions[joint]])
    return pose + 80.0 * np.arange(26)[:, None, None] * (1, 0, 0) + (0, 0, 900)


def save(folder: Path, points: NDArray[np.float64]) -> PublishedDataset:
    for name in ("new_joint_vecs", "new_joints", "texts"):
        (folder / name).mkdir(exist_ok=True)
    np.save(folder / "new_joints/00001.npy", points[..., [1, 2, 0]].astype(np.float32))
    (folder / "train.txt").write_text("00001\n", encoding="utf-8")
    return open_kit_ml(folder)


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("backwards", [False, True])
def test_a_walk_comes_out_forward_with_left_on_the_left(tmp_path: Path, mirrored: bool, backwards: bool) -> None:
    points = walk() * (-1 if backwards else 1, -1 if backwards else 1, 1) * (1, -1 if mirrored else 1, 1)
    joints = read_joints(save(tmp_path, points), "00001")
    assert joints.shape == (41, 22, 3)
    np.testing.assert_allclose(joints[-1, 0] - joints[0, 0], (2, 0, 0), atol=1e-3)
    assert joints[0, INDEX["left_wrist"], 1] > 0 > joints[0, INDEX["right_wrist"], 1]
    assert joints[..., 2].min() == pytest.approx(0, abs=1e-6)
    assert joints[0, INDEX["left_foot"], 0] > joints[0, INDEX["left_ankle"], 0]
    np.testing.assert_allclose(joints[0, 0, :2], 0, atol=1e-9)


def test_metres_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match="expected a person in mm"):
        read_joints(save(tmp_path, walk() / 1000), "00001")


def test_other_joints_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InvalidFile, match=r"expected floats of shape \(T, 21, 3\)"):
        read_joints(save(tmp_path, np.zeros((5, 22, 3))), "00001")
