"""Which of several motions for a sentence shows it best, by the evaluator of text and motion."""

from collections.abc import Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from generator.config import MAX_FRAMES
from generator.evaluation.embedder import CorpusEmbedder
from generator.registry import SHARED, WEIGHTS_FOLDER
from ros_free_stack.formats.features import encode
from ros_free_stack.messages import HumanMotion


class Ranker:
    """Compares motions with the sentence they were generated for."""

    def __init__(self, embedder: CorpusEmbedder) -> None:
        self._embedder = embedder

    @classmethod
    def load(cls, folder: Path = WEIGHTS_FOLDER) -> Self:
        """Read the evaluator of a folder of weights; NoWeights says how to train it."""
        return cls(CorpusEmbedder.load(folder / SHARED / "evaluator"))

    def distances(self, prompt: str, motions: Sequence[HumanMotion]) -> NDArray[np.float64]:
        """(K,) distance of each motion to the sentence in the evaluator's space; less is better.

        Of a motion that is longer than the evaluator sees, the mean over parts of whole segments.
        """
        parts = [_parts(prompt, motion) for motion in motions]
        flat = [part for of_motion in parts for part in of_motion]
        texts = self._embedder.sentences([text for text, _ in flat])
        apart = np.linalg.norm(self._embedder.motions([features for _, features in flat]) - texts, axis=1)
        return np.array([mean.mean() for mean in np.split(apart, np.cumsum([len(part) for part in parts])[:-1])])


def _parts(prompt: str, motion: HumanMotion) -> list[tuple[str, NDArray[np.float32]]]:
    """Sentence and features (T, 263) of as many whole segments at a time as the evaluator sees."""
    features = encode(motion.joints).astype(np.float32)
    if len(features) <= MAX_FRAMES or not motion.segments:
        return [(prompt, features[:MAX_FRAMES])]
    parts: list[tuple[str, NDArray[np.float32]]] = []
    start, texts = 0, list[str]()
    for segment, following in zip_longest(motion.segments, motion.segments[1:]):
        texts.append(segment.text)
        if following is None or round(following.end_s * motion.fps) - start > MAX_FRAMES:
            end = round(segment.end_s * motion.fps)
            parts.append((", then ".join(texts), features[start:end][:MAX_FRAMES]))
            start, texts = end, []
    return parts
