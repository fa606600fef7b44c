"""The published test set, in the layout of HumanML3D, by the rules of T2M's evaluation."""

import numpy as np

from generator.datasets.published import PublishedMotions
from generator.evaluation.pairs import UNIT, Features, Pair, drawn, whole_units


def published_pairs(data: PublishedMotions, split: str, *, clips: int | None, seed: int) -> tuple[Pair, ...]:
    """The motions of a split, each with a caption drawn by the seed.

    As in T2M, a caption that is about a time span makes a clip of its own; motions are cut to whole units, every
    third to one unit less, at a random place.

    Args:
        clips: how many, drawn by the seed; all of them for None.
    """
    rng = np.random.default_rng(seed)
    found = data.split(split)
    pairs = []
    for clip in (found[row] for row in drawn(len(found), clips, rng)):
        caption = clip.captions[int(rng.integers(len(clip.captions)))]
        pairs.append(Pair(_cropped(data.features(clip), rng), caption.text, caption.segments, caption.tokens))
    return tuple(pairs)


def _cropped(features: Features, rng: np.random.Generator) -> Features:
    spare = UNIT if rng.random() < 1 / 3 else 0
    length = len(features) // UNIT * UNIT - spare
    start = int(rng.integers(len(features) - length + 1))
    return whole_units(features[start : start + length])
