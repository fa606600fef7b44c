"""Goals of a rig's servos from a path on their cycle, and the ramp that leads there; limits are checked, not made."""

import numpy as np

from hw.rig import Rig
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import Floats, RobotTrajectory

_ROUNDING = 1e-3
"""Relative excess over a limit that is rounding and no fault."""


def goals_of(path: RobotTrajectory, rig: Rig) -> Floats:
    """(K, N) rad in the rig's joint order, one goal a servo cycle: the frames of a servo path as they are.

    Raises:
        ModelMismatch: the path lacks a joint of the rig, or is not on its cycle.
        UnsafeCommand: the path breaks the range, speed or acceleration limit of a joint; names the worst.
    """
    missing = [joint for joint in rig.joints if joint not in path.joint_names]
    if missing:
        raise ModelMismatch(f"the trajectory of {path.robot} has no joint {', '.join(missing)}")
    if abs(path.fps * rig.cycle_s - 1) > _ROUNDING:
        raise ModelMismatch(f"the path has {path.fps:g} frames a second, the servos {1 / rig.cycle_s:g} cycles")
    goals = path.joint_pos[:, [path.joint_names.index(joint) for joint in rig.joints]]
    _check_range(rig, goals)
    # It comes from rest and ends at rest.
    still = np.concatenate([goals[:1], goals[:1], goals, goals[-1:], goals[-1:]])
    steps = np.diff(still, axis=0) / rig.cycle_s
    _check_rate(rig, steps, rig.velocity, "speed", "rad/s")
    _check_rate(rig, np.diff(steps, axis=0) / rig.cycle_s, rig.acceleration, "acceleration", "rad/s^2")
    return goals


def _check_range(rig: Rig, goals: Floats) -> None:
    excess = np.maximum(rig.lower - goals, goals - rig.upper) - rig.tick
    if (excess > 0).any():
        k, joint = np.unravel_index(int(excess.argmax()), excess.shape)
        raise UnsafeCommand(
            f"{rig.label(int(joint))} goes to {goals[k, joint]:.3f} rad at {k * rig.cycle_s:.2f} s, "
            f"range {rig.lower[joint]:.3f} to {rig.upper[joint]:.3f} rad"
        )


def _check_rate(rig: Rig, values: Floats, limit: Floats, name: str, unit: str) -> None:
    ratio = np.abs(values) / limit
    k, joint = np.unravel_index(int(ratio.argmax()), ratio.shape)
    if ratio[k, joint] > 1 + _ROUNDING:
        raise UnsafeCommand(
            f"{rig.label(int(joint))} reaches {name} {abs(values[k, joint]):.2f} {unit} at {k * rig.cycle_s:.2f} s, "
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
