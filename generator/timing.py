"""How long the segments of a sentence last: as predicted, as asked for, and in parts where that is too long at once."""

from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import Final

import numpy as np

from generator.config import MIN_FRAMES
from ros_free_stack.errors import InvalidOption
from ros_free_stack.skeleton import FPS

MIN_S: Final = MIN_FRAMES / FPS
HURRY: Final = 1.05
"""So much faster than predicted a motion may be: another part costs more."""


def part_sizes(seconds: Sequence[float], first_s: float, later_s: float) -> tuple[int, ...]:
    """Numbers of segments that are generated at a time, so that nothing has to be hurried.

    The fewest parts among those that are hurried least, and of these the most even ones.

    Args:
        seconds: predicted duration of each segment, s.
        first_s, later_s: longest first part and longest one that goes on from another, s.
    """

    def cost(sizes: tuple[int, ...]) -> tuple[float, int, float]:
        edges = np.cumsum((0, *sizes))
        lasts = [sum(seconds[start:end]) for start, end in pairwise(edges)]
        hurry = sum(max(0.0, last - HURRY * (later_s if i else first_s)) for i, last in enumerate(lasts))
        return round(hurry, 6), len(sizes), max(lasts)

    count = len(seconds)
    edges = (cuts for parts in range(count) for cuts in combinations(range(1, count), parts))
    return min((tuple(np.diff((0, *cuts, count)).tolist()) for cuts in edges), key=cost)


def fitted(seconds: np.ndarray, total_s: float, max_s: float) -> np.ndarray:
    """Predicted durations (candidates, A) that add up to `total_s`.

    Raises:
        InvalidOption: the total is out of range.
    """
    if not MIN_S <= total_s <= max_s:
        raise InvalidOption("duration", f"{total_s:g} s is outside of {MIN_S:g} to {max_s:g} s")
    return seconds * (total_s / seconds.sum(axis=1, keepdims=True))


def checked_durations(durations_s: Sequence[float], count: int, max_s: float) -> np.ndarray:
    """The durations (A,) asked for, in s.

    Raises:
        InvalidOption: they are of another number, not positive, or their sum is out of range.
    """
    seconds = np.asarray(durations_s, dtype=np.float64)
    if seconds.shape != (count,):
        raise InvalidOption("durations", f"{count} segments need as many durations, found {len(durations_s)}")
    if not (np.isfinite(seconds).all() and (seconds > 0).all() and MIN_S <= round(seconds.sum(), 6) <= max_s):
        raise InvalidOption(
            "durations", f"must be positive and add up to {MIN_S:g} to {max_s:g} s, found {list(durations_s)}"
        )
    return seconds
