"""Keyed tracks: piecewise quintic curves between the keys that actions write.

A rest-to-rest quintic is the minimum-jerk movement of Flash and Hogan (1985). Keys in between are passed at a velocity
derived from their neighbours (harmonic mean, as in monotone interpolation), so that a track never overshoots by much.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from generator.corpus.body import Floats


@dataclass(frozen=True)
class Key:
    """A value (C,) at a time in s; `velocity` (C,) or None to derive it."""

    time: float
    value: Floats
    velocity: Floats | None = None


class Track:
    """A curve of C channels, written in temporal order; it keeps its first value before and its last one after."""

    def __init__(self, value: ArrayLike, skew: np.random.Generator | None = None) -> None:
        """`skew` draws a velocity profile of its own for each channel of each move: no two joints arrive together."""
        value = np.atleast_1d(np.asarray(value, dtype=float))
        self._skew_seed = None if skew is None else int(skew.integers(2**32))
        self.keys: list[Key] = [Key(0.0, value, np.zeros_like(value))]

    @property
    def last(self) -> Floats:
        """The latest value."""
        return self.keys[-1].value.copy()

    @property
    def end(self) -> float:
        """Time of the latest key, in s."""
        return self.keys[-1].time

    def key(self, time: float, value: ArrayLike, velocity: ArrayLike | None = None) -> None:
        """Add a key; keys at and after its time give way to it."""
        while len(self.keys) > 1 and self.keys[-1].time >= time - 1e-6:
            self.keys.pop()
        time = max(time, self.keys[-1].time + 1e-3)
        value = np.broadcast_to(np.asarray(value, dtype=float), self.keys[0].value.shape).copy()
        rate = None if velocity is None else np.broadcast_to(np.asarray(velocity, dtype=float), value.shape)
        self.keys.append(Key(time, value, rate))

    def hold(self, time: float) -> None:
        """Stay at the latest value, at rest, until `time`."""
        if time > self.end + 1e-6:
            self.key(time, self.last, 0.0)

    def move(self, start: float, *keys: tuple[float, ArrayLike]) -> None:
        """Stay until `start`, pass through the keys in turn and come to rest at the last one."""
        self.hold(start)
        for time, value in keys[:-1]:
            self.key(time, value)
        time, value = keys[-1]
        self.key(time, value, 0.0)

    def sample(self, times: Floats) -> Floats:
        """Values (T, C) at times (T,)."""
        knots = np.array([key.time for key in self.keys])
        values = np.stack([key.value for key in self.keys])
        if len(knots) == 1:
            return np.repeat(values, len(times), axis=0)
        rates = self._velocities(knots, values)
        i = np.clip(np.searchsorted(knots, times, "right") - 1, 0, len(knots) - 2)
        span = (knots[i + 1] - knots[i])[:, None]
        s = np.clip((times - knots[i])[:, None] / span, 0.0, 1.0)
        if self._skew_seed is not None:
            draws = np.random.default_rng(self._skew_seed).normal(-0.02, 0.07, values.shape)
            s = s + np.clip(draws, -0.18, 0.18)[i] * 16 * s**2 * (1 - s) ** 2
        change, a, b = values[i + 1] - values[i], rates[i] * span, rates[i + 1] * span
        cubic = 10 * change - 6 * a - 4 * b
        quartic = -15 * change + 8 * a + 7 * b
        return values[i] + s * (a + s**2 * (cubic + s * (quartic + s * (6 * change - 3 * a - 3 * b))))

    def _velocities(self, knots: Floats, values: Floats) -> Floats:
        """(K, C) velocity at each key: the given one, or from the slopes on either side; zero at a turning point."""
        slopes = np.diff(values, axis=0) / np.diff(knots)[:, None]
        before, after = slopes[:-1], slopes[1:]
        same = before * after > 0
        total = np.where(same, before + after, 1.0)
        mean = np.where(same, 2 * before * after / total, 0.0)
        limit = 1.5 * np.minimum(np.abs(before), np.abs(after)) + 0.25 * np.abs(mean)
        rates = np.zeros_like(values)
        rates[1:-1] = np.sign(mean) * np.minimum(1.25 * np.abs(mean), limit)
        for i, key in enumerate(self.keys):
            if key.velocity is not None:
                rates[i] = key.velocity
        return rates


class LinearTrack(Track):
    """A track that runs straight from key to key: the path of the weight from foot to foot."""

    def sample(self, times: Floats) -> Floats:
        knots = [key.time for key in self.keys]
        values = np.stack([key.value for key in self.keys])
        return np.stack([np.interp(times, knots, column) for column in values.T], -1)
