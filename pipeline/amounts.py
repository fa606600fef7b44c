"""What a robot's trajectory comes to in each segment of the human motion: its own metres, degrees and seconds."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from generator.amounts import Measured, Wanted, range_of
from ros_free_stack.messages import HumanMotion

if TYPE_CHECKING:
    from retarget.pipeline import RetargetResult


def robot_measured(motion: HumanMotion, result: "RetargetResult", wanted: Sequence[Wanted]) -> tuple[Measured, ...]:
    """Net way over the floor, net turn and time of the robot, an entry for each amount that is wanted.

    Args:
        motion: what was retargeted.
        result: the trajectory, and which moment of the motion each of its frames follows.
        wanted: amounts of segments of the motion.
    """
    trajectory, human_s = result.trajectory, result.human_s
    # The angle of the root's forward axis over the floor, from its quaternion w, x, y, z.
    w, x, y, z = trajectory.root_quat.T
    heading = np.unwrap(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y**2 + z**2)))
    found: list[Measured] = []
    for item in wanted:
        start_s, end_s = range_of(motion.segments, item)
        start = max(int(np.searchsorted(human_s, start_s + 1e-6)) - 1, 0)
        end = min(int(np.searchsorted(human_s, min(end_s, human_s[-1]) - 1e-6)), len(human_s) - 1)
        way = float(np.linalg.norm(trajectory.root_pos[end, :2] - trajectory.root_pos[start, :2]))
        turn = abs(float(np.degrees(heading[end] - heading[start])))
        found.append(Measured(way, turn, (end - start) / trajectory.fps))
    return tuple(found)
