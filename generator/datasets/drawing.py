"""How often clips are drawn in training, so that rare actions are met often enough to be learned."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from generator.datasets.dataset import Clip, LabelledSegment


def drawing_weights(clips: Sequence[Clip]) -> np.ndarray:
    """(N,) weight of each clip: its own by the mean of n^-0.75 over its actions, n clips showing each.

    Short actions fit into more clips than long ones, and one action alone is commoner than two at once: drawn alike, an
    action like walking is met thirty times as often as one like conducting. That leaves some of the difference. An
    action in the company of another counts as one of its own. Clips whose segments nobody labelled keep their weight.
    """
    shown = [{action for segment in clip.segments for action in _actions(segment)} for clip in clips]
    count = Counter(action for actions in shown for action in actions)
    rarity = [np.mean([count[action] ** -0.75 for action in sorted(actions)]) if actions else 1.0 for actions in shown]
    return np.array([clip.weight for clip in clips]) * np.array(rarity)


def _actions(segment: LabelledSegment) -> list[tuple[str, int]]:
    """Actions of a segment, each with how many there are at once."""
    return [(name, len(segment.actions)) for name, _ in segment.actions]
