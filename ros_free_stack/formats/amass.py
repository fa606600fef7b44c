"""AMASS (Mahmood et al., ICCV 2019): `.npz` of SMPL-H or SMPL-X poses, z up.

poses (T, 156 or 165) rotation vectors, or root_orient (T, 3) with pose_body (T, 63); trans (T, 3) m; betas (B,) shape
numbers; mocap_framerate or mocap_frame_rate. Bone lengths are in the body model, which the user supplies.
"""

import zipfile
import zlib
from pathlib import Path
from typing import Final

import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.smpl import posed_joints, rest_joints
from ros_free_stack.formats.source import Source, SourceOptions, check_finite
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import JOINT_COUNT

_WANTED: Final = ("poses", "root_orient", "pose_body", "trans", "betas", "mocap_framerate", "mocap_frame_rate")


def read(path: Path, options: SourceOptions) -> Source:
    """The human motion in an AMASS file.

    Raises:
        InvalidFile: the file or the skeleton is damaged or lacks a part.
        InvalidOption: no skeleton was named, or the frame rate is nowhere stated.
    """
    data = _arrays(path)
    poses = data["poses"] if "poses" in data else _joined(path, data)
    trans = data.get("trans", np.empty(0))
    if poses.ndim != 2 or poses.shape[1] < 3 * JOINT_COUNT or trans.shape != (len(poses), 3) or not len(poses):
        raise InvalidFile(
            path, f"expected poses (T, {3 * JOINT_COUNT} or more) and trans (T, 3), found {poses.shape}, {trans.shape}"
        )
    check_finite(path, "poses", poses)
    check_finite(path, "trans", trans)
    rate = data.get("mocap_framerate", data.get("mocap_frame_rate", np.empty(0))).ravel()
    fps = float(rate[0]) if len(rate) == 1 else None
    rest = rest_joints(path, options.skeleton, data.get("betas", np.empty(0)).ravel())
    rotations = poses[:, : 3 * JOINT_COUNT].reshape(-1, JOINT_COUNT, 3)
    habits = Habits(title="AMASS", up="z", units="m")
    return person_source(path, posed_joints(rest, rotations, trans), options, habits, fps=fps)


def _joined(path: Path, data: dict[str, Floats]) -> Floats:
    try:
        return np.concatenate([data["root_orient"], data["pose_body"]], axis=1)
    except (KeyError, ValueError):
        raise InvalidFile(path, "has neither poses nor root_orient with pose_body") from None


def _arrays(path: Path) -> dict[str, Floats]:
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    try:
        with np.load(path, allow_pickle=False) as archive:
            return {name: np.asarray(archive[name], dtype=np.float64) for name in _WANTED if name in archive.files}
    except (ValueError, OSError, EOFError, KeyError, TypeError, zipfile.BadZipFile, zlib.error) as error:
        raise InvalidFile(path, f"not a readable .npz ({error})") from None
