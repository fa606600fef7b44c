"""The little grammar that the vocabulary needs: verbs marked in angle brackets, inflected; numbers as words."""

import re
from dataclasses import dataclass

_MARK = re.compile(r"<(\w+)>")
_DOUBLED = frozenset((
    "clap", "flap", "nod", "hop", "jog", "step", "shrug", "squat", "sit", "get", "put", "run", "spin", "stop", "dip",
    "skip", "wag", "drop", "rub", "grab", "jab", "chop", "swim", "hug", "strum", "drum", "hit", "stir", "scrub", "cut",
    "tug", "wrap", "slam", "tap", "bob", "begin", "pat", "let", "slap", "strut", "trot", "bat", "spar", "plan",
))  # fmt: skip
_IRREGULAR = {"have": "has"}
_NUMBERS = ("zero", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")


def third_person(verb: str) -> str:
    """`wave` -> `waves`, `stretch` -> `stretches`, `carry` -> `carries`, `have` -> `has`."""
    if verb in _IRREGULAR:
        return _IRREGULAR[verb]
    if verb.endswith(("s", "sh", "ch", "x", "z", "o")):
        return verb + "es"
    if verb.endswith("y") and verb[-2] not in "aeiou":
        return verb[:-1] + "ies"
    return verb + "s"


def gerund(verb: str) -> str:
    """`wave` -> `waving`, `clap` -> `clapping`, `see` -> `seeing`."""
    if verb in _DOUBLED:
        return verb + verb[-1] + "ing"
    if verb.endswith("e") and not verb.endswith(("ee", "oe", "ye")):
        return verb[:-1] + "ing"
    return verb + "ing"


def number(count: int) -> str:
    """`3` -> `three`; digits above twelve."""
    return _NUMBERS[count] if count < len(_NUMBERS) else str(count)


def plural(noun: str) -> str:
    """`squat` -> `squats`, `punch` -> `punches`, `jumping jack` -> `jumping jacks`."""
    return noun + ("es" if noun.endswith(("s", "sh", "ch", "x")) else "s")


def article(noun: str) -> str:
    """`step` -> `a step`, `arm circle` -> `an arm circle`."""
    return ("an " if noun[0] in "aeiou" else "a ") + noun


def tidy(text: str) -> str:
    """One space between words, none before a comma or a full stop."""
    return re.sub(r"\s+([,.])", r"\1", " ".join(text.split()))


@dataclass(frozen=True)
class Phrase:
    """What somebody does, without the subject; its verbs are marked: `<squat> down and <stand> up`."""

    marked: str

    @property
    def third(self) -> str:
        """`squats down and stands up`"""
        return tidy(_MARK.sub(lambda m: third_person(m[1]), self.marked))

    @property
    def gerund(self) -> str:
        """`squatting down and standing up`"""
        return tidy(_MARK.sub(lambda m: gerund(m[1]), self.marked))

    @property
    def plain(self) -> str:
        """`squat down and stand up`, as after `they` or as a command"""
        return tidy(_MARK.sub(r"\1", self.marked))
