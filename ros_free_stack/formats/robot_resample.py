"""Robot trajectories at another frame rate, and parts of them."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation, Slerp  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.formats.frames import blend
from ros_free_stack.messages import Floats, RobotTrajectory


def resample_trajectory(trajectory: RobotTrajectory, fps: float) -> RobotTrajectory:
    """A trajectory at another frame rate: linear, the root's orientation by slerp, contacts of the frame before."""
    before, after, part = blend(len(trajectory.joint_pos), fps=trajectory.fps, to=fps)

    def linear(values: Floats) -> Floats:
        return values[before] + part[:, None] * (values[after] - values[before])

    quaternions = trajectory.root_quat
    if len(quaternions) > 1:
        slerp = Slerp(np.arange(len(quaternions)), Rotation.from_quat(quaternions, scalar_first=True))
        quaternions = slerp(before + part).as_quat(scalar_first=True)
    return RobotTrajectory(
        robot=trajectory.robot,
        model_sha256=trajectory.model_sha256,
        joint_names=trajectory.joint_names,
        fps=fps,
        root_pos=linear(trajectory.root_pos),
        root_quat=quaternions,
        joint_pos=linear(trajectory.joint_pos),
        contacts=trajectory.contacts[before],
        foot_names=trajectory.foot_names,
    )


def part_of_trajectory(trajectory: RobotTrajectory, frames: slice) -> RobotTrajectory:
    """The given frames of a trajectory."""
    return replace(
        trajectory,
        root_pos=trajectory.root_pos[frames],
        root_quat=trajectory.root_quat[frames],
        joint_pos=trajectory.joint_pos[frames],
        contacts=trajectory.contacts[frames],
    )
