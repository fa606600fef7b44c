"""Checks of joint positions, speeds and accelerations against the robot's limits, and of their smoothness."""

import numpy as np
from scipy.ndimage import maximum_filter1d, uniform_filter1d

from ros_free_stack.messages import Check, Floats
from ros_free_stack.thresholds import Threshold
from sim.reference import Reference


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


JERK_WINDOW_S = 0.4
STILL_RAD_PER_S = 0.3
"""Joints that stay slower than this in a window are as good as still, and their jerk means nothing."""


def jerk(reference: Reference, threshold: Threshold) -> Check:
    """Greatest dimensionless jerk of any joint in any window of 0.4 s, as its natural logarithm.

    ln(W^3 / v_peak^2 * integral of (d3q/dt3)^2 dt) over a window of W s with peak speed v_peak (Hogan and Sternad 2009,
    "Sensitivity of smoothness measures to movement duration, amplitude, and arrests"). It does not depend on amplitude:
    a sine of frequency f gives about 4 ln(2 pi f W) - 0.7, so 5.8 at 2 Hz and 12.2 at 10 Hz. Peak speeds below 0.3
    rad/s count as 0.3.
    """
    q, dt = reference.trajectory.joint_pos, reference.dt
    squared = differences(q, 3, dt) ** 2
    width = min(max(1, round(JERK_WINDOW_S / dt)), len(squared))
    speed = np.abs(differences(q, 1, dt))[: len(squared)]
    energy = uniform_filter1d(squared, width, axis=0, mode="nearest") * JERK_WINDOW_S
    peak = np.maximum(maximum_filter1d(speed, width, axis=0, mode="nearest"), STILL_RAD_PER_S)
    value = np.log(np.maximum(JERK_WINDOW_S**3 / peak**2 * energy, 1.0))
    frame, joint = _worst(value)
    return threshold.check(
        "jerk",
        value[frame, joint],
        "How shaky the shakiest joint is, whatever its amplitude.",
        worst_frame=frame,
        worst_item=reference.robot.joint_names[joint] if value[frame, joint] > 0 else "",
    )


def differences(values: Floats, order: int, dt: float) -> Floats:
    """Differences of the given order along time over dt^order; one frame of zeros where there are too few."""
    if len(values) <= order:
        return np.zeros((1, *values.shape[1:]))
    return np.diff(values, n=order, axis=0) / dt**order


def _worst(values: Floats) -> tuple[int, int]:
    frame, item = np.unravel_index(int(np.argmax(values)), values.shape)
    return int(frame), int(item)
