"""The texts and motions that are evaluated: clips of a corpus, each with one of its captions."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from generator.config import MAX_FRAMES
from generator.datasets.dataset import MotionDataset
from generator.evaluation.metrics import POOL
from ros_free_stack.errors import InvalidOption

Features = NDArray[np.float32]

UNIT = 4
"""T2M's protocol cuts motions to multiples of so many frames."""


@dataclass(frozen=True)
class Pair:
    """One text and its real motion.

    Attributes:
        features: (T, 263) in their own units, T a multiple of four.
        text: the whole sentence.
        segments: its segment texts in temporal order, which the generator is given with it.
        tokens: (word, part of speech) of the published data set; empty in a corpus of this project.
    """

    features: Features
    text: str
    segments: tuple[str, ...]
    tokens: tuple[tuple[str, str], ...] = ()

    @property
    def frames(self) -> int:
        return len(self.features)


def whole_units(features: NDArray[np.floating]) -> Features:
    """The features without the frames that fill no unit, at most the longest motion."""
    return features[: min(len(features) // UNIT * UNIT, MAX_FRAMES)].astype(np.float32)


def corpus_pairs(dataset: MotionDataset, split: str, *, clips: int | None, seed: int) -> tuple[Pair, ...]:
    """Clips of a split, drawn by the seed where fewer are wanted, each with a caption drawn by the seed.

    Raises:
        InvalidOption: fewer than the 32 clips that R-precision needs.
    """
    rng = np.random.default_rng(seed)
    chosen = dataset.split(split)
    rows = drawn(len(chosen), clips, rng)
    pairs = []
    for clip in (chosen[row] for row in rows):
        caption = clip.captions[int(rng.integers(len(clip.captions)))]
        pairs.append(Pair(whole_units(dataset.features(clip)), caption.text, caption.segments))
    return tuple(pairs)


def drawn(available: int, wanted: int | None, rng: np.random.Generator) -> Sequence[int]:
    """Numbers of `wanted` of the available clips, in random order; of all of them for None."""
    if wanted is not None and wanted < POOL:
        raise InvalidOption("--clips", f"at least {POOL} clips are needed, a pool of R-precision; found {wanted}")
    if available < POOL:
        raise InvalidOption("--split", f"has {available} clips, at least {POOL} are needed, a pool of R-precision")
    return rng.permutation(available)[:wanted].tolist()
