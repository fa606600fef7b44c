"""One evaluation: the rows of the table, each against the same texts and real motions."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import torch

from generator.evaluation.embedder import Embedder
from generator.evaluation.metrics import Floats
from generator.evaluation.pairs import Features, Pair
from generator.evaluation.protocol import MULTIMODALITY_SAMPLES, MotionSet, Score, score
from generator.model import MotionModel
from generator.performer import FIRST_SAMPLES, Performer, PerformerSettings
from generator.postprocess.context import Context, whole_features
from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidOption

Scores = dict[str, Score]

BATCH = 64


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

    def reconstruction_scores(self, model: MotionModel) -> Scores | None:
        """Of the real motions after a trip through a model's own representation, with the mean joint error; None where
        it has none."""
        found: list[Features] = []
        for features in progress(self._features, "reconstructing", len(self._features)):
            through = model.reconstruct(torch.from_numpy(features))
            if through is None:
                return None
            found.append(through.cpu().numpy())
        return self._score([MotionSet.measure(found, self._embedder, self._features)])

    def generated_scores(
        self, performer: Performer, *, resampled: bool, generations: int, multimodal_texts: int
    ) -> Scores:
        """Of motions generated from the texts, each as long as the real one.

        Args:
            resampled: measure what `generate` writes, resampled where a motion does not show its text and with feet
                locked; otherwise the model's first samples as they are, as papers do.

        Raises:
            InvalidOption: more texts are wanted for MultiModality than there are.
        """
        if multimodal_texts > len(self._pairs):
            raise InvalidOption("--multimodality", f"there are {len(self._pairs)} texts, found {multimodal_texts}")
        generator = Generation(performer, self._pairs, resampled=resampled)
        every = range(len(self._pairs))
        sets = [
            MotionSet.measure(
                generator.motions(every, seed=self._seed + number, title=f"generating {number + 1}/{generations}"),
                self._embedder,
            )
            for number in range(generations)
        ]
        samples = self._samples(generator, multimodal_texts) if multimodal_texts else None
        return self._score(sets, samples)

    def _samples(self, generator: "Generation", texts: int) -> Floats:
        """(texts, 30, E) embeddings of many motions for each of the first texts."""
        numbers = [number for number in range(texts) for _ in range(MULTIMODALITY_SAMPLES)]
        motions = generator.motions(numbers, seed=self._seed, title="generating for multimodality")
        return self._embedder.motions(motions).reshape(texts, MULTIMODALITY_SAMPLES, -1)

    def _score(self, sets: Sequence[MotionSet], samples: Floats | None = None) -> Scores:
        return score(self._texts, self._real, sets, samples, runs=self._runs, seed=self._seed)


class Generation:
    """Motions for the pairs' texts, in batches of similar length.

    A text's segments share the real motion's length as their durations are predicted: where the real segments begin
    and end is not told. None is shorter than what the model takes, which a few published excerpts are by a little.
    """

    def __init__(self, performer: Performer, pairs: Sequence[Pair], *, resampled: bool) -> None:
        self._performer, self._pairs = performer, pairs
        self._settings = PerformerSettings() if resampled else FIRST_SAMPLES
        self._finished = resampled
        frames = [torch.from_numpy(performer.shares(pair.segments, pair.frames)) for pair in pairs]
        text = performer.read([(pair.text, pair.segments) for pair in pairs])
        self._text = text.lasting(torch.nn.utils.rnn.pad_sequence(frames, batch_first=True))

    def motions(self, numbers: Sequence[int], *, seed: int, title: str) -> list[Features]:
        """Features (T, F) for the texts of these numbers, a number as often as it is named.

        The same arguments give the same motions.
        """
        noise = self._performer.noise(seed)
        order = sorted(range(len(numbers)), key=lambda place: self._pairs[numbers[place]].frames)
        found: list[Features] = [np.empty((0, 0), np.float32)] * len(numbers)
        starts = range(0, len(order), BATCH)
        for start in progress(starts, title, total=len(starts)):
            places = order[start : start + BATCH]
            rows = [numbers[place] for place in places]
            segments = [self._pairs[row].segments for row in rows]
            batch = self._performer.samples(self._text[torch.tensor(rows)], segments, None, self._settings, noise)
            for place, features in zip(places, batch, strict=True):
                found[place] = _as_written(features) if self._finished else features
        return found


def _as_written(features: Features) -> Features:
    """The features of a motion with its feet locked."""
    joints, _ = Context.none().stitched(features, foot_lock=True)
    return whole_features(joints).astype(np.float32)
