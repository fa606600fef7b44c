"""Which moment of the human motion a frame of the robot belongs to."""

import numpy as np

from ros_free_stack.messages import Floats, HumanMotion, RobotTrajectory


def lead_in_s(motion: HumanMotion, trajectory: RobotTrajectory) -> float:
    """Time by which the robot follows the human: a retargeted trajectory stands equally long before and after."""
    return (trajectory.duration_s - motion.duration_s) / 2


def human_at(motion: HumanMotion, trajectory: RobotTrajectory, times_s: Floats) -> Floats:
    """(n, 22, 3) joints of the human at times of the trajectory, resting before and after."""
    wanted = np.asarray(times_s) - lead_in_s(motion, trajectory)
    index = np.clip(np.rint(wanted * motion.fps).astype(int), 0, len(motion.joints) - 1)
    return motion.joints[index]
