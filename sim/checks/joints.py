"""Checks of joint positions, speeds and accelerations against the robot's limits."""

import numpy as np

from ros_free_stack.messages import Check, Floats
from sim.reference import Reference
from sim.thresholds import Threshold


def joint_range(reference: Reference, threshold: Threshold) -> Check:
    """Greatest excess of a joint beyond its range, in rad: max(lower - q, q - upper), negative inside.

    Ranges are those of the robot description.
    """
    robot, q = reference.robot, reference.trajectory.joint_pos
    excess = np.maximum(robot.lower - q, q - robot.upper)
    frame, joint = _worst(excess)
    return threshold.check(
        "joint_range",
        excess[frame, joint],
        "The furthest that any joint goes beyond its range (negative: inside it).",
        worst_frame=frame,
        worst_item=robot.joint_names[joint],
    )


def joint_velocity(reference: Reference, threshold: Threshold) -> Check:
    """Greatest joint speed over the joint's limit: max |q[t+1] - q[t]| / (dt v_max), first differences."""
    robot = reference.robot
    ratio = np.abs(differences(reference.trajectory.joint_pos, 1, reference.dt)) / robot.velocity
    frame, joint = _worst(ratio)
    return threshold.check(
        "joint_velocity",
        ratio[frame, joint],
        "The highest joint speed as a share of what the servo can do.",
        worst_frame=frame,
        worst_item=robot.joint_names[joint],
    )


def joint_acceleration(reference: Reference, threshold: Threshold) -> Check:
    """Greatest joint acceleration over the joint's limit: max |q[t+1] - 2 q[t] + q[t-1]| / (dt^2 a_max)."""
    robot = reference.robot
    ratio = np.abs(differences(reference.trajectory.joint_pos, 2, reference.dt)) / robot.acceleration
    frame, joint = _worst(ratio)
    return threshold.check(
        "joint_acceleration",
        ratio[frame, joint],
        "The highest joint acceleration as a share of the joint's limit.",
        worst_frame=frame,
        worst_item=robot.joint_names[joint],
    )


def differences(values: Floats, order: int, dt: float) -> Floats:
    """Differences of the given order along time over dt^order; one frame of zeros where there are too few."""
    if len(values) <= order:
        return np.zeros((1, *values.shape[1:]))
    return np.diff(values, n=order, axis=0) / dt**order


def _worst(values: Floats) -> tuple[int, int]:
    frame, item = np.unravel_index(int(np.argmax(values)), values.shape)
    return int(frame), int(item)
