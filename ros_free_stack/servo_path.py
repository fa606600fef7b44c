"""What servos are told: a trajectory at the rate of their bus, made once, then judged, drawn and streamed alike.

The frames become the control points of a uniform cubic B-spline. Its positions, velocities and accelerations are
convex combinations of the frames and of their first and second differences, so it can exceed no bound that those keep
(de Boor, "A Practical Guide to Splines", chapter IX). It passes near the frames, not through them. Where the motion
begins or ends at speed, time itself eases in and out, so that it still starts and ends at rest.
"""

from dataclasses import replace

import numpy as np
from scipy.interpolate import BSpline  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]

from ros_free_stack.messages import Floats, RobotTrajectory
from ros_free_stack.robots import RobotDescription

_DEGREE = 3
EASE_S = 0.3
"""Over so long time eases in, and out again."""


def servo_path(trajectory: RobotTrajectory, robot: RobotDescription) -> RobotTrajectory:
    """The trajectory at one frame a servo cycle, from rest to rest; as it is for a robot without a servo bus.

    The same trajectory gives the same path to the bit, so that whoever streams can make again what was judged.
    """
    if robot.servos is None:
        return trajectory
    fps = 1 / robot.servos.cycle_s
    phase = _phase(trajectory, robot, fps)
    frames = np.clip(np.rint(phase * trajectory.fps).astype(int), 0, len(trajectory.joint_pos) - 1)
    quaternions = _smoothed(_one_hemisphere(trajectory.root_quat), trajectory.fps, phase)
    return replace(
        trajectory,
        fps=fps,
        root_pos=_smoothed(trajectory.root_pos, trajectory.fps, phase),
        root_quat=quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True),
        joint_pos=_smoothed(trajectory.joint_pos, trajectory.fps, phase),
        contacts=trajectory.contacts[frames],
    )


def smoothing_error(trajectory: RobotTrajectory) -> float:
    """Largest distance in rad of a frame's joint angle from the path: a sixth of the second difference."""
    return float(np.abs(np.diff(trajectory.joint_pos, n=2, axis=0)).max(initial=0.0)) / 6


def _smoothed(frames: Floats, fps: float, phase: Floats) -> Floats:
    """(K, n) the spline of frames (T, n) at times (K,): frame i is the control point of time i / fps.

    A mirrored point beyond each end makes the ends exact.
    """
    second, last_but_one = frames[min(1, len(frames) - 1)], frames[max(-2, -len(frames))]
    points = np.concatenate([[2 * frames[0] - second], frames, [2 * frames[-1] - last_but_one]])
    # A single frame needs two more points to carry a cubic.
    points = np.concatenate([points, np.repeat(points[-1:], max(0, _DEGREE + 1 - len(points)), 0)])
    knots = (np.arange(len(points) + _DEGREE + 1) - _DEGREE) / fps
    return BSpline(knots, points, _DEGREE)(phase)


def _one_hemisphere(quaternions: Floats) -> Floats:
    """The same rotations (T, 4), each with the sign that lies nearer to the one before."""
    flips = np.sign((quaternions[1:] * quaternions[:-1]).sum(axis=1))
    signs = np.cumprod(np.concatenate([[1.0], np.where(flips < 0, -1.0, 1.0)]))
    return quaternions * signs[:, None]


def _phase(trajectory: RobotTrajectory, robot: RobotDescription, fps: float) -> Floats:
    """(K,) the motion's own time at each servo cycle, s; the last cycle stands at its end.

    Its rate rises from 0 to 1 as 3 x^2 - 2 x^3 over the first 0.3 s, and falls likewise over the last, where a joint
    would have to start or stop faster than its acceleration limit lets it in one cycle.
    """
    duration = (len(trajectory.joint_pos) - 1) / trajectory.fps
    window = 0.0 if _rests_at_its_ends(trajectory, robot, fps) else min(EASE_S, duration)
    total = duration + window
    times = np.minimum(np.arange(int(np.ceil(total * fps - 1e-9)) + 1) / fps, total)
    if window == 0:
        return times
    early, late = np.clip(times / window, 0, 1), np.clip((total - times) / window, 0, 1)
    return np.where(
        times < total / 2,
        window * (early**3 - early**4 / 2) + np.maximum(times - window, 0),
        duration - window * (late**3 - late**4 / 2) - np.maximum(total - times - window, 0),
    )


def _rests_at_its_ends(trajectory: RobotTrajectory, robot: RobotDescription, fps: float) -> bool:
    if len(trajectory.joint_pos) == 1:
        return True
    order = [robot.joint_names.index(name) for name in trajectory.joint_names]
    steps = np.abs(trajectory.joint_pos[[1, -1]] - trajectory.joint_pos[[0, -2]]) * trajectory.fps
    return bool((steps <= robot.acceleration[order] / fps).all())
