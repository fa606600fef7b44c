"""Numbers about trunk, head and shoulders in a window of a motion."""

from functools import cached_property

import numpy as np

from generator.probes.cycles import cycles, longest_run, rises, span
from generator.probes.signals import Signals
from ros_free_stack.skeleton import FPS


class TrunkMeasures:
    """How the trunk leans and twists, the head nods and turns, and the shoulders rise, in a window."""

    def __init__(self, signals: Signals, window: slice) -> None:
        self._signals, self._window = signals, window
        self._pitch, self._roll, self._twist = signals.pitch[window], signals.roll[window], signals.twist[window]
        self._nod, self._shake = signals.head_pitch[window], signals.head_yaw[window]
        self._look = self._shake + self._twist
        self._level = float(np.mean([*self._nod[:3], *self._nod[-3:]]))

    @cached_property
    def pitch_high(self) -> float:
        return float(self._pitch.max())

    @cached_property
    def pitch_low(self) -> float:
        return float(self._pitch.min())

    @cached_property
    def pitch_mid(self) -> float:
        return float(np.median(self._pitch))

    @cached_property
    def pitch_range(self) -> float:
        return float(np.ptp(self._pitch))

    @cached_property
    def roll_high(self) -> float:
        return float(self._roll.max())

    @cached_property
    def roll_low(self) -> float:
        return float(self._roll.min())

    @cached_property
    def roll_range(self) -> float:
        return float(np.ptp(self._roll))

    @cached_property
    def twist_high(self) -> float:
        return float(self._twist.max())

    @cached_property
    def twist_low(self) -> float:
        return float(self._twist.min())

    @cached_property
    def twist_range(self) -> float:
        return float(np.ptp(self._twist))

    @cached_property
    def twists(self) -> float:
        """How often the shoulders turn to the left against the hips."""
        return float(rises(self._twist, 15.0, least=8.0))

    @cached_property
    def nod_high(self) -> float:
        return float(self._nod.max() - self._level)

    @cached_property
    def nod_low(self) -> float:
        return float(self._nod.min() - self._level)

    @cached_property
    def nods(self) -> float:
        return float(rises(self._nod, max(6.0, 0.35 * float(np.ptp(self._nod)))))

    @cached_property
    def nod_range(self) -> float:
        return float(np.ptp(self._nod))

    @cached_property
    def shake_range(self) -> float:
        return float(np.ptp(self._shake))

    @cached_property
    def nod_hold(self) -> float:
        """The longest that the head stays down, s."""
        start, stop = longest_run(self._nod - self._level > 0.7 * self.nod_high)
        return (stop - start) / FPS

    @cached_property
    def shake_high(self) -> float:
        return float(self._shake.max() - np.median(self._shake))

    @cached_property
    def shake_low(self) -> float:
        return float(self._shake.min() - np.median(self._shake))

    @cached_property
    def shakes(self) -> float:
        """How often the head turns to the left and to the right."""
        turns = max(3.0, 0.35 * self.shake_range)
        return float(cycles(self._shake, turns))

    @cached_property
    def look_high(self) -> float:
        return float(self._look.max())

    @cached_property
    def look_low(self) -> float:
        return float(self._look.min())

    @cached_property
    def looks(self) -> float:
        """How often the head turns far to a side."""
        return float(rises(self._look, 20.0, least=15.0) + rises(-self._look, 20.0, least=15.0))

    @cached_property
    def shrug(self) -> float:
        return span(self._signals.shoulders[self._window])

    @cached_property
    def shrugs(self) -> float:
        return float(rises(self._signals.shoulders[self._window], 0.035))
