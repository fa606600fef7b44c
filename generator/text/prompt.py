"""Is a raw prompt usable at all: not empty, not too long, and English."""

import re
import unicodedata
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from runpy import run_path

from generator.text.inflection import FINITE_FORMS, GERUNDS, word_set
from ros_free_stack.errors import InvalidPrompt, MissingDependency

MAX_CHARACTERS = 500
MAX_WORDS_WITHOUT_ENGLISH = 2  # "moonwalk" and "pirouette gracefully" say nothing about their language

LANGUAGES = ("da", "de", "es", "fi", "fr", "hu", "id", "it", "nb", "nl", "pl", "pt", "ro", "sv", "tr", "vi", "cs")
"""Codes of the spaCy languages in Latin letters that are told from English by their function words."""

_BODY_AND_PLACE = word_set(
    """
    arm arms body chest chin clockwise counterclockwise elbow elbows eye eyes feet finger fingers foot hand hands head
    heel heels hip hips jack jacks knee knees leg legs neck palm palms person shoulder shoulders thigh toe toes torso
    waist wrist backward backwards diagonally forward forwards left right sideways slow slowly quickly fast once twice
    times step steps circle place man woman robot
    """
)
_SPELT_ALIKE = frozenset({"arm", "hand", "man", "person", "robot", "torso"})  # in English and in its neighbours
_WORD = re.compile(r"[^\W\d_]+(?:['’][^\W\d_]+)*")


def check_prompt(prompt: str) -> str:
    """The prompt with its white space put in order.

    Raises:
        InvalidPrompt: nothing is in it, it has more than 500 characters, or it is not English.
    """
    text = " ".join(unicodedata.normalize("NFKC", prompt).split())
    if not text:
        raise InvalidPrompt("it is empty; say what the robot should do, for example 'wave with the right hand'")
    if len(text) > MAX_CHARACTERS:
        raise InvalidPrompt(f"it has {len(text)} characters, at most {MAX_CHARACTERS} are read")
    words = [word.lower().replace("’", "'") for word in _WORD.findall(text)]
    if not words:
        raise InvalidPrompt(f"{text[:40]!r} has no words; describe a motion in English")
    if not _is_english(words):
        raise InvalidPrompt(f"{text[:40]!r} is not English; describe the motion in English")
    return text


def _is_english(words: list[str]) -> bool:
    """At least as many words are known as English as are function words of any one other language."""
    if not all(_is_latin(word) for word in words):
        return False
    english = [word in english_words() and word not in _SPELT_ALIKE for word in words]
    others = [sum(word in stops for word in words) for stops in _stop_words_elsewhere()]
    if not any(english):
        return max(others) == 0 and len(words) <= MAX_WORDS_WITHOUT_ENGLISH and "".join(words).isascii()
    return sum(english) >= max(others)


def _is_latin(word: str) -> bool:
    return all("LATIN" in unicodedata.name(letter, "") for letter in word if letter.isalpha())


@cache
def english_words() -> frozenset[str]:
    """Function words, body, place, and motion verbs in all their forms."""
    return _stop_words("en") | _BODY_AND_PLACE | frozenset(FINITE_FORMS) | frozenset(GERUNDS)


@cache
def _stop_words_elsewhere() -> tuple[frozenset[str], ...]:
    """The function words of each other language that are no English words."""
    return tuple(_stop_words(code) - english_words() for code in LANGUAGES)


def _stop_words(code: str) -> frozenset[str]:
    """The function words of a language, from spaCy's file of them alone: its whole packages take seconds to import."""
    return frozenset(run_path(str(_spacy_folder() / "lang" / code / "stop_words.py"))["STOP_WORDS"])


def _spacy_folder() -> Path:
    spec = find_spec("spacy")
    if spec is None or spec.origin is None:
        raise MissingDependency("the check of a prompt's language", "pip install spacy")
    return Path(spec.origin).parent
