"""What keeps a standing or moving person from looking like a machine: who performs, sway, tremor, loose arms."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter1d

from generator.corpus.body import Floats


def clipped_normal(rng: np.random.Generator) -> float:
    """A standard normal draw within two standard deviations."""
    return float(np.clip(rng.standard_normal(), -2.0, 2.0))


@dataclass(frozen=True)
class Performer:
    """One person's posture and manner, constant over a scene.

    Attributes:
        pelvis, spine, neck: habitual offsets (3,) in rad.
        stance: half the distance between the feet, m.
        sway: factor on all slow noise.
        looseness: how far free arms lag behind the shoulders; 1 is ordinary.
        swing: arm swing in walking, rad a metre between the feet.
        pelvis_yaw, chest_yaw: turn of pelvis and chest, rad a metre between the feet.
    """

    pelvis: Floats
    spine: Floats
    neck: Floats
    stance: float
    sway: float
    looseness: float
    swing: float
    pelvis_yaw: float
    chest_yaw: float

    @classmethod
    def draw(cls, rng: np.random.Generator) -> "Performer":
        """A person; spreads after captured standing poses."""

        def degrees(*spread: float) -> Floats:
            return np.radians([s * clipped_normal(rng) for s in spread])

        return cls(
            pelvis=degrees(1.0, 3.5, 0.0),
            spine=degrees(1.5, 4.5, 1.5),
            neck=degrees(2.0, 5.0, 3.0),
            stance=0.095 + 0.018 * clipped_normal(rng),
            sway=float(np.exp(0.28 * clipped_normal(rng))),
            looseness=float(np.clip(1 + 0.5 * clipped_normal(rng), 0.2, 2.0)),
            swing=0.46 * (1 + 0.25 * clipped_normal(rng)),
            pelvis_yaw=0.085 * (1 + 0.2 * clipped_normal(rng)),
            chest_yaw=0.24 * (1 + 0.2 * clipped_normal(rng)),
        )


class Noise:
    """Seeded coloured noise on one time grid."""

    def __init__(self, rng: np.random.Generator, count: int, rate: float, scale: float) -> None:
        self._rng, self._times, self._rate, self._scale = rng, np.arange(count) / rate, rate, scale
        self._waves: dict[tuple[float, float], tuple[Floats, Floats]] = {}

    def draw(self, *amplitudes: float, band: tuple[float, float] = (0.06, 1.1)) -> Floats:
        """(T, len(amplitudes)) independent channels of the given RMS, power falling with frequency (Hz) in `band`."""
        if band not in self._waves:
            self._waves[band] = self._band(*band)
        sines, cosines = self._waves[band]
        phase = self._rng.uniform(0, 2 * np.pi, (len(amplitudes), 9))
        waves = sines @ np.cos(phase).T + cosines @ np.sin(phase).T  # the sine of a sum, for all phases at once
        return waves * (np.asarray(amplitudes) * self._scale)

    def _band(self, low: float, high: float) -> tuple[Floats, Floats]:
        """(T, 9) sines and cosines of nine frequencies, weighted so that a sum of them has RMS one."""
        frequency = np.geomspace(low, high, 9)
        weight = frequency**-0.6
        weight /= np.sqrt((weight**2).sum() / 2)
        angle = np.multiply.outer(2 * np.pi * self._times, frequency)
        return np.sin(angle) * weight, np.cos(angle) * weight

    def tremor(self, values: Floats, *, gain: float | Floats, base: float | Floats) -> Floats:
        """`values` (T, C) plus signal-dependent noise of 1.2 to 6 Hz.

        Movement is corrected all the time, the more the faster it is (Harris and Wolpert, 1998): the RMS of a channel
        is `base` plus `gain` seconds times its speed.
        """
        speed = np.abs(np.gradient(values, axis=0)) * self._rate
        speed = gaussian_filter1d(speed, 0.10 * self._rate, axis=0, mode="nearest")
        return values + (gain * speed + base) * self.draw(*np.ones(values.shape[1]), band=(1.2, 6.0))


def pendulum(acceleration: Floats, rate: float) -> Floats:
    """(T,) angle of a damped pendulum (1 Hz, damping 0.35, 0.55 m) whose pivot accelerates by (T,) m/s^2."""
    from scipy.signal import lfilter  # slow to import, and the generator imports the actions to verify them

    omega, damping, length = 2 * np.pi, 0.35, 0.55
    a = [rate**2 + 2 * damping * omega * rate + omega**2, -2 * rate**2 - 2 * damping * omega * rate, rate**2]
    return np.asarray(lfilter([1 / a[0]], [1.0, a[1] / a[0], a[2] / a[0]], -acceleration / length))
