"""What a segment text says happens at the same time, as two sentences of their own.

An embedding of "walks forward while waving" is close to those of its parts but hardly says which arm goes with which
leg; the parts alone are sentences that the models have read many times.
"""

from collections.abc import Iterable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from generator.text.inflection import GERUNDS, third_person

LINK = " while "


class Encoder(Protocol):
    """Texts to embeddings (N, W)."""

    def encode_sentences(self, texts: list[str]) -> NDArray[np.float32]: ...


def clauses_at_once(segment: str) -> tuple[str, str]:
    """The main clause of a segment text and what happens meanwhile, "" if nothing does.

    `a person walks while slowly waving` -> `a person walks`, `a person slowly waves`
    """
    main, _, meanwhile = segment.partition(LINK)
    if not meanwhile:
        return segment, ""
    words, finite = meanwhile.split(), True
    for place, word in enumerate(words):
        if finite and word in GERUNDS:
            words[place], finite = third_person(GERUNDS[word]), False
        finite = finite or word == "and"
    return main, f"a person {' '.join(words)}"


def encode_segments(encoder: Encoder, segments: Iterable[str]) -> NDArray[np.float32]:
    """(A, 2, W) embeddings of both clauses of each segment text, zero where nothing happens meanwhile."""
    pairs = [clauses_at_once(segment) for segment in segments]
    texts = sorted({text for pair in pairs for text in pair if text})
    row = {text: place for place, text in enumerate(texts)}
    found = encoder.encode_sentences(texts)
    nothing = np.zeros_like(found[0])
    return np.stack([np.stack([found[row[text]] if text else nothing for text in pair]) for pair in pairs])
