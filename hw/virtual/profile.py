"""The reference that the firmware makes of a goal position: at once, or limited in speed and acceleration.

Source: ROBOTIS e-Manual, X series, "What is the Profile".
"""

import math
from dataclasses import dataclass

STEP, RECTANGULAR, TRIANGULAR, TRAPEZOIDAL = 0, 1, 2, 3
"""Kinds of profile, as Moving Status has them."""


@dataclass
class Profile:
    """A reference on its way to `goal`, in rad and rad/s.

    Attributes:
        speed: rad/s; 0 is at once.
        acceleration: rad/s^2; 0 is without limit.
    """

    position: float = 0.0
    velocity: float = 0.0
    goal: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    kind: int = STEP

    def head_for(self, goal: float, *, speed: float, acceleration: float) -> None:
        """A new goal under a bound of speed and acceleration (velocity-based profile)."""
        self.goal, self.speed, self.acceleration = goal, speed, acceleration
        if speed <= 0:
            self.kind = STEP
        elif acceleration <= 0:
            self.kind = RECTANGULAR
        else:
            reaches_speed = abs(goal - self.position) >= speed**2 / acceleration
            self.kind = TRAPEZOIDAL if reaches_speed else TRIANGULAR

    def arrive_in(self, goal: float, *, total_s: float, rise_s: float) -> None:
        """A new goal `total_s` from now, the first and last `rise_s` spent on changing speed (time-based profile)."""
        rise_s = min(rise_s, total_s / 2)
        distance = abs(goal - self.position)
        speed = distance / (total_s - rise_s) if total_s > 0 else 0.0
        self.head_for(goal, speed=speed, acceleration=speed / rise_s if rise_s > 0 else 0.0)

    @property
    def done(self) -> bool:
        """Whether the reference has arrived."""
        return self.position == self.goal

    def advance(self, dt: float) -> None:
        """Move the reference on by `dt` s."""
        if self.speed <= 0:
            self.position, self.velocity = self.goal, 0.0
            return
        distance = self.goal - self.position
        limit = self.speed
        if self.acceleration > 0:
            # The speed from which the rest of the way suffices to stop, half a step ahead.
            braking = self.acceleration * dt / 2
            limit = min(limit, math.sqrt(2 * self.acceleration * abs(distance) + braking**2) - braking)
        change = math.copysign(limit, distance) - self.velocity
        if self.acceleration > 0:
            change = max(-self.acceleration * dt, min(self.acceleration * dt, change))
        self.velocity += change
        step = self.velocity * dt
        # A reference that is too fast to stop at the goal passes it and comes back.
        stops = self.acceleration <= 0 or abs(self.velocity) <= 2 * self.acceleration * dt
        if stops and abs(distance) <= max(abs(step), self.acceleration * dt * dt):
            self.position, self.velocity = self.goal, 0.0
        else:
            self.position += step
