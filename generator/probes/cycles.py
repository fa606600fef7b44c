"""How often something happens: turning points of a signal."""

import numpy as np
from scipy.signal import find_peaks

from generator.probes.signals import Floats


def peaks(signal: Floats, prominence: float, *, least: float = -np.inf) -> Floats:
    """Frames of maxima that rise by `prominence` over both sides and reach `least`; one at an edge counts not."""
    if len(signal) < 3:
        return np.zeros(0)
    return find_peaks(signal, prominence=prominence, height=None if np.isinf(least) else least)[0].astype(float)


def rises(signal: Floats, prominence: float, *, least: float = -np.inf) -> int:
    """How many maxima there are, those at the edges of the window too."""
    low = signal.min() - 2 * prominence
    return len(peaks(np.concatenate([[low], signal, [low]]), prominence, least=least))


def cycles(signal: Floats, prominence: float) -> int:
    """How many full swings to and fro: half of the turning points."""
    turns = len(peaks(signal, prominence)) + len(peaks(-signal, prominence))
    return (turns + 1) // 2


def runs(mask: np.ndarray) -> list[tuple[int, int]]:
    """Spans [start, stop) of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(int), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def longest_run(mask: np.ndarray) -> tuple[int, int]:
    """The longest of the `runs`; (0, 0) where there is none."""
    return max(runs(mask), key=lambda run: run[1] - run[0], default=(0, 0))


def span(signal: Floats) -> float:
    """From low to high without the outermost frames, so that no single one decides."""
    low, high = np.percentile(signal, [3, 97])
    return float(high - low)
