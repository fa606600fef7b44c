"""What somebody does not do: no motion shows it, so it is left out of the segments and the reader is told.

"Without moving forward" stays: it says that walking or jogging is done in place.
"""

import re

from generator.text.inflection import FINITE_FORMS

_NEVER_FORGET = re.compile(r"(?:,? ?\b(?:and|but)\b)? ?\b(?:do not|don't|never) (?:forget|fail|hesitate) to\b")
_NOT_ONLY = re.compile(r"\bnot (?:only|just)\b")
_VERBS = "|".join(sorted(FINITE_FORMS, key=len, reverse=True))
_SUBJECT = r"(?:he|she|it|they|you|(?:the|a) (?:person|man|woman|robot|figure))"
_END = (
    rf"(?= ?[.;,]| (?:then|while|but|before|after|as|when|until|just|simultaneously)\b"
    rf"| (?:and|or) (?:{_SUBJECT} )?(?:{_VERBS})\b|$)"
)
_AUXILIARY = r"(?:do|does|did|is|are|was|were|can|could|will|would|should|must|has|have)"
_NEGATED = re.compile(
    rf"(?:^|,? (?:(?:and|but|yet|or|while) )?|(?<=[.;] ))(?:{_SUBJECT} )?"
    rf"(?:{_AUXILIARY}(?:n't| not)|cannot|can't|won't|never|without|with no|not|instead of|rather than)\b"
    rf"(?P<what>[^.;]*?){_END}"
)
_IN_PLACE = re.compile(r"(?:without|not) (?:moving|going|travell?ing|advancing)(?: forwards?| ahead| anywhere)")


def without_negations(text: str) -> tuple[str, tuple[str, ...]]:
    """Plain wording without its negated parts, and those parts."""
    left_out: list[str] = []

    def leave_out(found: re.Match[str]) -> str:
        part = found.group().strip(" ,.;")
        if _IN_PLACE.match(part):
            return found.group()
        left_out.append(re.sub(r"^(?:and|but|yet|or) | and$", "", part))
        return ""

    text = _NOT_ONLY.sub("", _NEVER_FORGET.sub(" then", text))
    text = re.sub(r"^[ .,;]*(?:(?:and|but|then|just|so) )*", "", _NEGATED.sub(leave_out, text))
    return " ".join(text.split()), tuple(left_out)
