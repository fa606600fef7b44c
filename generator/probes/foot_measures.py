"""Numbers about one foot in a window of a motion: how high, how far, how often."""

from functools import cached_property

import numpy as np

from generator.probes.cycles import rises, runs
from generator.probes.signals import Foot
from ros_free_stack.skeleton import FPS

_SWING = 0.045  # leg lengths: a toe that high is on its way


class FootMeasures:
    """One foot in a window."""

    def __init__(self, foot: Foot, floor: float, window: slice) -> None:
        self._toe, self._heel, self._knee = foot.toe[window] - floor, foot.heel[window], foot.knee[window]
        self._place, self._foot, self._window = foot.place[window], foot, window

    @cached_property
    def _spans(self) -> list[tuple[int, int]]:
        return [(a, b) for a, b in runs(self._toe > _SWING) if b - a >= 2]

    @cached_property
    def _top(self) -> int:
        return int(np.argmax(self._toe))

    @cached_property
    def toe(self) -> float:
        return float(self._toe.max())

    @cached_property
    def heel(self) -> float:
        return float(self._heel.max())

    @cached_property
    def knee_at_top(self) -> float:
        """Bend of the knee when the foot is highest."""
        return float(self._knee[self._top])

    @cached_property
    def straightest(self) -> float:
        """The least bend of the knee while the foot is at least at three quarters of its height."""
        return float(self._knee[self._toe >= 0.75 * self.toe].min())

    @cached_property
    def aside_at_top(self) -> float:
        """The furthest aside while the foot is at least at three quarters of its height."""
        return float(self._place[self._toe >= 0.75 * self.toe, 1].max())

    @cached_property
    def reaches(self) -> float:
        """How often the foot goes far to the front or to the side."""
        return float(rises(self._place[:, :2].max(axis=1), 0.25, least=0.35))

    @cached_property
    def swings(self) -> float:
        """How often the foot goes to the front from behind."""
        return float(rises(self._place[:, 0], 0.25, least=0.15))

    @cached_property
    def knee_low(self) -> float:
        return float(self._foot.knee_height[self._window].min())

    @cached_property
    def knee_high(self) -> float:
        return float(self._foot.knee_height[self._window].max())

    @cached_property
    def thigh(self) -> float:
        return float(self._foot.thigh[self._window].max())

    @cached_property
    def speed(self) -> float:
        return float(self._foot.speed[self._window].max())

    @cached_property
    def drop(self) -> float:
        """The fastest way down, leg lengths a second."""
        return float(np.max(-np.gradient(self._toe))) * FPS

    @cached_property
    def front(self) -> float:
        return float(self._place[:, 0].max())

    @cached_property
    def behind(self) -> float:
        return float(self._place[:, 0].min())

    @cached_property
    def aside(self) -> float:
        return float(self._place[:, 1].max())

    @cached_property
    def lifts(self) -> float:
        return float(len(self._spans))

    @cached_property
    def longest_up(self) -> float:
        """Seconds."""
        return max((b - a for a, b in self._spans), default=0) / FPS

    @cached_property
    def kicks(self) -> float:
        """How often the foot is lifted high."""
        return float(rises(self._toe, max(0.1, 0.5 * self.toe), least=0.6 * self.toe))

    @cached_property
    def lunges(self) -> float:
        """How often the foot is far in front of the hip."""
        return float(rises(self._place[:, 0], 0.25, least=0.3))
