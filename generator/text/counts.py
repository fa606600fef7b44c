"""How often a segment text says that something is done.

Sentence embeddings of "three times" and "four times" hardly differ, so the models are told the number itself.
"""

import re
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from generator.text.meanwhile import clauses_at_once

MOST = 8
"""Greater numbers are no use for choosing a motion of 10 s."""

_WORDS = {"two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "seven": 7, "eight": 8, "nine": 9, "ten": 10}
_ADVERBS = {"once": 1, "twice": 2, "thrice": 3}
_NUMBER = rf"\d+|one|{'|'.join(_WORDS)}"
_TIMES = re.compile(rf"\b(?:({'|'.join(_ADVERBS)})|({_NUMBER}) times?)\b")
_SEVERAL = re.compile(
    rf"\b(\d+|{'|'.join(_WORDS)}) (?!(?:\w+ )?(?:hands|arms|fists|fingers|elbows|legs|feet|knees|degrees?|seconds|"
    r"met(?:er|re)s|inches|people|sides|places|directions|objects|things|drums|boxes|balls|weights|dumbbells)\b)"
)
"""`two arm curls` are repetitions, `two arms` are not."""
_SINGLE = re.compile(
    r"\b(?:one|a single) (?!(?:\w+ )?(?:hand|arm|fist|finger|elbow|leg|foot|knee|shoulder|side|place|spot|direction|"
    r"way|object|thing|drum|box|ball|weight|dumbbell|person|more|another|other)\b|(?:by|at|after|of|to|and|or|in|on)\b)"
)


def repetitions(clause: str) -> int:
    """The number of times that a clause names, at most 8; 0 where it names none.

    `a person waves twice` -> 2, `a person takes three steps` -> 3, `a person waves with two hands` -> 0
    """
    if found := _TIMES.search(clause):
        return min(MOST, _ADVERBS.get(found[1]) or _value(found[2]))
    if found := _SEVERAL.search(clause):
        return min(MOST, _value(found[1]))
    return int(bool(_SINGLE.search(clause)))


def segment_counts(segments: Sequence[str]) -> NDArray[np.int64]:
    """(A, 2) repetitions in both clauses of each segment text."""
    return np.array([[repetitions(clause) for clause in clauses_at_once(text)] for text in segments], dtype=np.int64)


def _value(number: str) -> int:
    return int(number) if number.isdigit() else _WORDS.get(number, 1)
