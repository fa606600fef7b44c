"""Amounts in a text: distances, angles, durations and counts, with their units.

`plain_amounts` brings those that a parser would stumble over ("1.5 m", "45°", "half a metre") into whole numbers of
written-out units; `amounts` reads all.
"""

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Final

from generator.text.frame import Amount, Kind, Span
from generator.text.numbers import NUMBER, PLAIN, value
from ros_free_stack.errors import InvalidPrompt

RANGES: Final[Mapping[Kind, tuple[float, float]]] = MappingProxyType(
    {"distance": (0.05, 9.0), "angle": (5.0, 1080.0), "duration": (0.3, 9.8), "count": (1.0, 20.0)}
)
"""What one action of a motion of 9.8 s can be told to be, in m, degrees and s."""

_DISTANCES = {
    r"km|kilomet(?:er|re)s?": 1000.0,
    r"m|met(?:er|re)s?": 1.0,
    r"cm|centimet(?:er|re)s?": 0.01,
    r"mm|millimet(?:er|re)s?": 0.001,
    r"ft|feet": 0.3048,
    r"inch(?:es)?": 0.0254,
    r"yards?": 0.9144,
    r"miles?": 1609.0,
}
_DURATIONS = {
    r"ms|milliseconds?": 0.001,
    r"s|secs?|seconds?": 1.0,
    r"mins?|minutes?": 60.0,
    r"h|hours?": 3600.0,
    r"days?": 86400.0,
}
_ANGLES = {r"degrees?|degress|deg": 1.0, r"radians?|rad": 57.29578}
_TABLE: tuple[tuple[Kind, dict[str, float]], ...] = (
    ("distance", _DISTANCES),
    ("duration", _DURATIONS),
    ("angle", _ANGLES),
)
_MEASURES: tuple[tuple[Kind, re.Pattern[str], float], ...] = tuple(
    (kind, re.compile(rf"(?<![\w.])({NUMBER})(?:(?<=\d)[ -]?|[ -])(?:{unit})(?![\w'])"), scale)
    for kind, table in _TABLE
    for unit, scale in table.items()
)
_A = r"(?:(?:a|one) )?"
_TURN = r"(?:turn|circle|spin|rotation|revolution)"
_TURNED: tuple[tuple[re.Pattern[str], float], ...] = (
    (re.compile(rf"\b{_A}quarter(?:[ -](?:of a )?{_TURN})?\b"), 90.0),
    (re.compile(rf"\b{_A}(?:half|semi)[ -]?(?:of a )?{_TURN}\b|\bhalfway around\b"), 180.0),
    (re.compile(rf"\b{_A}(?:full|complete|whole) {_TURN}\b|\ball the way (?:a)?round\b"), 360.0),
    (re.compile(rf"\b({PLAIN}) (?:(?:full|complete|whole) )?{_TURN}s\b"), 360.0),
    (re.compile(r"\b(?:u-?turn|about-?face)\b"), 180.0),
)
_ADVERBS = {"once": 1.0, "twice": 2.0, "thrice": 3.0}
_TIMES = re.compile(rf"\b(?:({'|'.join(_ADVERBS)})(?! again| more)|({PLAIN}|a thousand|a hundred)(?: more)? times?)\b")
_LIMBS = (
    "hands|arms|fists|fingers|elbows|legs|feet|knees|heels|toes|shoulders|palms|hand|arm|fist|leg|foot|knee|heel|finger"
)
_NOT_COUNTED = (
    rf"{_LIMBS}|degrees?|seconds?|milliseconds|met(?:er|re)s?|centimet(?:er|re)s|inch(?:es)?|people|persons?|sides?|"
    r"places?|directions?|objects?|things?|drums?|box(?:es)?|balls?|weights?|dumbbells?|spot|way|man|woman|minutes?|"
    r"hours?|quarter|half"
)
_NO_NOUN = "at|by|after|more|another|other|of|to|and|or|in|on|hundred|thousand|with|for|foot"
_SEVERAL = re.compile(rf"\b({PLAIN}|one|a single)(?= (?!(?:{_NO_NOUN})\b)(?!(?:\w+ )?(?:{_NOT_COUNTED})\b)[a-z])")
_DECIMAL = re.compile(r"\d[.,]\d|half|quarter|third|tenth")
_NEAR_FEET = re.compile(r"(?:with|on|both|using|his|her|their|your|the)\s+(?:\w+\s+)?$")


def amounts(text: str) -> dict[Kind, Amount]:
    """The amounts in a clause, lower case, by kind; of two of a kind the first.

    Raises:
        InvalidPrompt: one is out of the range that works.
    """
    found: dict[Kind, Amount] = {}
    taken: list[Span] = []
    for amount in _all(text):
        if amount.kind not in found and not any(a < amount.span[1] and amount.span[0] < b for a, b in taken):
            found[amount.kind] = _checked(amount)
            taken.append(amount.span)
    return found


def plain_amounts(text: str) -> str:
    """Amounts with decimals, fractions or short units as whole numbers of written-out units.

    `walks 1.5 m` -> `walks 150 centimetres`, `turns 45°` -> `turns 45 degrees`, `for 4s` -> `for 4 seconds`
    """
    text = re.sub(r"(\d)\s*°", r"\1 degrees", text)
    for kind, pattern, scale in _MEASURES:
        text = pattern.sub(lambda found, kind=kind, scale=scale: _plain(found, kind, scale), text)
    return text


def _plain(found: re.Match[str], kind: Kind, scale: float) -> str:
    if _is_limb(found):
        return found.group()
    number = value(found[1]) * scale
    if kind == "angle":
        return f"{round(number)} degrees" if number >= 1 else found.group()
    whole, part, factor = {"distance": ("metres", "centimetres", 100), "duration": ("seconds", "milliseconds", 1000)}[
        kind
    ]
    if found[1] in {"a", "an"} and kind == "duration":
        return found.group()
    short = re.fullmatch(rf"{NUMBER}[ -]?(?:m|cm|mm|km|ft|s|secs?|mins?|h|ms)", found.group())
    if not (_DECIMAL.search(found[1]) or short or scale not in (1.0, 0.01)):
        return found.group()
    return f"{round(number)} {whole}" if number == round(number) else f"{round(number * factor)} {part}"


def _all(text: str) -> Iterator[Amount]:
    for kind, pattern, scale in _MEASURES:
        for found in pattern.finditer(text):
            idiom = (
                found[1] in {"a", "an"} and kind == "duration" and "hour" not in found[0] and "minute" not in found[0]
            )
            if not _is_limb(found) and not idiom:
                yield Amount(kind, value(found[1]) * scale, found.group(), found.span())
    for pattern, degrees in _TURNED:
        for found in pattern.finditer(text):
            number = value(found[1]) if found.lastindex else 1.0
            yield Amount("angle", number * degrees, found.group(), found.span())
    for found in _TIMES.finditer(text):
        yield Amount("count", _ADVERBS.get(found[1]) or value(found[2]), found.group(), found.span())
    for found in _SEVERAL.finditer(text):
        yield Amount("count", value(found[1]), found.group(), found.span())


def _is_limb(found: re.Match[str]) -> bool:
    """ "on two feet", "with a foot" are no distances."""
    if not found.group().endswith("feet"):
        return False
    return value(found[1]) < 2 or bool(_NEAR_FEET.search(found.string[: found.start()]))


def _checked(amount: Amount) -> Amount:
    low, high = RANGES[amount.kind]
    if low <= amount.value <= high:
        return amount
    unit = {"distance": " m", "angle": " degrees", "duration": " s", "count": " times"}[amount.kind]
    raise InvalidPrompt(f"{amount.text!r} is out of range: {low:g} to {high:g}{unit} of one action are possible")
