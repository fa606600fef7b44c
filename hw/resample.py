"""A trajectory on the servo cycle's clock, inside the limits by construction.

The frames become the control points of a uniform cubic B-spline. Its positions, velocities and accelerations are
convex combinations of the frames and of their first and second differences, so it can exceed no bound that those keep
(de Boor, "A Practical Guide to Splines", chapter IX). It passes near the frames, not through them; the distance is
reported. Time itself eases in and out, so that a motion that begins or ends at speed still starts and ends at rest.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from hw.rig import Rig
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import Floats, RobotTrajectory

_DEGREE = 3
_EASE_S = 0.3
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
    duration = (len(frames) - 1) / trajectory.fps
    times, phase, rate, change = _eased(duration, rig.cycle_s)
    slope = spline.derivative(1)(phase)
    acceleration = spline.derivative(2)(phase) * rate[:, None] ** 2 + slope * change[:, None]
    _check(rig, frames, times, slope * rate[:, None], acceleration)
    deviation = np.abs(spline(np.arange(len(frames)) / trajectory.fps) - frames).max()
    return Goals(angles=spline(phase), deviation=float(deviation))


def _spline(frames: Floats, dt: float) -> BSpline:
    """Control points are the frames, frame i at time i dt; a mirrored point beyond each end makes the ends exact."""
    second, last_but_one = frames[min(1, len(frames) - 1)], frames[max(-2, -len(frames))]
    points = np.concatenate([[2 * frames[0] - second], frames, [2 * frames[-1] - last_but_one]])
    # A single frame needs two more points to carry a cubic.
    points = np.concatenate([points, np.repeat(points[-1:], max(0, _DEGREE + 1 - len(points)), 0)])
    knots = (np.arange(len(points) + _DEGREE + 1) - _DEGREE) * dt
    return BSpline(knots, points, _DEGREE)


def _eased(duration: float, cycle_s: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Clock times (K,), the motion's own time there, its rate and the rate's change.

    The rate rises from 0 to 1 as 3 x^2 - 2 x^3 over the first 0.3 s, and falls likewise over the last.
    """
    window = min(_EASE_S, duration)
    total = duration + window
    times = np.append(np.arange(0.0, total, cycle_s), total)
    if window == 0:
        return times, np.zeros_like(times), np.zeros_like(times), np.zeros_like(times)
    early, late = np.clip(times / window, 0, 1), np.clip((total - times) / window, 0, 1)
    phase = np.where(
        times < total / 2,
        window * (early**3 - early**4 / 2) + np.maximum(times - window, 0),
        duration - window * (late**3 - late**4 / 2) - np.maximum(total - times - window, 0),
    )
    rate = early**2 * (3 - 2 * early) * late**2 * (3 - 2 * late)
    change = 6 * (early * (1 - early) - late * (1 - late)) / window
    return times, phase, rate, change


def _check(rig: Rig, frames: Floats, times: Floats, velocity: Floats, acceleration: Floats) -> None:
    excess = np.maximum(rig.lower - frames, frames - rig.upper) - rig.tick
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


def ramp(start: Floats, end: Floats, *, speed: float, acceleration: Floats, cycle_s: float) -> Floats:
    """Minimum-jerk goals (K, N) from rest at `start` to rest at `end`, nowhere faster than `speed` rad/s.

    No joint exceeds its `acceleration` (N,) rad/s^2 either. Source: Flash and Hogan 1985; for
    x = d (10 s^3 - 15 s^4 + 6 s^5) the peak speed is 15/8 d / T, the peak acceleration 10/sqrt(3) d / T^2.
    """
    distance = np.abs(end - start)
    seconds = np.maximum(15 / 8 * distance / speed, np.sqrt(10 / np.sqrt(3) * distance / acceleration))
    cycles = max(1, int(np.ceil(seconds.max(initial=0.0) / cycle_s)))
    s = np.arange(1, cycles + 1)[:, None] / cycles
    return start + (end - start) * s**3 * (10 - 15 * s + 6 * s**2)
