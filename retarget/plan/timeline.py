"""When the robot performs which moment of the human clip: it stands, eases in, follows, eases out, and stands again."""

from dataclasses import dataclass

import numpy as np

from ros_free_stack.messages import Bools, Floats

HOLD_S = 0.5
EASE_S = 0.8


@dataclass(frozen=True)
class Pace:
    """A monotone map between the robot's time and the human's: `robot_s` (K,) and `human_s` (K,), both from 0."""

    robot_s: Floats
    human_s: Floats

    @property
    def duration_s(self) -> float:
        return float(self.robot_s[-1])

    @property
    def slowdown(self) -> float:
        """The robot's time over the human's."""
        human = float(self.human_s[-1])
        return self.duration_s / human if human > 0 else 1.0

    def moments(self, robot_s: Floats) -> Floats:
        """The human's time at the robot's."""
        return np.interp(robot_s, self.robot_s, self.human_s)


@dataclass(frozen=True)
class Timeline:
    """The robot's frames.

    Attributes:
        fps: frames a second.
        human_s: (N,) moment of the human clip that each frame follows.
        weight: (N,) 0 where the robot stands in its own pose, 1 where it follows the human.
        hold: (N,) whether the robot stands still before or after the motion.
    """

    fps: float
    human_s: Floats
    weight: Floats
    hold: Bools

    def __len__(self) -> int:
        return len(self.human_s)


def minimum_jerk(phase: Floats) -> Floats:
    """From 0 to 1 with zero speed and acceleration at both ends (Flash and Hogan 1985); clipped outside [0, 1]."""
    x = np.clip(phase, 0.0, 1.0)
    return x**3 * (10 - 15 * x + 6 * x**2)


def plan_timeline(pace: Pace, fps: float) -> Timeline:
    """A timeline for a clip that is followed at a pace.

    The human's time starts at rate zero and reaches its own rate at the end of the easing, so that a clip that is cut
    in full motion still starts and ends at rest.
    """
    duration_s = pace.duration_s
    eased = min(duration_s, EASE_S) / 2
    length = 2 * HOLD_S + 2 * EASE_S + duration_s - 2 * eased
    # The robot's frames do not divide the clip exactly: time runs up to half a frame faster or slower over the clip.
    times = np.linspace(0, length, round(length * fps) + 1)
    since, until = (times - HOLD_S) / EASE_S, (length - HOLD_S - times) / EASE_S
    human = np.where(
        since < 1,
        2 * eased * _smoothstep_integral(since),
        np.where(
            until < 1,
            duration_s - 2 * eased * _smoothstep_integral(until),
            eased + (times - HOLD_S - EASE_S),
        ),
    )
    weight = minimum_jerk(since) * minimum_jerk(until)
    return Timeline(fps, pace.moments(np.clip(human, 0, duration_s)), weight, (since <= 0) | (until <= 0))


def _smoothstep_integral(phase: Floats) -> Floats:
    """Integral of 3x^2 - 2x^3 from 0: ends at 1/2 with slope 1."""
    x = np.clip(phase, 0.0, 1.0)
    return x**3 - x**4 / 2
