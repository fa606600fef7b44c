"""How often something happens: turning points of a signal."""

import numpy as np

from generator.probes.signals import Floats


def peaks(signal: Floats, prominence: float, *, least: float = -np.inf) -> Floats:
    """Frames of maxima that rise by `prominence` over both sides and reach `least`; one at an edge counts not.

    As `scipy.signal.find_peaks` has it, whose import takes longer than all of the judging of a motion.
    """
    if len(signal) < 3:
        return np.zeros(0)
    # Of several equal values in a row the middle one is the maximum.
    first = np.concatenate([[0], np.flatnonzero(np.diff(signal)) + 1])
    last = np.concatenate([first[1:] - 1, [len(signal) - 1]])
    values = signal[first]
    inside = values[1:-1]
    tops = 1 + np.flatnonzero((inside > values[:-2]) & (inside > values[2:]) & (inside >= least))
    kept = [top for top in tops.tolist() if values[top] - _base(values, top) >= prominence]
    return ((first[kept] + last[kept]) // 2).astype(float)


def _base(values: Floats, top: int) -> float:
    """The higher of the lowest values on either side of a maximum, each side up to where something is higher."""
    higher = np.flatnonzero(values > values[top])
    split = np.searchsorted(higher, top)
    left = higher[split - 1] if split else 0
    right = higher[split] if split < len(higher) else len(values) - 1
    return float(max(values[left : top + 1].min(), values[top : right + 1].min()))


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
