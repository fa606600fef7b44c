"""Which of several motions for a sentence shows it best, by the evaluator of text and motion."""

from collections.abc import Sequence
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import NDArray

from generator.evaluation.embedder import CorpusEmbedder
from generator.generate import WEIGHTS_FOLDER
from ros_free_stack.formats.features import encode
from ros_free_stack.messages import HumanMotion


class Ranker:
    """Compares motions with the sentence they were generated for."""

    def __init__(self, embedder: CorpusEmbedder) -> None:
        self._embedder = embedder

    @classmethod
    def load(cls, folder: Path = WEIGHTS_FOLDER) -> Self:
        """Read the evaluator of a folder of weights; NoWeights says how to train it."""
        return cls(CorpusEmbedder.load(folder / "evaluator"))

    def distances(self, prompt: str, motions: Sequence[HumanMotion]) -> NDArray[np.float64]:
        """(K,) distance of each motion to the sentence in the evaluator's space; less is better."""
        features = [encode(motion.joints).astype(np.float32) for motion in motions]
        text = self._embedder.sentences([prompt])
        return np.linalg.norm(self._embedder.motions(features) - text, axis=1)
