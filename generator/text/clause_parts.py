"""A clause of several actions without "and": participles, how arms are held, what is done after going."""

from typing import Final

from generator.text.clause_frame import best_matches
from generator.text.clause_tokens import ClauseTokens
from generator.text.inflection import FINITE_FORMS, GERUNDS, third_person

_GOING: Final = frozenset({"walk", "step", "jog", "turn", "sneak", "bend_forward", "reach"})
_HELD: Final = frozenset({"raise_arm", "hands_on_hips", "cross_arms", "carry", "guard", "touch", "pray", "cover"})
_AFTER_NOTHING: Final = ("and", "with", "to", "by")


def apart(text: str) -> list[str]:
    """The clause, or its parts that are done at the same time.

    `bends over holding a box` -> `bends over`, `holds a box`
    `walks with the hands on the hips` -> `walks`, `holds the hands on the hips`
    """
    clause = ClauseTokens(text)
    best, match = best_matches(clause)
    if match is None or best is not match:
        return [text]
    for place in match.left:
        token = clause.tokens[place]
        if place >= clause.compared:
            break
        if clause.gerund(place):
            second = f"{third_person(GERUNDS[token.text])}{text[token.end :]}"
            if (cut := _cut(text[: token.start], second)) is not None:
                return cut
        lead = next((i for i in range(place - 1, max(place - 5, 0), -1) if clause.tokens[i].text == "with"), 0)
        if lead:
            second = f"holds{text[clause.tokens[lead].end :]}"
            if (cut := _cut(text[: clause.tokens[lead].start], second)) is not None and _is_held(second):
                return cut
    return [text]


def with_purpose(text: str) -> list[str]:
    """The clause, or its parts one after the other: `walks forward to sit on a chair` -> `walks ...`, `sits ...`."""
    clause = ClauseTokens(text)
    _, match = best_matches(clause)
    if match is None or match.row.action not in _GOING:
        return [text]
    for place in match.left:
        token = clause.tokens[place]
        if place > 1 and clause.tokens[place - 1].text == "to" and token.text in FINITE_FORMS:
            cut = _cut(text[: token.start], f"{third_person(FINITE_FORMS[token.text])}{text[token.end :]}")
            if cut is not None:
                return cut
    return [text]


def _cut(first: str, second: str) -> list[str] | None:
    """Both parts where each is known."""
    words = first.split()
    while words and words[-1] in _AFTER_NOTHING:
        words.pop()
    parts = [" ".join(words), second.strip()]
    found = [best_matches(ClauseTokens(part)) for part in parts]
    return parts if all(best is not None and best is known for best, known in found) else None


def _is_held(text: str) -> bool:
    """Whether a clause says how the arms are held, and nothing else."""
    best, _ = best_matches(ClauseTokens(text))
    if best is None or best.row.action not in _HELD or best.left:
        return False
    return best.row.action != "raise_arm" or bool(best.way)
