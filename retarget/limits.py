"""How far joints may move in the next frame: range, speed and acceleration limits that can always be kept.

A joint that moves toward the end of its range must begin to brake in time. With the largest change of step per frame
a = acceleration dt^2, a joint that has just made a step v still needs at most (v - a/2)^2 / (2a) to stop, so a step is
allowed only where v + (v - a/2)^2 / (2a) stays within the distance left. Braking by `a` a frame then always satisfies
the next frame's bound: the limits never contradict each other.
"""

from dataclasses import dataclass

import numpy as np

from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription

MARGIN = 1e-9
"""Relative margin against rounding."""


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

    def reach(self, position: Floats, step: Floats) -> tuple[Floats, Floats]:
        """(J,) lowest and highest allowed next positions after `position`, reached with the last step `step`."""
        up = np.minimum(self.step, self._stopping(self.upper - position))
        down = -np.minimum(self.step, self._stopping(position - self.lower))
        brake = np.sign(step) * np.maximum(np.abs(step) - self.change, 0)
        high = np.maximum(np.minimum(up, step + self.change), brake)
        low = np.minimum(np.maximum(down, step - self.change), brake)
        return np.maximum(position + low, self.lower), np.minimum(position + high, self.upper)

    def _stopping(self, distance: Floats) -> Floats:
        """(J,) largest step after which the joint can still stop within `distance`."""
        distance = np.maximum(distance, 0.0)
        braking = np.sqrt(2 * self.change * distance) - self.change / 2
        return np.maximum(braking, np.minimum(distance, self.change))
