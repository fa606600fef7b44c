"""What the text grounding is trained to say: what each part does in a sentence and in its segments."""

from collections.abc import Sequence
from typing import Final

from generator.corpus.words import STILL
from generator.datasets.dataset import Clip, LabelledSegment

PartTexts = dict[str, tuple[str, ...]]
"""Of each part, what it does in the sentence and in each segment."""

_FIELDS: Final = {
    "arms": "arms",
    "left_arm": "arms",
    "right_arm": "arms",
    "legs": "legs",
    "left_leg": "legs",
    "right_leg": "legs",
    "root": "legs",
}
"""Which text of a segment speaks of a part; of the others none does."""


def part_texts(clip: Clip, parts: Sequence[str]) -> tuple[PartTexts | None, ...]:
    """For each caption of a clip what the parts do; None where nobody said.

    A part without significant movement is told the text itself, the whole sentence or segment (E.4.3). Through a
    sentence a part does one thing after the other.
    """
    if not clip.segments or not any(segment.arms or segment.legs for segment in clip.segments):
        return (None,) * len(clip.captions)
    return tuple(
        {part: _one(part, caption.text, caption.segments, clip.segments) for part in parts} for caption in clip.captions
    )


def _one(part: str, sentence: str, texts: Sequence[str], segments: Sequence[LabelledSegment]) -> tuple[str, ...]:
    said = [getattr(segment, _FIELDS[part]) if part in _FIELDS else STILL for segment in segments]
    moves = [text if text != STILL else "" for text in said]
    whole = ", then ".join(text for text in moves if text) or sentence
    return (whole, *(move or text for move, text in zip(moves, texts, strict=True)))
