"""Motions of MimicKit (Peng, 2025): a pickled dictionary of fps, loop_mode and frames.

A row of frames is the root's place (3) m, its rotation vector (3) and the joints' angles in rad, in the order of the
robot's model.
"""

from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.robot_source import RobotArrays, robot_source
from ros_free_stack.formats.safe_pickle import read_pickle
from ros_free_stack.formats.smpl_poses import numbers, stated_rate
from ros_free_stack.formats.source import Source, SourceOptions, check_finite

KEYS: Final = ("fps", "loop_mode", "frames")


def read(path: Path, options: SourceOptions) -> Source:
    """The robot trajectory in a MimicKit pickle.

    Raises:
        UnsafePickle: the pickle names something that is not plain data.
        InvalidFile: it is damaged, or lacks a part.
        InvalidOption: no robot was named.
    """
    data = read_pickle(path)
    if not isinstance(data, dict) or not data.keys() >= {"fps", "frames"}:
        raise InvalidFile(path, f"not a MimicKit motion; expected a dictionary with {', '.join(KEYS)}")
    entries = cast(dict[str, Any], data)
    frames = numbers(path, entries, "frames")
    if frames.ndim != 2 or frames.shape[1] < 7:
        raise InvalidFile(path, f"frames: expected (T, 6 + joints), found {frames.shape}")
    check_finite(path, "frames", frames)
    arrays = RobotArrays(
        root_pos=frames[:, :3],
        root_quat=np.asarray(Rotation.from_rotvec(frames[:, 3:6]).as_quat(scalar_first=True)),
        order="wxyz",
        joint_pos=frames[:, 6:],
        fps=stated_rate(path, entries),
    )
    return robot_source(path, options, arrays)
