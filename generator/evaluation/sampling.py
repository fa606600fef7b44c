"""Motions for many texts at once, each as long as the real one, as the published protocol has it.

None is shorter than the 2 s that the models take, which a few excerpts of the published data set are by a token.
"""

from collections.abc import Sequence

import numpy as np
import torch
from torch import Tensor

from generator.config import TOKEN_FRAMES, Sampling
from generator.evaluation.pairs import Features, Pair
from generator.models.segmo.conditioning import Condition, stack_lengths, uniform_lengths
from generator.nn.durations import whole_tokens
from generator.performer import Performer
from generator.text.counts import segment_counts
from generator.text.meanwhile import encode_segments
from ros_free_stack.console import progress
from ros_free_stack.skeleton import FPS

BATCH = 64


class BatchSampler:
    """Generates in batches of similar length with a generator's models.

    A text's segments share the real motion's length as the duration model predicts, or equally in a model of
    uniform layout: where the real segments begin and end is not told.
    """

    def __init__(self, generator: Performer, pairs: Sequence[Pair]) -> None:
        self._generator, self._pairs = generator, pairs
        texts = sorted({text for pair in pairs for text in (pair.text, *pair.segments)})
        embeddings = generator.text_encoder.encode_sentences(texts)
        self._device = generator.tokenizer.mean.device
        self._embeddings = torch.from_numpy(embeddings).to(self._device)
        self._row = {text: row for row, text in enumerate(texts)}
        segments = sorted({text for pair in pairs for text in pair.segments})
        self._clauses = torch.from_numpy(encode_segments(generator.text_encoder, segments)).to(self._device)
        self._place = {text: place for place, text in enumerate(segments)}
        self._lengths = [self._segment_lengths(pair) for pair in pairs]

    def generate(self, numbers: Sequence[int], *, seed: int, title: str) -> list[Features]:
        """Features (T, 263) for the texts of these numbers, a number as often as it is named.

        The same arguments give the same motions.
        """
        noise = torch.Generator(self._device).manual_seed(seed)
        order = sorted(range(len(numbers)), key=lambda place: self._pairs[numbers[place]].frames)
        found: list[Features] = [np.empty((0, 0), np.float32)] * len(numbers)
        starts = range(0, len(order), BATCH)
        for start in progress(starts, title, total=len(starts)):
            places = order[start : start + BATCH]
            for place, features in zip(places, self._batch([numbers[place] for place in places], noise), strict=True):
                found[place] = features
        return found

    def _batch(self, numbers: Sequence[int], noise: torch.Generator) -> list[Features]:
        models, sampling = self._generator, Sampling()
        condition = self._condition(numbers)
        with torch.inference_mode():
            base = models.mask.generate(condition, sampling, noise)
            tokens = models.residual.generate(base, condition, sampling, noise)
            lengths = condition.lengths.sum(1).tolist()
            return [
                models.tokenizer.decode(tokens[:, row : row + 1, :length])[0].float().cpu().numpy()
                for row, length in enumerate(lengths)
            ]

    def _condition(self, numbers: Sequence[int]) -> Condition:
        chosen = [self._pairs[number] for number in numbers]
        segments = [self._clauses[[self._place[text] for text in pair.segments]] for pair in chosen]
        return Condition(
            self._embed([pair.text for pair in chosen]),
            torch.nn.utils.rnn.pad_sequence(segments, batch_first=True),
            torch.nn.utils.rnn.pad_sequence([_counts(pair) for pair in chosen], batch_first=True).to(self._device),
            stack_lengths([self._lengths[number] for number in numbers]).to(self._device),
        )

    def _embed(self, texts: Sequence[str]) -> Tensor:
        return self._embeddings[[self._row[text] for text in texts]]

    def _segment_lengths(self, pair: Pair) -> np.ndarray:
        """(A,) tokens of each segment."""
        count = len(pair.segments)
        if self._generator.mask.config.layout == "uniform":
            return uniform_lengths(count, pair.frames // TOKEN_FRAMES)
        place = torch.arange(count, device=self._device)
        with torch.inference_mode():
            mean, _ = self._generator.durations(
                self._embed(pair.segments), _counts(pair).to(self._device), place, torch.full_like(place, count)
            )
        seconds = mean.double().exp().cpu().numpy()
        return whole_tokens(seconds * (pair.frames / FPS / seconds.sum()))


def _counts(pair: Pair) -> Tensor:
    """(A, 2) repetitions that the segment texts name."""
    return torch.from_numpy(segment_counts(pair.segments))
