"""How every action of the catalogue is spoken of: VOCABULARY, by the action's name."""

from typing import Any, Final

import numpy as np

from generator.corpus.actions import ACTIONS
from generator.corpus.vocabulary.english import Phrase
from generator.corpus.vocabulary.entry import Entry, Voice
from ros_free_stack.errors import UnknownName

STILL: Final = "No significant movement"
VOCABULARY: Final[dict[str, Entry]] = {name: action.words for name, action in ACTIONS.items()}


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
