"""How often clips are drawn in training, so that rare deeds are met often enough to be learned."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from generator.data.compose import LabelledSegment
from generator.data.dataset import Clip


def drawing_weights(clips: Sequence[Clip]) -> np.ndarray:
    """(N,) weight of each clip: its own by the mean of n^-0.75 over its deeds, n clips showing each.

    Short deeds fit into more clips than long ones, and one action alone is commoner than two at once: drawn alike, a
    deed like walking is met thirty times as often as one like conducting. That leaves some of the difference. A
    deed in the company of another counts as one of its own.
    """
    shown = [{deed for segment in clip.segments for deed in _deeds(segment)} for clip in clips]
    count = Counter(deed for deeds in shown for deed in deeds)
    rarity = [np.mean([count[deed] ** -0.75 for deed in sorted(deeds)]) if deeds else 0.0 for deeds in shown]
    return np.array([clip.weight for clip in clips]) * np.array(rarity)


def _deeds(segment: LabelledSegment) -> list[tuple[str, int]]:
    """Actions of a segment, each with how many there are at once."""
    return [(name, len(segment.actions)) for name, _ in segment.actions]
