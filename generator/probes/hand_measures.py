"""Numbers about one hand in a window of a motion: where it acts, how often it goes where, what it comes near."""

from functools import cached_property

import numpy as np

from generator.probes.cycles import longest_run, peaks, rises, span
from generator.probes.signals import SIGN, Floats, Hand
from ros_free_stack.skeleton import FPS

_FAR = 0.75  # share of the furthest distance from rest at which a hand is where it acts


class HandMeasures:
    """One hand in a window. It acts where it is furthest from hanging; `mid` are these frames."""

    def __init__(self, hand: Hand, side: str, twist: Floats, window: slice) -> None:
        self._sign, self._twist = SIGN[side], twist[window]
        self._place, self._lift, self._speed = hand.place[window], hand.lift[window], hand.speed[window]
        self._away, self._extension = hand.away[window], hand.extension[window]
        self._hand, self._window = hand, window

    @cached_property
    def _far(self) -> np.ndarray:
        return self._away >= _FAR * self.away

    @cached_property
    def _core(self) -> Floats:
        """Its places from when it gets there to when it leaves."""
        mid = np.flatnonzero(self._far)
        return self._place[mid[0] : mid[-1] + 1]

    @cached_property
    def _still(self) -> int:
        """The frame in which the acting hand is slowest."""
        mid = np.flatnonzero(self._far)
        return int(mid[np.argmin(self._speed[mid])])

    @cached_property
    def away(self) -> float:
        return float(np.percentile(self._away, 97))

    @cached_property
    def active(self) -> float:
        """Seconds."""
        return float(self._far.sum()) / FPS

    @cached_property
    def hold(self) -> float:
        """Seconds near the stillest place."""
        return float((np.linalg.norm(self._place - self._place[self._still], axis=-1) < 0.15).sum()) / FPS

    @cached_property
    def extension(self) -> float:
        return float(np.median(self._extension[self._far]))

    @cached_property
    def longest(self) -> float:
        return float(np.percentile(self._extension, 98))

    @cached_property
    def shortest(self) -> float:
        return float(self._extension[self._far].min())

    @cached_property
    def folded(self) -> float:
        """The least extension of the arm."""
        return float(self._extension.min())

    @cached_property
    def hip_hold(self) -> float:
        """Seconds at the hip with the elbow bent."""
        at_hip = (self._hand.to_hip[self._window] < 0.55) & (self._extension < 0.87)
        start, stop = longest_run(at_hip)
        return (stop - start) / FPS

    @cached_property
    def lift(self) -> float:
        return float(np.median(self._lift[self._far]))

    @cached_property
    def top(self) -> float:
        return float(np.percentile(self._lift, 98))

    @cached_property
    def speed(self) -> float:
        return float(np.percentile(self._speed, 98))

    @cached_property
    def thrust(self) -> float:
        """The fastest stretching of the arm, arm lengths a second."""
        return float(np.max(np.gradient(self._extension))) * FPS

    @cached_property
    def front(self) -> float:
        return float(self._place[:, 0].max())

    @cached_property
    def back(self) -> float:
        return float(self._place[:, 0].min())

    @cached_property
    def x(self) -> float:
        return float(np.median(self._place[self._far, 0]))

    @cached_property
    def y(self) -> float:
        return float(np.median(self._place[self._far, 1]))

    @cached_property
    def still_x(self) -> float:
        return float(self._place[self._still, 0])

    @cached_property
    def still_y(self) -> float:
        return float(self._place[self._still, 1])

    @cached_property
    def still_z(self) -> float:
        return float(self._place[self._still, 2])

    @cached_property
    def azimuth(self) -> float:
        """Where the still hand points, deg to the left of where the hips face."""
        return float(np.degrees(np.arctan2(self._sign * self.still_y, self.still_x)) + self._twist[self._still])

    @cached_property
    def range_x(self) -> float:
        return span(self._core[:, 0])

    @cached_property
    def range_y(self) -> float:
        return span(self._core[:, 1])

    @cached_property
    def range_z(self) -> float:
        return span(self._core[:, 2])

    def _swings(self, axis: int, sign: float, least: float, share: float = 0.4) -> float:
        values = self._core[:, axis]
        return float(len(peaks(sign * values, max(least, share * span(values)))))

    @cached_property
    def ins(self) -> float:
        """Swings inwards between two places further out."""
        return self._swings(1, -1, 0.04)

    @cached_property
    def pulls(self) -> float:
        """Swings back towards the chest between two places further in front."""
        return self._swings(0, -1, 0.04)

    @cached_property
    def downs(self) -> float:
        """Swings down between two higher places."""
        return self._swings(2, -1, 0.045, 0.0)

    @cached_property
    def ups(self) -> float:
        """Swings up between two lower places."""
        return self._swings(2, 1, 0.04, 0.0)

    @cached_property
    def strokes(self) -> float:
        """How often the arm gets straight."""
        return float(rises(self._extension, 0.15, least=0.8))

    @cached_property
    def pushes(self) -> float:
        """How often the hand goes out to the front."""
        return float(rises(self._place[:, 0], 0.15, least=0.75))

    @cached_property
    def fronts(self) -> float:
        """How often the hanging arm swings to the front."""
        return float(rises(self._place[:, 0], 0.45, least=0.25))

    @cached_property
    def tops(self) -> float:
        """How often the hand comes over the shoulder from below."""
        return float(rises(self._lift, 0.5, least=0.2))

    @cached_property
    def flaps(self) -> float:
        return float(rises(self._lift, 0.25, least=0.0))

    @cached_property
    def lift_range(self) -> float:
        return span(self._lift)

    @cached_property
    def pulses(self) -> float:
        """How often the straight arm goes up."""
        return float(rises(self._lift, 0.45, least=-0.3))

    @cached_property
    def pulses_x(self) -> float:
        """How often the raised hand goes forward and back."""
        return float(len(peaks(self._core[:, 0], 0.08)))

    @cached_property
    def curls(self) -> float:
        """How often the hand goes far up."""
        return float(rises(self._lift, 0.4, least=-0.4))

    @cached_property
    def bites(self) -> float:
        """How often the hand comes to the head."""
        return float(rises(-self._hand.to_head[self._window], 0.2, least=-0.6))

    @cached_property
    def to_head(self) -> float:
        return float(self._hand.to_head[self._window][self._far].min())

    @cached_property
    def head_mid(self) -> float:
        return float(np.median(self._hand.to_head[self._window][self._far]))

    @cached_property
    def hip_mid(self) -> float:
        return float(np.median(self._hand.to_hip[self._window][self._far]))

    @cached_property
    def to_chest(self) -> float:
        return float(np.median(self._hand.to_chest[self._window][self._far]))

    @cached_property
    def floor(self) -> float:
        return float(self._hand.floor[self._window].min())
