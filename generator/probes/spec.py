"""How a probe is declared: bounds on measures, for a limb or for the body, with variants, count and extent."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any, Literal

from generator.probes.measures import Measures
from generator.probes.signals import SIDES

Limits = tuple[float, float]
Bounds = Mapping[str, Limits]
Limb = Literal["", "hand", "hands", "foot", "feet"]
_OTHER = {"left": "right", "right": "left"}


def above(low: float) -> Limits:
    """At least that much."""
    return low, inf


def below(high: float) -> Limits:
    """At most that much."""
    return -inf, high


def within(low: float, high: float) -> Limits:
    """Between the two."""
    return low, high


def parameter(name: str) -> Callable[[Mapping[str, Any]], str]:
    """What that parameter says, "" where it is not named."""
    return lambda params: params.get(name, "")


@dataclass(frozen=True)
class Extent:
    """How far: the measure against what a parameter says, within a share of it and a margin in its unit."""

    measure: str
    param: str
    share: float
    margin: float


@dataclass(frozen=True)
class Probe:
    """What makes a window of motion a given action.

    A key of `bounds` names a measure of the body ("pelvis_low"), of the limb that acts ("hand.lift", "foot.toe") or of
    the one on the other side ("other_hand.front").

    Attributes:
        limb: "hand" or "foot" where one side acts (each is tried), "hands" or "feet" where both must, "" for the body.
        bounds: all must hold.
        variants: further bounds by the direction that they tell, one of which must hold; none where empty.
        wanted: the direction that parameters ask for, "" for none.
        count: measure that counts, "" where counts are not named.
        count_scale: counted turns in one named action.
        extent: how far, where parameters say so.
        action: the action's name, filled in by its record.
    """

    limb: Limb
    bounds: Bounds
    variants: Mapping[str, Bounds] = field(default_factory=dict[str, Bounds])
    wanted: Callable[[Mapping[str, Any]], str] = lambda params: ""
    count: str = ""
    extent: Extent | None = None
    action: str = ""

    @property
    def flies(self) -> bool:
        """Whether both feet leave the floor in this action."""
        return any(self.bounds[name][0] > 0 for name in ("flights", "airborne") if name in self.bounds)


@dataclass(frozen=True)
class Finding:
    """What a probe found in a window.

    Attributes:
        present: whether the action is there.
        side: "left", "right", "both", or "" where sides mean nothing or nothing is there.
        count: how often, None where it is not counted.
        directions: the variants that fit.
        extent: how far, None where it is not measured.
    """

    present: bool
    side: str = ""
    count: int | None = None
    directions: tuple[str, ...] = ()
    extent: float | None = None


ABSENT = Finding(False)


def lookup(measures: Measures, key: str, side: str) -> float:
    """The measure that a key names, `side` being the one that acts."""
    limb, _, name = key.rpartition(".")
    if not limb:
        return getattr(measures.body, name)
    side = _OTHER[side] if limb.startswith("other_") else side
    return getattr((measures.hands if limb.endswith("hand") else measures.feet)[side], name)


def holds(measures: Measures, bounds: Bounds, side: str) -> bool:
    """Whether all measures are within their limits."""
    return all(low <= lookup(measures, key, side) <= high for key, (low, high) in bounds.items())


def detect(probe: Probe, measures: Measures) -> Finding:
    """What the probe finds in a measured window."""
    fitting = {side: _directions(probe, measures, side) for side in SIDES}
    sides = [side for side in SIDES if fitting[side] is not None]
    if not sides or (probe.limb in ("hands", "feet") and len(sides) < 2):
        return ABSENT
    named = probe.limb in ("hand", "foot")
    side = sides[0]
    return Finding(
        present=True,
        side="" if not named else "both" if len(sides) == 2 else side,
        count=round(max(lookup(measures, probe.count, s) for s in sides)) if probe.count else None,
        directions=tuple(dict.fromkeys(d for s in sides for d in fitting[s] or ())),
        extent=lookup(measures, probe.extent.measure, side) if probe.extent else None,
    )


def _directions(probe: Probe, measures: Measures, side: str) -> tuple[str, ...] | None:
    """The variants that fit one side, () where there are none to fit, None where the action is not there."""
    if not holds(measures, probe.bounds, side):
        return None
    fitting = tuple(name for name, bounds in probe.variants.items() if holds(measures, bounds, side))
    return None if probe.variants and not fitting else fitting
