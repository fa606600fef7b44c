"""Where words of a segment stand in the prompt, which may have them in other forms."""

import re

from generator.text.frame import Span
from generator.text.lexicon import lemma, word_lists

_WORD = re.compile(r"[A-Za-z0-9]+(?:['-][A-Za-z0-9]+)*")
GAP = 3
"""Words that may stand between two that belong together."""


def located(words: str, prompt: str) -> tuple[str, Span | None]:
    """The words as the prompt has them, and where; as given and None where they are not found."""
    meant = [lemma(word) for word in _WORD.findall(words.lower())]
    meant = [word for word in meant if word not in word_lists()["neutral"]] or meant
    tokens = [(found.span(), lemma(found.group().lower())) for found in _WORD.finditer(prompt)]
    for first, (_, word) in enumerate(tokens):
        last = _run(meant, [other for _, other in tokens], first) if meant and word == meant[0] else None
        if last is not None:
            span = tokens[first][0][0], tokens[last][0][1]
            return prompt[slice(*span)], span
    return words, None


def _run(meant: list[str], words: list[str], first: int) -> int | None:
    """Place of the last of the meant words, which begin at a place and follow each other closely."""
    place = first
    for word in meant[1:]:
        nearby = words[place + 1 : place + 2 + GAP]
        if word not in nearby:
            return None
        place += 1 + nearby.index(word)
    return place
