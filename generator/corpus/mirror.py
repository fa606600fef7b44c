"""Reflection of a motion, and of the sentence that describes it, left to right."""

import re

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ros_free_stack.skeleton import MIRRORED

_SIDE = re.compile(r"\b(left|right)(?=(?:wards?|most|hand(?:ed)?|y)?\b)", re.IGNORECASE)
_TURN = re.compile(r"\b((?:counter|anti)[\s-]?)?clock[\s-]?wise\b", re.IGNORECASE)


def mirror_joints(joints: ArrayLike) -> NDArray[np.float64]:
    """(..., 22, 3) joints reflected in the plane y = 0, left joints becoming right ones."""
    return np.asarray(joints, dtype=np.float64)[..., MIRRORED, :] * (1, -1, 1)


def mirror_words(text: str) -> str:
    """Exchange left with right and clockwise with counterclockwise, whole words only, keeping their case.

    Twice gives the text back, but that anticlockwise and hyphenated or divided spellings become
    "clockwise" and "counterclockwise".
    """
    text = _SIDE.sub(lambda word: _like(word[0], "right" if word[0].lower() == "left" else "left"), text)
    return _TURN.sub(lambda word: _like(word[0], "clockwise" if word[1] else "counterclockwise"), text)


def _like(pattern: str, word: str) -> str:
    """`word` in the case of `pattern`: all capitals, a first capital, or none."""
    if pattern.isupper():
        return word.upper()
    return word.capitalize() if pattern[0].isupper() else word
