"""The published test set, in the layout of HumanML3D, by the rules of T2M's evaluation."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from generator.config import MIN_FRAMES
from generator.evaluation.pairs import UNIT, Features, Pair, drawn, whole_units
from ros_free_stack.formats.humanml3d import PublishedDataset, TaggedCaption, open_humanml3d
from ros_free_stack.skeleton import FPS

LONGEST = 200
"""Motions of this many frames or more are left out, as are those shorter than 40."""

Split = Callable[[str], tuple[str, ...]]


def published_pairs(
    folder: Path, split: str, *, clips: int | None, seed: int, segments: Split | None
) -> tuple[Pair, ...]:
    """The motions of a split, each with a caption drawn by the seed.

    As in T2M, a caption that is about a time span makes a clip of its own; motions are cut to whole units, every
    third to one unit less, at a random place.

    Args:
        folder: with `new_joint_vecs/`, `texts/`, `train.txt` and the split's own list.
        clips: how many, drawn by the seed; all of them for None.
        segments: a sentence to its segment texts; without it the sentence is its one segment.
    """
    rng = np.random.default_rng(seed)
    data = open_humanml3d(folder)
    found = [clip for name in data.split(split) for clip in _clips(data, name)]
    pairs = []
    for features, captions in (found[row] for row in drawn(len(found), clips, rng)):
        caption = captions[int(rng.integers(len(captions)))]
        texts = segments(caption.text) if segments else (caption.text,)
        pairs.append(Pair(_cropped(features, rng), caption.text, texts, caption.tokens))
    return tuple(pairs)


def _clips(data: PublishedDataset, name: str) -> list[tuple[Features, list[TaggedCaption]]]:
    """The whole motion with the captions about all of it, and the excerpts that single captions are about."""
    if not (data.folder / "new_joint_vecs" / f"{name}.npy").is_file():
        return []  # the published lists name a few clips that the published features lack
    features = data.features(name).astype(np.float32)
    if not MIN_FRAMES <= len(features) < LONGEST:
        return []
    whole: list[TaggedCaption] = []
    clips: list[tuple[Features, list[TaggedCaption]]] = []
    for caption in data.captions(name):
        if caption.start_s == 0 and caption.end_s is None:
            whole.append(caption)
            continue
        end = None if caption.end_s is None else int(caption.end_s * FPS)
        excerpt = features[int(caption.start_s * FPS) : end]
        if MIN_FRAMES <= len(excerpt) < LONGEST:
            clips.append((excerpt, [caption]))
    return [*clips, (features, whole)] if whole else clips


def _cropped(features: Features, rng: np.random.Generator) -> Features:
    spare = UNIT if rng.random() < 1 / 3 else 0
    length = len(features) // UNIT * UNIT - spare
    start = int(rng.integers(len(features) - length + 1))
    return whole_units(features[start : start + length])
