"""How far joints may move in the next frame: range, speed and acceleration limits that can always be kept.

A joint that moves toward the end of its range must begin to brake in time. With the largest change of step per frame
a = acceleration dt^2, a joint that has just made a step v stops within less than v^2 / (2a), so a step is allowed only
where v + v^2 / (2a) stays within the distance left. Braking by `a` a frame then always satisfies the next frame's
bound, also where the frames' length changes: the limits never contradict each other.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from retarget.body.geometry import RobotGeometry
from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robots import RobotDescription

MARGIN = 1e-9
"""Relative margin against rounding."""
AT_LIMIT = 1e-5
"""Distance in rad from a limit of a joint, its step or its change of step, at which it counts as held by it."""

ROOT_SPEED = (8.0, 12.0)
ROOT_ACCELERATION = (50.0, 150.0)
"""Limits of the root: leg lengths and rad, a second and a second^2. A person's hips stay below in all but falls;
without them the root would make up by a jump for whatever the joints' limits deny a limb."""


@dataclass(frozen=True)
class JointBounds:
    """Limits of J joints at a frame rate: range (rad), step (rad a frame) and change of step (rad a frame^2)."""

    lower: Floats
    upper: Floats
    step: Floats
    change: Floats

    @classmethod
    def of(cls, robot: RobotDescription, fps: float) -> "JointBounds":
        """The robot's limits at `fps` frames a second."""
        keep = 1 - MARGIN
        return cls(robot.lower, robot.upper, robot.velocity / fps * keep, robot.acceleration / fps**2 * keep)

    @classmethod
    def tangent(cls, geometry: RobotGeometry, fps: float) -> "JointBounds":
        """The limits of a tangent vector (nv,) at `fps`: the joints', and the root's, which has no range.

        The root of a robot that is mounted by it does not move, nor does a joint that follows others by its own step.
        """
        joints, size, dofs = cls.of(geometry.robot, fps), geometry.model.nv, geometry.dof_index
        lower, upper, step, change = (np.zeros(size) for _ in range(4))
        lower[dofs], upper[dofs], step[dofs], change[dofs] = joints.lower, joints.upper, joints.step, joints.change
        if not geometry.held:
            unit = np.repeat([geometry.limb_length, 1.0], 3)
            lower[:6], upper[:6] = -np.inf, np.inf
            step[:6] = np.repeat(ROOT_SPEED, 3) * unit / fps
            change[:6] = np.repeat(ROOT_ACCELERATION, 3) * unit / fps**2
        return cls(lower, upper, step, change)

    @property
    def table(self) -> Floats:
        """(J, 4): lower, upper, step, change."""
        return np.stack([self.lower, self.upper, self.step, self.change], axis=1)


def active_limits(robot: RobotDescription, joints: Floats, fps: float) -> dict[str, Bools]:
    """(N, J) whether each joint of a trajectory (N, J) is at the limit of its range, speed or acceleration, by name."""
    bounds = JointBounds.of(robot, fps)
    step = np.diff(joints, axis=0, prepend=joints[:1])
    change = np.diff(step, axis=0, prepend=step[:1])
    return {
        "range": (joints <= bounds.lower + AT_LIMIT) | (joints >= bounds.upper - AT_LIMIT),
        "speed": np.abs(step) >= bounds.step - AT_LIMIT,
        "acceleration": np.abs(change) >= bounds.change - AT_LIMIT,
    }


def reach(position: ca.SX, step: ca.SX, table: ca.SX) -> tuple[ca.SX, ca.SX]:
    """(J,) least and largest allowed next step from `position`, reached with the last `step`, by `JointBounds.table`.

    CasADi expressions, or its numbers.
    """
    lower, upper, most, change = ca.horzsplit(table)
    # Rounding may leave a joint beside its range or its speed; braking is allowed all the same.
    brake = step - ca.fmin(ca.fmax(step, -change), change)
    up = ca.fmin(most, _stopping(upper - position, change))
    down = ca.fmax(-most, -_stopping(position - lower, change))
    high = ca.fmax(ca.fmin(up, step + change), brake)
    low = ca.fmin(ca.fmax(down, step - change), brake)
    return ca.fmax(low, lower - position), ca.fmin(high, upper - position)


def _stopping(distance: ca.SX, change: ca.SX) -> ca.SX:
    """(J,) largest step after which a joint can still stop within `distance`."""
    return ca.sqrt(change**2 + 2 * change * ca.fmax(distance, 0.0)) - change
