"""One evaluation: the rows of the table, each against the same texts and real motions."""

from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import torch

from generator import weights
from generator.config import TokenizerConfig
from generator.evaluation.embedder import Embedder
from generator.evaluation.metrics import Floats
from generator.evaluation.pairs import Features, Pair
from generator.evaluation.protocol import MULTIMODALITY_SAMPLES, MotionSet, Score, score
from generator.evaluation.sampling import BatchSampler
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.performer import Performer
from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidOption

Scores = dict[str, Score]


class Evaluation:
    """Scores of real, reconstructed and generated motions for the pairs' texts."""

    def __init__(self, pairs: Sequence[Pair], embedder: Embedder, *, runs: int, seed: int) -> None:
        self._pairs, self._embedder, self._runs, self._seed = pairs, embedder, runs, seed
        self._features = [pair.features for pair in pairs]

    @cached_property
    def _texts(self) -> Floats:
        return self._embedder.texts(self._pairs)

    @cached_property
    def _real(self) -> MotionSet:
        return MotionSet.measure(self._features, self._embedder)

    def real_scores(self) -> Scores:
        """Of the real motions; their FID to themselves is 0."""
        return self._score([self._real])

    def reconstruction_scores(self, tokenizer_folder: Path, device: str) -> Scores:
        """Of the real motions after a trip through a tokenizer, with the mean joint error."""
        saved = weights.load(tokenizer_folder, "tokenizer")
        tokenizer = MotionTokenizer(saved.config_as(TokenizerConfig))
        saved.fill(tokenizer)
        tokenizer.to(device).eval()

        def through(features: Features) -> Features:
            rows = torch.from_numpy(features)[None].to(device)
            return tokenizer.decode(tokenizer.encode(rows))[0].cpu().numpy()

        found = [through(features) for features in progress(self._features, "reconstructing", len(self._features))]
        return self._score([MotionSet.measure(found, self._embedder, self._features)])

    def generated_scores(self, folder: Path, device: str, *, generations: int, multimodal_texts: int) -> Scores:
        """Of motions generated from the texts with the models of a weights folder.

        Raises:
            InvalidOption: more texts are wanted for MultiModality than there are.
        """
        if multimodal_texts > len(self._pairs):
            raise InvalidOption("--multimodality", f"there are {len(self._pairs)} texts, found {multimodal_texts}")
        sampler = BatchSampler(Performer.load(folder, device=device), self._pairs)
        every = range(len(self._pairs))
        sets = [
            MotionSet.measure(
                sampler.generate(every, seed=self._seed + number, title=f"generating {number + 1}/{generations}"),
                self._embedder,
            )
            for number in range(generations)
        ]
        samples = self._samples(sampler, multimodal_texts) if multimodal_texts else None
        return self._score(sets, samples)

    def _samples(self, sampler: BatchSampler, texts: int) -> Floats:
        """(texts, 30, E) embeddings of many motions for each of the first texts."""
        numbers = [number for number in range(texts) for _ in range(MULTIMODALITY_SAMPLES)]
        motions = sampler.generate(numbers, seed=self._seed, title="generating for multimodality")
        return self._embedder.motions(motions).reshape(texts, MULTIMODALITY_SAMPLES, -1)

    def _score(self, sets: Sequence[MotionSet], samples: Floats | None = None) -> Scores:
        return score(self._texts, self._real, sets, samples, runs=self._runs, seed=self._seed)
