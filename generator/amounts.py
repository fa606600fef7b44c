"""Distances, angles and durations that a sentence names: how long its segments have to last, and the final exact step.

The motion model reads no amounts. A segment gets the time that its amount needs at the pace of a first sample, is
repeated where that is longer than the model sees at once, and what is left is closed by bending the motion's path and
time. Whoever asks measures what counts: a robot its own metres, a person the person's.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import ceil
from typing import Final, Generic, TypeVar

import numpy as np

from generator.postprocess.path_warp import Change, Path, warped
from generator.text.frame import Amount, Kind, Moment
from ros_free_stack.errors import InvalidPrompt
from ros_free_stack.messages import HumanMotion, Segment

Outcome = TypeVar("Outcome")

KINDS: Final[tuple[Kind, ...]] = ("distance", "angle", "duration")
TOLERANCE: Final[dict[Kind, tuple[float, float]]] = {
    "distance": (0.1, 0.1),
    "angle": (10.0, 0.0),
    "duration": (0.2, 0.0),
}
"""An amount is followed within so much, in m, degrees and s, or within this share of it."""
BENT: Final[dict[Kind, tuple[float, float]]] = {"distance": (0.55, 1.6), "angle": (0.3, 1.8), "duration": (0.5, 2.0)}
"""Factors of a motion's way, turning and time within which it still looks like itself."""
UNBENT: Final = (0.8, 1.25)
"""Within this factor a first sample's time is left as it is."""
PIECE_S: Final = 6.5
"""Longest part of a repeated action that is generated at once."""
MOST_PIECES: Final = 10
ROUNDS: Final = 4
STILL_M: Final = 0.03
"""A sample that goes no farther than this tells no pace."""


@dataclass(frozen=True)
class Wanted:
    """What segments `first` to `last` (excluded) are to come to together."""

    first: int
    last: int
    amount: Amount

    @property
    def allowed(self) -> float:
        """How far off it may be, in the amount's unit."""
        least, share = TOLERANCE[self.amount.kind]
        return max(least, share * self.amount.value)


@dataclass(frozen=True)
class Measured:
    """What a range of a motion comes to: net way over the floor in m, net turn in degrees, time in s."""

    distance: float
    angle: float
    duration: float

    def of(self, kind: Kind) -> float:
        """The amount of a kind."""
        return {"distance": self.distance, "angle": self.angle, "duration": self.duration}[kind]


@dataclass(frozen=True)
class Fitted(Generic[Outcome]):
    """A motion bent to its amounts, what came of it, and what it then measured, an entry for each that was wanted."""

    motion: HumanMotion
    outcome: Outcome
    measured: tuple[Measured, ...]


@dataclass(frozen=True)
class Plan:
    """Segments, some of them repeated, how long each has to last (None: as predicted), and what they should come to."""

    segments: tuple[str, ...]
    seconds: tuple[float | None, ...]
    wanted: tuple[Wanted, ...]


def wanted_of(moments: Sequence[Moment]) -> tuple[Wanted, ...]:
    """The amounts that a sentence names, by segment; of two of a kind in one segment the first."""
    found: list[Wanted] = []
    for i, moment in enumerate(moments):
        for kind in KINDS:
            named = (action.amounts[kind] for action in moment.actions if kind in action.amounts)
            found += [Wanted(i, i + 1, amount) for amount in list(named)[:1]]
    return tuple(found)


def range_of(segments: Sequence[Segment], wanted: Wanted) -> tuple[float, float]:
    """Start and end in s of the segments that an amount belongs to."""
    return segments[wanted.first].start_s, segments[wanted.last - 1].end_s


def measured(motion: HumanMotion, wanted: Sequence[Wanted]) -> tuple[Measured, ...]:
    """What a human motion comes to, an entry for each that is wanted."""
    path, last = Path.of(motion.joints), len(motion.joints) - 1
    found: list[Measured] = []
    for item in wanted:
        start_s, end_s = range_of(motion.segments, item)
        start, end = (min(round(edge * motion.fps), last) for edge in (start_s, end_s))
        way = float(np.linalg.norm(path.place[end] - path.place[start]))
        found.append(Measured(way, abs(float(np.degrees(path.heading[end] - path.heading[start]))), end_s - start_s))
    return tuple(found)


def plan(segments: Sequence[str], wanted: Sequence[Wanted], sample: Sequence[Measured]) -> Plan:
    """How to generate a sentence so that little is left to bend.

    Args:
        segments: texts.
        wanted: the amounts of single segments.
        sample: what a first sample at predicted durations comes to, an entry for each that is wanted.

    Raises:
        InvalidPrompt: an amount would take longer than `MOST_PIECES` parts.
    """
    lasting: dict[int, float | None] = {}
    pieces = dict.fromkeys(range(len(segments)), 1)
    for item, found in zip(wanted, sample, strict=True):
        seconds, count = _time_for(item.amount, found)
        if count > MOST_PIECES:
            most = item.amount.value * MOST_PIECES / count
            raise InvalidPrompt(f"{item.amount.text!r} is too much for one motion: about {most:.2g} is possible here")
        if seconds is not None and (item.amount.kind == "duration" or lasting.get(item.first) is None):
            lasting[item.first] = seconds
        pieces[item.first] = max(pieces[item.first], count)
    starts = np.cumsum([0, *pieces.values()]).tolist()
    return Plan(
        tuple(text for i, text in enumerate(segments) for _ in range(pieces[i])),
        tuple(_share(lasting.get(i), pieces[i]) for i in range(len(segments)) for _ in range(pieces[i])),
        tuple(replace(item, first=starts[item.first], last=starts[item.last]) for item in wanted),
    )


def _share(seconds: float | None, pieces: int) -> float | None:
    return None if seconds is None else seconds / pieces


def _time_for(amount: Amount, found: Measured) -> tuple[float | None, int]:
    """Seconds that an amount needs, None where those of the sample do, and in how many parts."""
    if amount.kind == "duration":
        return amount.value, ceil(amount.value / 8.8)
    got = found.of(amount.kind)
    ratio = amount.value / got if got > 0 else 1.0
    if amount.kind == "angle":
        return None, 1 if ratio < BENT["angle"][1] else ceil(ratio / UNBENT[1])
    if UNBENT[0] <= ratio <= UNBENT[1] or got < STILL_M:
        return None, 1
    seconds = max(found.duration * ratio, 1.0)
    return seconds, ceil(seconds / PIECE_S)


def fit(
    motion: HumanMotion,
    wanted: Sequence[Wanted],
    outcome: Callable[[HumanMotion], Outcome],
    measure: Callable[[HumanMotion, Outcome], tuple[Measured, ...]],
) -> Fitted[Outcome]:
    """Bend a motion until what becomes of it comes to the amounts, as near as its looks allow.

    Args:
        motion: with its segments.
        wanted: the amounts.
        outcome: what becomes of a motion, for example a robot's trajectory.
        measure: what that comes to, an entry for each that is wanted.
    """
    current = motion
    factors: list[dict[Kind, float]] = [dict.fromkeys(KINDS, 1.0) for _ in wanted]
    best: tuple[float, Fitted[Outcome]] | None = None
    for _ in range(ROUNDS):
        made = outcome(current)
        found = measure(current, made)
        off = max(abs(m.of(w.amount.kind) - w.amount.value) / w.allowed for w, m in zip(wanted, found, strict=True))
        if best is None or off < best[0]:
            best = off, Fitted(current, made, found)
        if off < 0.5 or not _nearer(factors, wanted, found):
            break
        changes = _changes(motion.segments, wanted, factors)
        current = warped(motion, changes)
    assert best is not None
    return best[1]


def _nearer(factors: list[dict[Kind, float]], wanted: Sequence[Wanted], found: Sequence[Measured]) -> bool:
    """Correct the factors, in place, by what was measured; False where none can be moved any further."""
    moved = False
    for factor, item, got in zip(factors, wanted, found, strict=True):
        kind, value = item.amount.kind, got.of(item.amount.kind)
        if value > 0.02 * item.amount.value:
            new = float(np.clip(factor[kind] * item.amount.value / value, *BENT[kind]))
            moved, factor[kind] = moved or abs(new - factor[kind]) > 1e-3, new
    return moved


def _changes(
    segments: Sequence[Segment], wanted: Sequence[Wanted], factors: Sequence[dict[Kind, float]]
) -> list[Change]:
    """One change for each range; amounts of the same segments share theirs."""
    together: dict[tuple[float, float], dict[Kind, float]] = {}
    for item, factor in zip(wanted, factors, strict=True):
        together.setdefault(range_of(segments, item), {})[item.amount.kind] = factor[item.amount.kind]
    return [
        Change(start, end, of.get("distance", 1.0), of.get("angle", 1.0), of.get("duration", 1.0))
        for (start, end), of in together.items()
    ]


def followed_words(wanted: Sequence[Wanted], found: Sequence[Measured]) -> tuple[str, ...]:
    """A line for each amount: what it came to, and whether that is what was asked for."""
    units: dict[Kind, str] = {"distance": "m", "angle": "degrees", "duration": "s"}
    lines: list[str] = []
    for item, got in zip(wanted, found, strict=True):
        kind = item.amount.kind
        value, unit = got.of(kind), units[kind]
        right = abs(value - item.amount.value) <= item.allowed
        told = f"{value:.0f} {unit}" if kind == "angle" else f"{value:.2f} {unit}"
        asked = f"{item.amount.value:g} {unit}"
        lines.append(f"{kind}: {told}, asked for {asked}" + ("" if right else " (not followed)"))
    return tuple(lines)
