"""This project's own files of human motion and of robot trajectories, as formats among the others."""

from pathlib import Path

import numpy as np

from ros_free_stack.files import load_motion, load_trajectory, save_motion, save_trajectory
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.messages import HumanMotion, RobotTrajectory


def read(path: Path, options: SourceOptions) -> Source:
    """This project's own file of either kind."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            kind = str(archive["kind"])
    except Exception:  # the reader of motions says what is wrong
        kind = "human_motion"
    return Source(load_trajectory(path) if kind == "robot_trajectory" else load_motion(path))


def write(path: Path, content: HumanMotion | RobotTrajectory) -> tuple[str, ...]:
    """This project's own file."""
    if isinstance(content, HumanMotion):
        save_motion(path, content)
    else:
        save_trajectory(path, content)
    return ()
