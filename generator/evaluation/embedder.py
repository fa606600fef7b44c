"""What embeds texts and motions for the metrics: this project's evaluator, in batches."""

from collections.abc import Callable, Sequence, Sized
from pathlib import Path
from typing import Protocol, Self, TypeVar

import numpy as np
import torch
from torch import Tensor

from generator import weights
from generator.bodies import WHOLE
from generator.evaluation.metrics import Floats
from generator.evaluation.pairs import Features, Pair
from generator.nn.evaluator import EvaluatorConfig, MotionTextEvaluator
from generator.text.word_vectors import WordVectors

BATCH = 64

Item = TypeVar("Item", bound=Sized)


class Embedder(Protocol):
    """Texts and motions to one space, where a motion lies near its text."""

    name: str

    def motions(self, features: Sequence[Features]) -> Floats:
        """Motions, each (T, 263) in the features' own units, to (N, E)."""
        ...

    def texts(self, pairs: Sequence[Pair]) -> Floats:
        """The pairs' texts to (N, E)."""
        ...


class CorpusEmbedder:
    """The evaluator that was trained on a corpus of this project."""

    def __init__(self, model: MotionTextEvaluator, name: str) -> None:
        self.name = name
        self._model, self._vectors = model, WordVectors()

    @classmethod
    def load(cls, folder: Path, device: str = "cpu") -> Self:
        """Read a trained evaluator's folder; NoWeights says how to train it."""
        saved = weights.load(folder, "evaluator")
        model = MotionTextEvaluator(saved.config_as(EvaluatorConfig))
        saved.fill(model)
        whose = "" if model.config.body == WHOLE else f" of {model.config.body}"
        return cls(model.to(device).eval().requires_grad_(False), f"evaluator{whose} {saved.digest[:8]}")

    def motions(self, features: Sequence[Features]) -> Floats:
        return in_batches(features, lambda rows: self._model.motion_embeddings([torch.from_numpy(row) for row in rows]))

    def texts(self, pairs: Sequence[Pair]) -> Floats:
        return self.sentences([pair.text for pair in pairs])

    def sentences(self, sentences: Sequence[str]) -> Floats:
        """Sentences to (N, E)."""
        vectors = self._vectors(sentences, self._model.config.words)
        return in_batches(vectors, self._model.text_embeddings)


def in_batches(items: Sequence[Item], embed: Callable[[list[Item]], Tensor]) -> Floats:
    """(N, E) embeddings of items in their order, made in batches of similar length."""
    order = sorted(range(len(items)), key=lambda number: len(items[number]))
    found: list[np.ndarray] = [np.empty(0)] * len(items)
    with torch.inference_mode():
        for start in range(0, len(order), BATCH):
            rows = order[start : start + BATCH]
            for row, values in zip(rows, embed([items[row] for row in rows]).double().cpu().numpy(), strict=True):
                found[row] = values
    return np.stack(found)
