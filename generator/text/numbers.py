"""Numbers as people write them: `2`, `1.5`, `two`, `a couple of`, `one and a half`, `two hundred`."""

import re
from typing import Final

_UNITS = [
    "zero",
    "one",
    "two",
    "three",
    "four",
    "five",
    "six",
    "seven",
    "eight",
    "nine",
    "ten",
    "eleven",
    "twelve",
    "thirteen",
    "fourteen",
    "fifteen",
    "sixteen",
    "seventeen",
    "eighteen",
    "nineteen",
]
_TENS = ["twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety"]
_VALUES: Final = {
    **{word: float(value) for value, word in enumerate(_UNITS)},
    **{word: 10.0 * (place + 2) for place, word in enumerate(_TENS)},
    "a": 1.0,
    "an": 1.0,
    "single": 1.0,
    "couple": 2.0,
    "dozen": 12.0,
    "half": 0.5,
    "quarter": 0.25,
    "third": 1 / 3,
    "tenth": 0.1,
}
_SCALES: Final = {"hundred": 100.0, "thousand": 1000.0, "million": 1e6}
_DIGITS = r"\d{1,9}(?:[.,]\d{1,9})?"
_SMALL = "|".join((*_UNITS, *_TENS))
_WHOLE = rf"(?:(?:{_SMALL})(?:[ -](?:{'|'.join(_UNITS[1:10])}))?|{_DIGITS}|an?(?= (?:{'|'.join(_SCALES)})))"

NUMBER: Final = (
    rf"(?:(?:a )?couple(?: of)?|(?:half|a quarter|a third|a tenth)(?: of)? an?|a half|half"
    rf"|{_WHOLE}(?:[ -](?:{'|'.join(_SCALES)}))*(?: and (?:a half|a quarter))?"
    rf"|an?(?: single)?|a dozen|dozen)"
)
"""Pattern of a number before a unit; "a" and "an" count as one."""
PLAIN: Final = rf"(?:(?:a )?couple(?: of)?|a dozen|{_WHOLE}(?:[ -](?:{'|'.join(_SCALES)}))*)"
"""Pattern of a whole number of things; without "a"."""


def value(words: str) -> float:
    """The number that words matching one of the patterns say: `one and a half` -> 1.5."""
    total, _, half = words.lower().partition(" and ")
    tokens = re.findall(r"[a-z]+|\d+(?:[.,]\d+)?", total)
    if tokens and tokens[0] in {"a", "an"} and len(tokens) > 1:
        tokens = tokens[1:]
    number = 0.0
    for token in tokens:
        if token in _SCALES:
            number = (number or 1.0) * _SCALES[token]
        elif token[0].isdigit():
            number += float(token.replace(",", "."))
        elif token not in {"of", "a", "an"} or not number:
            number += _VALUES.get(token, 0.0)
    return number + (_VALUES["quarter"] if half.endswith("quarter") else _VALUES["half"] if half else 0.0)
