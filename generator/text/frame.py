"""What a sentence asks for: for each moment the actions that happen in it, with all that is said of them.

One source for four uses: the wording that the motion model is given, the amounts that its motion is fitted to, what
the verifier asks of the motion, and the words back to the person.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final, Literal

Span = tuple[int, int]
"""First and last (excluded) character."""
Kind = Literal["distance", "angle", "duration", "count"]
UNITS: Final[Mapping[Kind, str]] = MappingProxyType({"distance": "m", "angle": "degrees", "duration": "s", "count": ""})


@dataclass(frozen=True)
class Amount:
    """A number with its meaning.

    Attributes:
        kind: what it measures.
        value: in metres, degrees or seconds; a count is how often, or how many steps.
        text: the words that said it.
        span: where they stand in the text that was read.
    """

    kind: Kind
    value: float
    text: str
    span: Span

    def __str__(self) -> str:
        return f"{self.value:g} {UNITS[self.kind]}".strip()


@dataclass(frozen=True)
class Words:
    """Words that no motion will show, and where they stand in the prompt, where they were found there."""

    text: str
    span: Span | None = None


@dataclass(frozen=True)
class ActionFrame:
    """One action and what is said of it; "" or None where nothing is.

    Attributes:
        action: its name in the vocabulary.
        side: "left", "right" or "both".
        way: where to, or what is touched or played, of the action's set of ways (`tables/ways.tsv`).
        speed: "slow" or "fast".
        amounts: of each kind at most one.
        options: further words that choose a wording ("lower": "yes").
        words: the clause that said it.
        objects: words in it for things of which the lexicon does not know whether they change what is meant.
        span: from the first to the last of them in the prompt, where they were found there.
        confidence: share of the words that mean something that the frame explains, 0 to 1.
    """

    action: str
    side: str = ""
    way: str = ""
    speed: str = ""
    amounts: Mapping[Kind, Amount] = field(default_factory=dict[Kind, Amount])
    options: Mapping[str, str] = field(default_factory=dict[str, str])
    words: str = ""
    objects: tuple[str, ...] = ()
    span: Span | None = None
    confidence: float = 1.0

    def value(self, kind: Kind) -> float | None:
        """The amount of a kind, None where none is named."""
        amount = self.amounts.get(kind)
        return None if amount is None else amount.value

    @property
    def count(self) -> int | None:
        """How often."""
        amount = self.amounts.get("count")
        return None if amount is None else round(amount.value)


@dataclass(frozen=True)
class Unknown:
    """Words for something that no motion was seen of, the known actions near in meaning by name, the whole clause."""

    text: str
    near: tuple[str, ...] = ()
    clause: str = ""
    span: Span | None = None


@dataclass(frozen=True)
class Moment:
    """What happens at one time.

    Attributes:
        words: the segment's text.
        actions: done at the same time, the main one first; none where all is unknown.
        not_shown: words that no motion will show: manner, or things that play no part.
        unknown: actions among the words that are not known.
    """

    words: str
    actions: tuple[ActionFrame, ...]
    not_shown: tuple[Words, ...] = ()
    unknown: tuple[Unknown, ...] = ()

    @property
    def confidence(self) -> float:
        """That of its least certain action."""
        return min((action.confidence for action in self.actions), default=0.0)
