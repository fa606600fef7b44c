"""Does a motion show what its segments say: the probes, asked for what the frames of the texts say.

A text that no frame reads means the actions of the nearest text that the model knows; a text unlike all of them asks
for nothing, and nothing is then found missing.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from generator.probes.catalogue import PROBES
from generator.probes.checks import MIN_FRAMES, Checks, Details, Window, find
from generator.probes.measures import Measures
from generator.probes.named import required, told
from generator.probes.signals import Signals
from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from generator.text.frame import ActionFrame
from generator.text.frame_parser import moments
from generator.text.meanwhile import clauses_at_once
from generator.text.understanding import DOMAIN
from ros_free_stack.messages import HumanMotion

ABSENT: Final = 4
"""Violations that a missing action counts as, more than all its details together."""
ALIKE_ACTIONS: Final = {"walk": ("step",), "step": ("walk",), "squat": ("crouch",), "bend_forward": ("bow",)}
"""Actions whose names people use for each other."""
FLIGHT: Final = 2
"""Violations that leaving the floor counts as where no action does so: no robot could follow."""


@dataclass(frozen=True)
class Mismatch:
    """Something that a motion does not show: how many `violations` it counts as, and a line of `words`.

    `absent` where the action itself is not there; else it is, and a detail is another.
    """

    violations: int
    words: str
    absent: bool = False


@dataclass(frozen=True)
class Requirement:
    """A clause of a segment's text and the names of the actions that it may mean, any of which will do.

    `frame` says it all, where there is one.
    """

    clause: str
    actions: tuple[str, ...]
    frame: ActionFrame | None = None

    def checks(self, signals: Signals, window: Window) -> Checks | None:
        """Those of the action with the fewest violations; None where nothing can be asked."""
        if window[1] - window[0] < MIN_FRAMES:
            return None
        found = (find(PROBES[name], self._details(name), signals, window) for name in self.actions)
        return min(found, key=violations, default=None)

    def _details(self, name: str) -> Details:
        return told(PROBES[name], self.clause) if self.frame is None else required(PROBES[name], self.frame)


def violations(checks: Checks | None) -> int:
    """How much is wrong with an action: each detail counts 1, its absence ABSENT."""
    if checks is None:
        return 0
    if not checks.action:
        return ABSENT
    return sum(right is False for right in (checks.side, checks.count, checks.direction, checks.extent))


def leaves_floor(signals: Signals, window: Window, parts: Sequence[Requirement]) -> bool:
    """Whether both feet do where nothing that is asked for makes them."""
    probes = [PROBES[name] for part in parts for name in part.actions]
    if not probes or any(probe.flies for probe in probes) or window[1] - window[0] < MIN_FRAMES:
        return False
    return Measures(signals, *window).body.flights > 0


class Verifier:
    """Reads what texts ask for and looks for it in motions."""

    def __init__(self, domain: Domain) -> None:
        self._domain = domain

    @classmethod
    def load(cls, folder: Path, encoder: TextEncoder) -> Self:
        """With the known texts of a folder of weights, or InvalidFile."""
        return cls(Domain.load(folder / DOMAIN, encoder))

    def requirements(self, texts: Sequence[str]) -> tuple[tuple[Requirement, ...], ...]:
        """What each segment text asks for, clause by clause."""
        return tuple(
            tuple(part for clause in clauses_at_once(text) if clause for part in self._required(clause))
            for text in texts
        )

    def _required(self, clause: str) -> tuple[Requirement, ...]:
        found = moments([clause])
        if any(moment.unknown for moment in found):
            names = self._domain.meant([clause])[0]
            return (Requirement(clause, tuple(name for name in names if name in PROBES)),)
        return tuple(
            Requirement(clause, (frame.action, *ALIKE_ACTIONS.get(frame.action, ())), frame)
            for moment in found
            for frame in moment.actions
        )

    def violations(
        self, signals: Signals, windows: Sequence[Window], required: Sequence[tuple[Requirement, ...]]
    ) -> NDArray[np.int64]:
        """(A,) how much is wrong with each segment in its window of frames."""
        return np.array(
            [
                sum(violations(part.checks(signals, window)) for part in parts)
                + FLIGHT * leaves_floor(signals, window, parts)
                for window, parts in zip(windows, required, strict=True)
            ]
        )

    def mismatches(self, motion: HumanMotion) -> tuple[Mismatch, ...]:
        """What a motion does not show of its segments' texts."""
        signals, frames = Signals.of(motion.joints), len(motion.joints)
        found: list[Mismatch] = []
        for segment, parts in zip(motion.segments, self.requirements([s.text for s in motion.segments]), strict=True):
            window = round(segment.start_s * motion.fps), min(frames, round(segment.end_s * motion.fps))
            when = f"{segment.start_s:.1f} to {segment.end_s:.1f} s"
            for part in parts:
                checks = part.checks(signals, window)
                wrong = _wrong(checks)
                if wrong:
                    absent = checks is not None and not checks.action
                    found.append(Mismatch(violations(checks), f"{when}: {wrong} of `{part.clause}`", absent))
            if leaves_floor(signals, window, parts):
                found.append(Mismatch(FLIGHT, f"{when}: leaves the floor in `{segment.text}`"))
        return tuple(found)


def _wrong(checks: Checks | None) -> str:
    """What is wrong, in words; "" where nothing is."""
    if checks is None or checks.passed:
        return ""
    if not checks.action:
        return "does not show the action"
    named = {"side": checks.side, "number": checks.count, "direction": checks.direction, "angle": checks.extent}
    return f"does not show the {' and '.join(name for name, right in named.items() if right is False)}"
