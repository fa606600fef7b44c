"""Typing errors: a word that is not English becomes the known word that it most resembles, or stays.

English words are those of the parser's own dictionary (WordNet's lemmas and their inflections). Known words are those
of the prompts' small world: motion verbs in all forms, body, place, manner and the function words of English.
"""

import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from generator.text.inflection import FINITE_FORMS, GERUNDS, word_set
from generator.text.prompt import english_words

SHORTEST = 4  # letters; a shorter word is only put right where two letters are swapped, as in "teh"
LETTERS_FOR_TWO = 8  # letters from which on two slips are put right

_MANNERS_AND_THINGS = word_set(
    """
    abruptly again ahead air all alternately alternating angle apart arc ball basketball bird box briefly briskly
    carefully casually ceiling center chair chicken clumsily continuously couple criss crossed crosses cup curve deep
    deeply degrees diagonal dial direction directions distance door down downwards drum energetically exercise
    exercises fist fists floor forearm forearms fro front full fully gently gracefully ground guitar gun half happily
    heavily herself high himself hop horizontally imaginary jacks jumping lap large leisurely lightly line little
    loudly low middle moment motion motions mouth movement movements multiple music nervously normally nose object
    original outstretched outward outwards overhead pace position punch push-ups quarter quick quietly rapidly
    repeatedly repeating return rope shape shelf shoulder-height side sides sideways simultaneously sitting sky slight
    slightly small smoothly someone something space spot squats stance standing start starting steadily steady stomach
    straight sudden suddenly surface swimming sword table tall thing throat tightly tired together toward towards
    tpose turns twice underneath upper upright upwards vertically vigorously violin walking wall weight weights wide
    widely wildly window zigzag zombie
    """
)
_WORD = re.compile(r"(?<![\w'’-])[A-Za-z]+(?![\w'’-])")


_PARTICLES = "around|about|forwards?|backwards?|back|down|up|left|right|again|once|twice|slowly|the|his|her"
_JOINED = re.compile(
    rf"({'|'.join(sorted((f for f in FINITE_FORMS if len(f) > 2), key=len, reverse=True))})({_PARTICLES})"
)
_DETERMINED = re.compile(r"(?:^|[\s,])(?:an?|the|one|this|that|some|his|her|their|your|no|any)\s+$")


@dataclass(frozen=True)
class Dictionary:
    """English words: the tables of spaCy's rule lemmatizer, each by part of speech."""

    index: Any
    exceptions: Any
    rules: Any

    @classmethod
    def of(cls, parser: Any) -> "Dictionary":
        """The dictionary that comes with a spaCy pipeline."""
        tables = parser.get_pipe("lemmatizer").lookups
        return cls(*(tables.get_table(f"lemma_{name}") for name in ("index", "exc", "rules")))

    def __contains__(self, word: str) -> bool:
        return word in known_words() or any(self.is_form(word, part) for part in ("noun", "verb", "adj", "adv"))

    def is_form(self, word: str, part: str) -> bool:
        """Is a word a lemma of this part of speech, or a regular or irregular form of one?"""
        lemmas = self.index.get(part, ())
        if part == "adv" and word.endswith("ly"):
            return any(self.is_form(f"{word[:-cut]}{end}", "adj") for cut, end in ((2, ""), (3, "y"), (1, "e")))
        if word in lemmas or word in self.exceptions.get(part, {}):
            return True
        return any(
            word.endswith(ending) and f"{word.removesuffix(ending)}{start}" in lemmas
            for ending, start in self.rules.get(part, ())
            if ending
        )


@cache
def known_words() -> frozenset[str]:
    """What a typing error may have been meant to be."""
    return english_words() | _MANNERS_AND_THINGS


def parted(word: str) -> str:
    """ "turnaround", "walkforward" as two words; any other word as it is."""
    found = _JOINED.fullmatch(word)
    return f"{found[1]} {found[2]}" if found else word


def corrected(text: str, dictionary: Dictionary) -> tuple[str, tuple[str, ...]]:
    """The text with its typing errors put right, and one note for each: "read 'jmups' as 'jumps'"."""
    notes: list[str] = []

    def put_right(found: re.Match[str]) -> str:
        written = found.group()
        word = written.lower()
        noun = _DETERMINED.search(text[: found.start()])
        if parted(word) != word and not noun:
            notes.append(f"read {written!r} as {parted(word)!r}")
            return parted(word)
        meant = word if _is_name(written, text) or word in dictionary else nearest_known(word)
        if meant == word:
            return written
        notes.append(f"read {written!r} as {meant!r}")
        return meant

    return _WORD.sub(put_right, text), tuple(dict.fromkeys(notes))


def _is_name(written: str, text: str) -> bool:
    return written[0].isupper() and not text.startswith(written) and not text.isupper()


@cache
def nearest_known(word: str) -> str:
    """The known word within reach of a slip or two (optimal string alignment distance), else the word itself.

    Of several, that with the same letters, then the same first letter, then a motion verb, then the most similar.
    """
    from rapidfuzz import process
    from rapidfuzz.distance import OSA, JaroWinkler

    reach = 2 if len(word) >= LETTERS_FOR_TWO else 1
    near = process.extract(word, sorted(known_words()), scorer=OSA.distance, score_cutoff=reach, limit=None)
    candidates: list[tuple[int, bool, bool, bool, float, str]] = []
    for known, distance, _ in near:
        swapped = sorted(known) == sorted(word)
        ends = word[-1] == known[-1] and known in FINITE_FORMS and FINITE_FORMS[known] == known
        short = len(word) < SHORTEST - (ends and len(known) > len(word))
        if not swapped and (short or known[0] != word[0] or len(known) < SHORTEST - 1):
            continue
        verb = known in FINITE_FORMS or known in GERUNDS
        similarity = JaroWinkler.similarity(word, known)
        candidates.append((int(distance), not swapped, known[0] != word[0], not verb, -similarity, known))
    return min(candidates)[-1] if candidates else word
