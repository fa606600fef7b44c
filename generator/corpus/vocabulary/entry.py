"""How one action is spoken of: a sampler of its parameters, phrasings with slots, and what arms and legs do.

A template such as `<wave> with {hand} {reps}` has its verbs in angle brackets and its slots in braces:

    {hand} {arm} {leg} {foot} {knee} {fist} {shoulder}   the limb, with its side where that is named
    {other_leg} {other_foot}                             the limb of the other side
    {times}   how often a distinct action is done ("", "twice", "several times")
    {reps}    the same for what is naturally repeated ("" where it is not named)
    {some:squat}   "a squat", "two squats", "several squats"
    {poss}    "the", "their", "his", "her"
    {big}     "big", "small" or ""
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from generator.corpus.vocabulary.english import Phrase, article, number, plural

Params = dict[str, Any]
Slots = Mapping[str, tuple[str, ...]]

UNNAMED_RIGHT, UNNAMED_LEFT = 0.46, 0.20
"""How often the side is left out. Drawn so that where no side is named the right one acts in seven of ten."""
UNNAMED = 1 / 3
SLOW, QUICK = 0.84, 1.18
_LIMBS = ("hand", "arm", "leg", "foot", "knee", "fist", "shoulder")
_PLURALS = {"foot": "feet", "fist": "fists"}
_OTHER = {"left": "right", "right": "left"}


@dataclass(frozen=True)
class Draw:
    """Draws parameters; `brief` keeps actions short where many must fit into one clip."""

    rng: np.random.Generator
    brief: bool = False

    def pick(self, *choices: Any, p: tuple[float, ...] | None = None) -> Any:
        return choices[int(self.rng.choice(len(choices), p=p))]

    def uniform(self, low: float, high: float) -> float:
        return round(float(self.rng.uniform(low, high)), 3)

    def side(self) -> str:
        return self.pick("left", "right")

    def sides(self, both: float = 0.25) -> str:
        return self.pick("left", "right", "both", p=((1 - both) / 2, (1 - both) / 2, both))

    def count(self, low: int, high: int) -> int:
        """From low to high, both included; where actions must be brief, rather few."""
        if not self.brief:
            return int(self.rng.integers(low, high + 1))
        highest = min(high, max(4, low + 1))
        shares = np.array([1 / (1 + n) for n in range(highest - low + 1)])
        return low + int(self.rng.choice(len(shares), p=shares / shares.sum()))

    def repeats(self, high: int = 4) -> int:
        """How often a distinct action is done: mostly once, above all where actions must be brief."""
        if self.rng.random() < (0.6 if self.brief else 0.4):
            return 1
        return self.count(2, high)

    def hold(self, low: float = 0.2, high: float = 1.2) -> float:
        return self.uniform(low, low + (high - low) * (0.35 if self.brief else 1.0))

    def speed(self) -> float:
        """Two in three ordinary, the others clearly slow or quick."""
        shares = (0.0, 0.65, 0.35) if self.brief else (0.16, 0.68, 0.16)
        low, high = self.pick((0.66, 0.82), (0.9, 1.16), (1.2, 1.38), p=shares)
        return self.uniform(low, high)

    def size(self) -> float:
        return self.uniform(0.75, 1.3)


@dataclass(frozen=True)
class Voice:
    """Who is spoken of in one caption: subject, pronoun for a second clause, possessive."""

    subject: str = "a person"
    pronoun: str = "he"
    possessive: str = "the"


@dataclass(frozen=True)
class _Counted:
    """`{some:squat}`: the noun with its number."""

    count: int
    named: bool
    several: str

    def __format__(self, noun: str) -> str:
        noun = " ".join(noun.split())
        if self.count == 1:
            return article(noun)
        return f"{number(self.count) if self.named else self.several} {plural(noun)}"


def no_slots(params: Params) -> Slots:
    """An action whose templates need the common slots alone."""
    return {}


@dataclass(frozen=True)
class Entry:
    """One action in words.

    Attributes:
        sample: draws its parameters.
        phrases: templates, see the module.
        slots: further slots of this action, each with its alternatives; the first one is the plainest.
        arms: template of what the arms do, "" where they are still.
        legs: template of what the legs do, "" where they are still.
        weight: how often it is drawn, relative to the others.
        paced: whether one would call it slow or quick.
        name: the action's, filled in by its record.
    """

    sample: Callable[[Draw], Params]
    phrases: tuple[str, ...]
    slots: Callable[[Params], Slots] = field(default=no_slots)
    arms: str = ""
    legs: str = ""
    weight: float = 1.0
    paced: bool = True
    name: str = ""

    def phrase(self, params: Params, voice: Voice, rng: np.random.Generator) -> Phrase:
        """One of many ways to say it. Side, count and speed are left out in about a third of cases."""
        side = params.get("side", "")
        named = bool(side) and rng.random() >= {"left": UNNAMED_LEFT, "right": UNNAMED_RIGHT}.get(side, 0.0)
        counted = "count" in params or "steps" in params
        templates = tuple(template for template in self.phrases if counted or "{some:" not in template)
        with_side = tuple(template for template in templates if _names_side(template))
        templates = with_side if named and with_side else templates
        template = templates[int(rng.integers(len(templates)))]
        extra = {name: values[int(rng.integers(len(values)))] for name, values in self.slots(params).items()}
        slots = {**_limbs(side, named, voice.possessive, rng), **_counts(params, rng), **_sizes(params, rng)}
        text = _fill(template, {**slots, **extra, "poss": voice.possessive})
        return Phrase(_with_manner(text, params, rng) if self.paced else text)

    def part(self, template: str, params: Params) -> str:
        """The plainest wording of what a part does, the same for the same parameters; "" for no template."""
        rng = np.random.default_rng(0)
        extra = {name: values[0] for name, values in self.slots(params).items()}
        counts = {"times": "", "reps": "", "some": _Counted(params.get("count", 1), named=True, several="some")}
        slots = {**_limbs(params.get("side", ""), True, "the", rng), **counts, "big": "", "poss": "the"}
        return Phrase(_fill(template, {**slots, **extra})).third


def _names_side(template: str) -> bool:
    return any(f"{{{limb}}}" in template for limb in _LIMBS) or "{side}" in template


def _fill(template: str, slots: Mapping[str, Any]) -> str:
    """Slots may themselves hold slots, one level deep."""
    return template.format_map(slots).format_map(slots)


def _limbs(side: str, named: bool, possessive: str, rng: np.random.Generator) -> dict[str, str]:
    words = {"side": side if named else ""}
    indefinite = ("one", "a", "one" if possessive == "the" else possessive)[int(rng.integers(3))]
    for limb in _LIMBS:
        if side == "both":
            words[limb] = f"both {_PLURALS.get(limb, limb + 's')}"
        elif named:
            words[limb] = f"{possessive} {side} {limb}"
        elif limb in ("leg", "foot", "knee"):
            words[limb] = f"one {limb}"
        else:
            words[limb] = article(limb) if indefinite == "a" else f"{indefinite} {limb}"
        other = _OTHER.get(side, "")
        words[f"other_{limb}"] = f"{possessive} {other} {limb}" if named else f"one {limb}"
    return words


def _counts(params: Params, rng: np.random.Generator) -> dict[str, Any]:
    count = int(params.get("count", params.get("steps", 1)))
    named = rng.random() >= UNNAMED
    several = ("several", "a few", "some", "multiple")[int(rng.integers(4))]
    vague = ("several times", "repeatedly", "a few times", "multiple times")[int(rng.integers(4))]
    if count == 1:
        times = "once" if named and rng.random() < 0.3 else ""
    elif not named:
        times = vague
    elif count == 2:
        times = "twice" if rng.random() < 0.7 else "two times"
    else:
        times = f"{number(count) if rng.random() < 0.85 else count} times"
    return {"times": times, "reps": times if named else "", "some": _Counted(count, named, several)}


def _sizes(params: Params, rng: np.random.Generator) -> dict[str, str]:
    size = params.get("size", 1.0)
    words = ("big", "large", "wide") if size > 1.18 else ("small", "short") if size < 0.85 else ("",)
    return {"big": words[int(rng.integers(len(words)))] if rng.random() >= UNNAMED else ""}


def _with_manner(text: str, params: Params, rng: np.random.Generator) -> str:
    """Say slow and quick speeds, mostly at the end."""
    speed = params.get("speed", 1.0)
    words = ("slowly",) if speed < SLOW else ("quickly", "quickly", "fast", "rapidly") if speed > QUICK else ()
    if not words or rng.random() < UNNAMED:
        return text
    word = words[int(rng.integers(len(words)))]
    return f"{word} {text}" if word != "fast" and rng.random() < 0.25 else f"{text} {word}"
