"""How every action of the catalogue is spoken of: VOCABULARY, by the action's name."""

from typing import Any

import numpy as np

from generator.data.vocabulary import arms, daily, floor, in_place, jumps, play, steps, strikes, trunk, work
from generator.data.vocabulary.english import Phrase
from generator.data.vocabulary.entry import Draw, Entry, Params, Voice
from ros_free_stack.errors import UnknownName

__all__ = ["STILL", "VOCABULARY", "Draw", "Entry", "Params", "Phrase", "Voice", "entry", "parts", "phrase"]

STILL = "No significant movement"
VOCABULARY: dict[str, Entry] = {
    item.name: item
    for family in (arms, daily, work, play, trunk, strikes, floor, in_place, jumps, steps)
    for item in family.ENTRIES
}


def entry(name: str) -> Entry:
    """The entry of an action, or UnknownName."""
    if name not in VOCABULARY:
        raise UnknownName("action", name, VOCABULARY)
    return VOCABULARY[name]


def phrase(name: str, params: dict[str, Any], voice: Voice, rng: np.random.Generator) -> Phrase:
    """One way to say that somebody does the action with these parameters."""
    return entry(name).phrase(params, voice, rng)


def parts(name: str, params: dict[str, Any]) -> tuple[str, str]:
    """What arms and legs do, in the plainest words; "" where a part is still."""
    item = entry(name)
    return item.part(item.arms, params), item.part(item.legs, params)
