"""A trajectory on the servo cycle's clock, inside the limits by construction.

The frames become the control points of a uniform cubic B-spline. Its positions, velocities and accelerations are
convex combinations of the frames and of their first and second differences, so it can exceed no bound that those keep
(de Boor, "A Practical Guide to Splines", chapter IX). It passes near the frames, not through them; the distance is
reported. First and last frame are repeated, so that the motion starts and ends at rest, exactly on them.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from hw.rig import Rig
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import Floats, RobotTrajectory

_DEGREE = 3
_REPEATS = 2
_ROUNDING = 1e-3
"""Relative excess over a limit that is rounding and no fault."""


@dataclass(frozen=True)
class Goals:
    """Joint goals on the servo cycle.

    Attributes:
        angles: (K, N) rad, in the rig's joint order.
        deviation: largest distance of a frame from the spline, rad.
    """

    angles: Floats
    deviation: float


def resample(trajectory: RobotTrajectory, rig: Rig) -> Goals:
    """Goals for every servo cycle.

    Raises:
        ModelMismatch: the trajectory lacks a joint of the rig.
        UnsafeCommand: the motion breaks the range, speed or acceleration limit of a joint; names the worst.
    """
    missing = [joint for joint in rig.joints if joint not in trajectory.joint_names]
    if missing:
        raise ModelMismatch(f"the trajectory of {trajectory.robot} has no joint {', '.join(missing)}")
    columns = [trajectory.joint_names.index(joint) for joint in rig.joints]
    frames = trajectory.joint_pos[:, columns]
    spline = _spline(frames, 1 / trajectory.fps)
    start, end = spline.t[_DEGREE], spline.t[-_DEGREE - 1]
    times = np.append(np.arange(start, end, rig.cycle_s), end)
    _check(rig, frames, times, spline.derivative(1)(times), spline.derivative(2)(times))
    deviation = np.abs(spline(np.arange(len(frames)) / trajectory.fps) - frames).max()
    return Goals(angles=spline(times), deviation=float(deviation))


def _spline(frames: Floats, dt: float) -> BSpline:
    """Control points are the frames, frame i at time i dt; the end frames thrice, so that the ends are exact."""
    points = np.concatenate([np.repeat(frames[:1], _REPEATS, 0), frames, np.repeat(frames[-1:], _REPEATS, 0)])
    knots = (np.arange(len(points) + _DEGREE + 1) - _REPEATS - (_DEGREE + 1) / 2) * dt
    return BSpline(knots, points, _DEGREE)


def _check(rig: Rig, frames: Floats, times: Floats, velocity: Floats, acceleration: Floats) -> None:
    excess = np.maximum(rig.lower - frames, frames - rig.upper) - rig.table.rad_per_tick
    if (excess > 0).any():
        frame, joint = np.unravel_index(int(excess.argmax()), excess.shape)
        raise UnsafeCommand(
            f"{rig.label(int(joint))} goes to {frames[frame, joint]:.3f} rad in frame {frame}, "
            f"range {rig.lower[joint]:.3f} to {rig.upper[joint]:.3f} rad"
        )
    for values, limit, name, unit in (
        (velocity, rig.velocity, "speed", "rad/s"),
        (acceleration, rig.acceleration, "acceleration", "rad/s^2"),
    ):
        ratio = np.abs(values) / limit
        k, joint = np.unravel_index(int(ratio.argmax()), ratio.shape)
        if ratio[k, joint] > 1 + _ROUNDING:
            raise UnsafeCommand(
                f"{rig.label(int(joint))} reaches {name} {abs(values[k, joint]):.2f} {unit} at {times[k]:.2f} s, "
                f"limit {limit[joint]:.2f} {unit}"
            )


def ramp(start: Floats, end: Floats, *, speed: float, cycle_s: float) -> Floats:
    """Minimum-jerk goals (K, N) from rest at `start` to rest at `end`, nowhere faster than `speed` rad/s.

    Source: Flash and Hogan 1985; the peak speed of x = d (10 s^3 - 15 s^4 + 6 s^5) is 15/8 d / T.
    """
    distance = float(np.abs(end - start).max(initial=0.0))
    cycles = max(1, int(np.ceil(15 / 8 * distance / speed / cycle_s)))
    s = np.arange(1, cycles + 1)[:, None] / cycles
    return start + (end - start) * s**3 * (10 - 15 * s + 6 * s**2)
