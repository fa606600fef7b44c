"""How long the segments of a sentence last: as predicted, as asked for, and in parts where that is too long at once."""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from generator.config import MAX_SEGMENTS
from generator.model import FeatureSpec
from ros_free_stack.errors import InvalidOption

HURRY: Final = 1.05
"""So much faster than predicted a motion may be: another part costs more."""


def part_sizes(
    seconds: Sequence[float],
    first_s: float,
    later_s: float,
    *,
    first: int = MAX_SEGMENTS,
    later: int = MAX_SEGMENTS - 1,
) -> tuple[int, ...]:
    """Numbers of segments that are generated at a time, so that nothing has to be hurried.

    The fewest parts among those that are hurried least, and of these the most even ones.

    Args:
        seconds: predicted duration of each segment, s.
        first_s, later_s: longest first part and longest one that goes on from another, s.
        first, later: most segments of either.
    """
    # Best way to part the first so many segments: hurry, parts, longest part, and their sizes.
    best: list[tuple[float, int, float, tuple[int, ...]]] = [(0.0, 0, 0.0, ())]
    for end in range(1, len(seconds) + 1):
        found: list[tuple[float, int, float, tuple[int, ...]]] = []
        for start in range(end):
            limit, most_s = (later, later_s) if start else (first, first_s)
            if end - start <= limit:
                last = sum(seconds[start:end])
                hurry, parts, longest, sizes = best[start]
                hurry = round(hurry + max(0.0, last - HURRY * most_s), 6)
                found.append((hurry, parts + 1, max(longest, last), (*sizes, end - start)))
        best.append(min(found))
    return best[-1][3]


def fitted(seconds: np.ndarray, total_s: float, least_s: float, most_s: float) -> np.ndarray:
    """Predicted durations (candidates, A) that add up to `total_s`.

    Raises:
        InvalidOption: the total is out of range.
    """
    if not least_s <= total_s <= most_s:
        raise InvalidOption("duration", f"{total_s:g} s is outside of {least_s:g} to {most_s:g} s")
    return seconds * (total_s / seconds.sum(axis=1, keepdims=True))


def checked_durations(durations_s: Sequence[float], count: int, least_s: float, most_s: float) -> np.ndarray:
    """The durations (A,) asked for, in s.

    Raises:
        InvalidOption: they are of another number, not positive, or their sum is out of range.
    """
    seconds = np.asarray(durations_s, dtype=np.float64)
    if seconds.shape != (count,):
        raise InvalidOption("durations", f"{count} segments need as many durations, found {len(durations_s)}")
    if not (np.isfinite(seconds).all() and (seconds > 0).all() and least_s <= round(seconds.sum(), 6) <= most_s):
        raise InvalidOption(
            "durations", f"must be positive and add up to {least_s:g} to {most_s:g} s, found {list(durations_s)}"
        )
    return seconds


def whole_frames(
    durations_s: np.ndarray, spec: FeatureSpec, *, least: int | None = None, most: int | None = None
) -> np.ndarray:
    """Durations (A,) in s to frames (A,) of whole tokens, at least one each, with rounding errors that do not add up.

    A total outside of `least` to `most` frames, by default what the model takes, stretches or shrinks all segments
    alike. Segments of a model of uniform layout get equal shares of the total.
    """
    unit = spec.token_frames
    wanted = durations_s * spec.fps / unit
    least, most = spec.least_frames if least is None else least, spec.most_frames if most is None else most
    total = min(max(round(wanted.sum()), least // unit), most // unit)
    check_segments(len(wanted), total, unit)
    if spec.layout == "uniform":
        return unit * uniform_lengths(len(wanted), total)
    ends = np.cumsum(wanted / wanted.sum() * total)
    edges = [0]
    for i, end in enumerate(ends, start=1):
        edges.append(min(max(round(end), edges[-1] + 1), total - (len(ends) - i)))
    return unit * np.diff(edges)


def segment_lengths(spans: Sequence[tuple[int, int]], tokens: int, unit: int) -> np.ndarray:
    """Tokens of each segment, (A,), from its (start, end) frames in a motion of so many tokens of `unit` frames.

    A boundary lies midway between the end of one segment and the start of the next; each segment gets at least one.

    Raises:
        InvalidOption: more segments than tokens or than the models take.
    """
    count = len(spans)
    check_segments(count, tokens, unit)
    edges = [0]
    for i, ((_, end), (start, _)) in enumerate(pairwise(spans), start=1):
        edge = round((end + start) / 2 / unit)
        edges.append(min(max(edge, edges[-1] + 1), tokens - (count - i)))
    return np.diff([*edges, tokens])


def uniform_lengths(count: int, tokens: int) -> np.ndarray:
    """Equal shares of the tokens for each segment, (A,): SegMo's default (section 3.4)."""
    check_segments(count, tokens, 1)
    return np.diff(np.arange(count + 1) * tokens // count)


def check_segments(count: int, tokens: int, unit: int) -> None:
    """InvalidOption unless there are 1 to 5 segments and a token of `unit` frames for each."""
    if not 1 <= count <= MAX_SEGMENTS:
        raise InvalidOption("segments", f"the models take 1 to {MAX_SEGMENTS} segments, found {count}")
    if tokens < count:
        raise InvalidOption("segments", f"{count} segments do not fit into {tokens * unit} frames")
