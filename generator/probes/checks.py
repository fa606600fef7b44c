"""Whether a motion does what its segments say: each action where it belongs, with its side, count and direction.

A generated motion keeps its own time, so that an action may begin or end a little outside of its segment: windows
around the segment are tried too, the nearest first.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final, Self

from generator.probes.catalogue import PROBES
from generator.probes.measures import Measures
from generator.probes.signals import Signals
from generator.probes.spec import Finding, Probe, detect
from ros_free_stack.errors import InvalidOption, UnknownName
from ros_free_stack.skeleton import FPS

MARGIN_S: Final = 0.4
MARGIN_SHARE: Final = 0.25
MIN_FRAMES: Final = 6
_MOVES: Final = ((0, 0), (-1, 1), (-1, 0), (0, 1), (1, 0), (0, -1), (1, 1), (-1, -1), (1, -1))
"""Where windows begin and end, in margins: as told, wider, early, late, narrower."""

Window = tuple[int, int]
Params = Mapping[str, Any]


@dataclass(frozen=True)
class Details:
    """What was said of an action; "", None where nothing was.

    Attributes:
        side: "left", "right" or "both".
        count: how often.
        direction: a variant of the action's probe.
        extent: how far.
    """

    side: str = ""
    count: int | None = None
    direction: str = ""
    extent: float | None = None

    @classmethod
    def of(cls, wanted: Probe, params: Params) -> Self:
        """Those that parameters tell; "extent" asks how far."""
        extent = params.get("extent")
        return cls(
            params.get("side", ""),
            params.get("count") or None,
            wanted.wanted(params),
            None if extent is None else abs(float(extent)),
        )


@dataclass(frozen=True)
class Checks:
    """What is right about one action; None where nothing was asked.

    Attributes:
        action: whether it is there at all; without it side, count, direction and extent are wrong where asked.
        window: frames [start, stop) in which it was found, or that were told.
    """

    action: bool
    side: bool | None
    count: bool | None
    direction: bool | None
    extent: bool | None
    window: Window

    @property
    def passed(self) -> bool:
        return self.action and not any(right is False for right in (self.side, self.count, self.direction, self.extent))


@dataclass(frozen=True)
class Wanted:
    """One segment of a motion: the actions that happen in it, at the same time where there are two."""

    window: Window
    actions: tuple[tuple[str, Params], ...]


@dataclass(frozen=True)
class MotionChecks:
    """The checks of each action of each segment, and whether the segments follow each other as told."""

    segments: tuple[tuple[Checks, ...], ...]
    ordered: bool

    @property
    def present(self) -> bool:
        """All actions are there, in order."""
        return self.ordered and all(checks.action for segment in self.segments for checks in segment)

    @property
    def passed(self) -> bool:
        """All actions are there, in order, with all that was said of them."""
        return self.ordered and all(checks.passed for segment in self.segments for checks in segment)


def probe(action: str) -> Probe:
    """The probe of an action, or UnknownName."""
    if action not in PROBES:
        raise UnknownName("action", action, PROBES)
    return PROBES[action]


def check_segment(signals: Signals, window: Window, action: str, params: Params, *, exact: bool = False) -> Checks:
    """Whether an action with the named parameters happens in a window of a motion.

    Args:
        signals: of the whole motion.
        window: frames [start, stop).
        action: of the vocabulary.
        params: what was named; "extent" asks how far.
        exact: look at that window alone, not around it.

    Raises:
        UnknownName: there is no such action.
        InvalidOption: the window is shorter than 0.3 s or outside of the motion.
    """
    wanted = probe(action)
    return find(wanted, Details.of(wanted, params), signals, window, exact=exact)


def find(wanted: Probe, details: Details, signals: Signals, window: Window, *, exact: bool = False) -> Checks:
    """Whether a probe's action happens as told in a window of a motion; see `check_segment`."""
    start, stop = window
    if not 0 <= start <= stop - MIN_FRAMES <= len(signals) - MIN_FRAMES:
        raise InvalidOption("window", f"{window} is not at least {MIN_FRAMES} of the motion's {len(signals)} frames")
    nearest: Checks | None = None
    for candidate in (window,) if exact else _around(window, len(signals)):
        finding = detect(wanted, Measures(signals, *candidate))
        if finding.present:
            checks = _compare(wanted, details, finding, candidate)
            if checks.passed:
                return checks
            nearest = nearest or checks
    return nearest or _compare(wanted, details, Finding(False), window)


def check_motion(signals: Signals, segments: tuple[Wanted, ...]) -> MotionChecks:
    """The checks of a motion whose segments are known; see `check_segment`."""
    found = tuple(
        tuple(check_segment(signals, segment.window, action, params) for action, params in segment.actions)
        for segment in segments
    )
    centres = [[0.5 * sum(checks.window) for checks in segment] for segment in found]
    return MotionChecks(found, all(max(before) < min(after) for before, after in pairwise(centres)))


def _around(window: Window, frames: int) -> Iterator[Window]:
    start, stop = window
    margin = round(min(MARGIN_S * FPS, MARGIN_SHARE * (stop - start)))
    for early, late in _MOVES:
        moved = max(0, start + early * margin), min(frames, stop + late * margin)
        if moved[1] - moved[0] >= MIN_FRAMES:
            yield moved


def _compare(wanted: Probe, details: Details, finding: Finding, window: Window) -> Checks:
    extent = None
    if wanted.extent and details.extent is not None:
        slack = wanted.extent.share * details.extent + wanted.extent.margin
        extent = finding.extent is not None and abs(abs(finding.extent) - details.extent) <= slack
    return Checks(
        action=finding.present,
        side=finding.side == details.side if details.side and wanted.limb in ("hand", "foot") else None,
        count=finding.count == details.count if details.count and wanted.count else None,
        direction=details.direction in finding.directions if details.direction else None,
        extent=extent,
        window=window,
    )
