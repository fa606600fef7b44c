"""A frame in the corpus's own words: the texts that the motion model reads.

Nothing but the frame chooses the words, so that what is meant, not how it was said, decides where a sentence lands in
the embedding: action, side, count, direction, speed and angle are kept.
"""

import re
from collections.abc import Sequence
from typing import Final

from generator.corpus.vocabulary.english import Phrase, article, number, plural, tidy
from generator.text.frame import ActionFrame, Moment
from generator.text.lexicon import actions, ways_of
from generator.text.splitter import PERSON

_SPEEDS: Final = {"slow": "slowly", "fast": "quickly"}
_PLURALS: Final = {"foot": "feet"}
_LIMBS: Final = ("hand", "arm", "leg", "foot", "knee")
_OPTIONAL: Final = re.compile(r"\[([^\]]*)\]")
_SLOT: Final = re.compile(r"\{(\w+)(?::([^}]+))?\}")
_FEET: Final = frozenset({"leg", "foot", "knee"})


def segment_texts(moments: Sequence[Moment]) -> tuple[str, ...]:
    """The text of each moment; its own words where no action in it is known."""
    return tuple(segment_text(moment) if moment.actions else moment.words for moment in moments)


def segment_text(moment: Moment) -> str:
    """`a person waves with the left hand twice while walking forward`."""
    main, *meanwhile = (phrase(action) for action in moment.actions)
    text = f"{PERSON} {main.third}"
    return f"{text} while {' and '.join(other.gerund for other in meanwhile)}" if meanwhile else text


def sentence(texts: Sequence[str]) -> str:
    """One sentence of segment texts: `a person waves, then bows`."""
    told = [text.removeprefix(f"{PERSON} ") for text in texts]
    return f"{PERSON} {', then '.join(told)}"


def phrase(frame: ActionFrame) -> Phrase:
    """An action as the corpus words it, its verbs marked."""
    words = actions()[frame.action]
    wording = words.wording if frame.count is None else words.counted
    text = _OPTIONAL.sub(lambda found: _filled(found[1], frame, optional=True), wording)
    speed = _SPEEDS.get(frame.speed, "")
    return Phrase(tidy(f"{_filled(text, frame)} {speed}").strip())


def _filled(template: str, frame: ActionFrame, *, optional: bool = False) -> str:
    """A template with its slots filled; "" where it is optional and a slot is empty."""
    slots = {found[0]: _slot(found[1], found[2] or "", frame, named=optional) for found in _SLOT.finditer(template)}
    if optional and not all(slots.values()):
        return ""
    for slot, text in slots.items():
        template = template.replace(slot, text)
    return template


def _slot(name: str, text: str, frame: ActionFrame, *, named: bool) -> str:
    if name in _LIMBS:
        return _limb(name, frame.side, named=named)
    if name == "times":
        return _times(frame.count)
    if name == "some":
        return _some(text, frame.count or 1)
    if name == "lower":
        return f"and <lower> {'them' if frame.side == 'both' else 'it'}" if "lower" in frame.options else ""
    return _turn(frame) if frame.action == "turn" else _way(frame) or text


def _limb(limb: str, side: str, *, named: bool) -> str:
    if side == "both":
        return f"both {_PLURALS.get(limb, limb + 's')}"
    if side:
        return f"the {side} {limb}"
    return "" if named else f"one {limb}" if limb in _FEET else article(limb)


def _times(count: int | None) -> str:
    if count is None:
        return ""
    return {1: "once", 2: "twice"}.get(count, f"{number(count)} times")


def _some(noun: str, count: int) -> str:
    return article(noun) if count == 1 else f"{number(count)} {plural(noun)}"


def _way(frame: ActionFrame) -> str:
    """The corpus's wording of a way, "" where none was named."""
    wording = next((way.wording for way in ways_of(frame.action) if way.name == frame.way), "")
    s = "s" if frame.side == "both" else ""
    return wording.format(sides=f"side{s}", shoulder=f"shoulder{s}", hip=f"hip{s}")


def _turn(frame: ActionFrame) -> str:
    """How a turn is worded in the corpus; other angles are made exact on the motion."""
    angle, side = frame.value("angle"), frame.way
    to_side = f"to the {side}" if side else ""
    if angle is None:
        return to_side or "around"
    if angle > 270:
        return f"in a full circle {to_side}"
    if angle > 120:
        return f"around {to_side}"
    if angle > 65:
        return f"90 degrees {to_side or 'to the left'}"
    return f"slightly {to_side or 'to the left'}"
