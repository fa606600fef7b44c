"""GMR's robot motions (Ze et al., 2025): a pickled dictionary.

fps; root_pos (T, 3) m; root_rot (T, 4) xyzw; dof_pos (T, J) rad in the order of the robot's model; local_body_pos and
link_body_list, which GMR's own scripts leave empty. Its viewer takes that the keys are there.
"""

import pickle
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import atomic_path
from ros_free_stack.formats.robot_source import RobotArrays, robot_source
from ros_free_stack.formats.safe_pickle import read_pickle
from ros_free_stack.formats.smpl_poses import numbers, stated_rate
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.messages import RobotTrajectory

KEYS: Final = ("fps", "root_pos", "root_rot", "dof_pos")


def read(path: Path, options: SourceOptions) -> Source:
    """The robot trajectory in a GMR pickle.

    Raises:
        UnsafePickle: the pickle names something that is not plain data.
        InvalidFile: it is damaged, or lacks a part.
    """
    data = read_pickle(path)
    if not isinstance(data, dict) or not data.keys() >= set(KEYS):
        raise InvalidFile(path, f"not a GMR motion; expected a dictionary with {', '.join(KEYS)}")
    entry = cast(dict[str, Any], data)
    root_pos, root_quat, joint_pos = (numbers(path, entry, key) for key in KEYS[1:])
    arrays = RobotArrays(
        root_pos=root_pos, root_quat=root_quat, order="xyzw", joint_pos=joint_pos, fps=stated_rate(path, entry)
    )
    return robot_source(path, options, arrays)


def write(path: Path, trajectory: RobotTrajectory) -> tuple[str, ...]:
    """Write a trajectory as GMR's own loader reads it (with numpy 1.26 or newer)."""
    data = {
        "fps": trajectory.fps,
        "root_pos": np.array(trajectory.root_pos),
        "root_rot": trajectory.root_quat[:, (1, 2, 3, 0)],
        "dof_pos": np.array(trajectory.joint_pos),
        "local_body_pos": None,
        "link_body_list": None,
    }
    with atomic_path(path) as temporary:
        temporary.write_bytes(pickle.dumps(data, protocol=4))
    return ()
