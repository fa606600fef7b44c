"""How often clips are drawn: rare actions more often, and nothing but the clips decides."""

from collections import Counter

import numpy as np

from generator.corpus.compose import LabelledSegment
from generator.datasets.dataset import Clip
from generator.datasets.drawing import drawing_weights


def clip(*segments: tuple[str, ...], weight: float = 1.0) -> Clip:
    """A clip whose segments show these actions, at once where there are several."""
    labels = tuple(
        LabelledSegment(
            text=" and ".join(names), start=0, end=20, arms="", legs="", actions=tuple((name, {}) for name in names)
        )
        for names in segments
    )
    return Clip("x", "train", 0, 20, "authored", weight, labels, ())


def test_rare_actions_get_a_larger_share() -> None:
    clips = [clip(("walk",))] * 80 + [clip(("sway",))] * 5
    drawn = Counter[str]()
    for one, weight in zip(clips, drawing_weights(clips), strict=True):
        drawn[one.segments[0].text] += weight
    assert 1 < drawn["walk"] / drawn["sway"] < 80 / 5 / 4


def test_company_makes_another_action() -> None:
    """Walking is common; walking while waving is not."""
    clips = [clip(("walk",))] * 30 + [clip(("wave",))] * 30 + [clip(("walk", "wave"))]
    weights = drawing_weights(clips)
    assert weights[-1] > 10 * weights[0]


def test_common_company_does_not_lift_a_common_action() -> None:
    clips = [clip(("walk",), ("jump",))] * 10 + [clip(("walk",), ("sway",))]
    weights = drawing_weights(clips)
    assert np.all(weights[:-1] == weights[0])
    assert weights[-1] > weights[0]


def test_a_clips_own_weight_counts() -> None:
    weights = drawing_weights([clip(("kick",), weight=3.0), clip(("kick",))])
    assert weights[0] == 3 * weights[1]
    assert drawing_weights([clip(weight=2.0)]).tolist() == [2.0], "nobody labelled it"
