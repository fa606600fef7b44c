"""The words of a clause with what every reading of it knows: lemma, amounts, limbs with their sides, comparisons."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property

from generator.text.amounts import amounts
from generator.text.frame import Amount, Kind
from generator.text.inflection import FINITE_FORMS, GERUNDS
from generator.text.lexicon import lemma, verbs, word_lists

ARMS = frozenset({"hand", "arm", "fist", "elbow", "palm", "finger"})
LEGS = frozenset({"leg", "foot", "knee", "heel"})
SIDES = frozenset({"left", "right"})
_BOTH = frozenset({"both", "two"})
_WORD = re.compile(r"[a-z0-9]+(?:['-][a-z0-9]+)*")
_BETWEEN = frozenset({"the", "his", "her", "their", "your", "its", "my", "of", "and", "own", "a"})
_COMPARISONS = (("like",), ("as", "if"), ("as", "though"), ("in", "the", "style"), ("resembling",), ("imitating",))


@dataclass(frozen=True)
class Token:
    """A word of a clause, where it stands in it, and its lemma."""

    text: str
    lemma: str
    start: int
    end: int

    def among(self, words: Iterable[str]) -> bool:
        """Whether the word or its lemma is one of the words."""
        return self.text in words or self.lemma in words


@dataclass(frozen=True)
class Limb:
    """A named limb: which token it is, its side ("left", "right", "both" or ""), and the tokens that say the side."""

    place: int
    lemma: str
    side: str
    told_by: tuple[int, ...]


class ClauseTokens:
    """A clause such as `slowly raises the left arm twice`, in lower case."""

    def __init__(self, text: str) -> None:
        """Raise InvalidPrompt where an amount is out of range."""
        self.text = text
        self.tokens = tuple(Token(m.group(), lemma(m.group()), m.start(), m.end()) for m in _WORD.finditer(text))
        self.amounts: Mapping[Kind, Amount] = amounts(text)

    def __len__(self) -> int:
        return len(self.tokens)

    @cached_property
    def measured(self) -> frozenset[int]:
        """Places of the tokens that say amounts."""
        spans = [amount.span for amount in self.amounts.values()]
        return frozenset(i for i, token in enumerate(self.tokens) if any(a <= token.start < b for a, b in spans))

    @cached_property
    def head(self) -> int:
        """Place of the verb: the first word that is no adverb; 0 where there is none."""
        skipped = word_lists()["slow"] | word_lists()["fast"]
        return next(
            (
                i
                for i, token in enumerate(self.tokens)
                if not (token.text.endswith("ly") or token.text in skipped) or token.among(verbs())
            ),
            0,
        )

    @property
    def completes(self) -> bool:
        """Whether it only ends what came before: "lands on both feet"."""
        return bool(self.tokens) and self.tokens[self.head].lemma in word_lists()["completing"]

    @cached_property
    def compared(self) -> int:
        """Where a comparison begins ("like a bird", "as if ..."), the length where there is none."""
        texts = [token.text for token in self.tokens]
        starts = [
            i for i in range(1, len(texts)) for words in _COMPARISONS if tuple(texts[i : i + len(words)]) == words
        ]
        return min(starts, default=len(texts))

    @cached_property
    def limbs(self) -> tuple[Limb, ...]:
        """The named limbs in the order of the words."""
        return tuple(self._limb(i) for i, token in enumerate(self.tokens) if token.lemma in word_lists()["limbs"])

    @cached_property
    def told_sides(self) -> frozenset[int]:
        """Places of the words that say the side of a limb."""
        return frozenset(i for limb in self.limbs for i in limb.told_by if self.tokens[i].text in SIDES)

    @cached_property
    def purpose(self) -> int:
        """Where a purpose that adds no motion begins ("to look for it"), the length where there is none."""
        verbs_of_purpose = word_lists()["purpose"]
        return next(
            (
                i
                for i in range(1, len(self) - 1)
                if self.tokens[i].text == "to" and self.tokens[i + 1].text in verbs_of_purpose
            ),
            len(self),
        )

    def finite(self, place: int) -> bool:
        """Whether the word at a place may be a finite verb form other than a base."""
        text = self.tokens[place].text
        return text in FINITE_FORMS and FINITE_FORMS[text] != text

    def gerund(self, place: int) -> bool:
        """Whether the word at a place may be a gerund."""
        return self.tokens[place].text in GERUNDS

    def _limb(self, place: int) -> Limb:
        """The limb at a place, with the words of its side before it ("both of the hands", "left or right hand")."""
        told: list[int] = []
        i = place - 1
        while i >= 0 and self.tokens[i].text in (_BETWEEN | SIDES | _BOTH | {"or", "one", "other"}):
            if self.tokens[i].text in SIDES | _BOTH:
                told.append(i)
            i -= 1
        words = {self.tokens[i].text for i in told}
        plural = self.tokens[place].text not in {self.tokens[place].lemma} and "one" not in self._before(place, 3)
        side = "both" if _BOTH & words or words == SIDES or (plural and not words) else "".join(words)
        return Limb(place, self.tokens[place].lemma, side, tuple(told))

    def _before(self, place: int, count: int) -> set[str]:
        return {token.text for token in self.tokens[max(0, place - count) : place]}
