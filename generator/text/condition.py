"""Sentences and their segments as the models read them."""

from collections.abc import Sequence

import numpy as np
import torch

from generator.model import TextCondition
from generator.text.counts import segment_counts
from generator.text.encoder import TextEncoder
from generator.text.meanwhile import LINK, encode_segments

Texts = tuple[str, tuple[str, ...]]
"""A sentence and its segment texts in temporal order."""


def read_texts(encoder: TextEncoder, texts: Sequence[Texts]) -> TextCondition:
    """A row for each sentence, without frames; equal texts are encoded once."""
    sentences = list(dict.fromkeys(sentence for sentence, _ in texts))
    whole = encoder.encode(sentences)
    row = {sentence: place for place, sentence in enumerate(sentences)}
    rows = [row[sentence] for sentence, _ in texts]
    distinct = sorted({segment for _, segments in texts for segment in segments})
    place = {segment: number for number, segment in enumerate(distinct)}
    clauses = encode_segments(encoder, distinct)
    pooled = clauses[:, 0].copy()
    compound = [segment for segment in distinct if LINK in segment]
    if compound:
        pooled[[place[segment] for segment in compound]] = encoder.encode_sentences(compound)
    counts = segment_counts(distinct)
    longest = max(len(segments) for _, segments in texts)
    # Rows beyond a motion's segments repeat its last one; nothing reads them.
    numbers = np.array([[place[own[min(i, len(own) - 1)]] for i in range(longest)] for _, own in texts])
    return TextCondition(
        torch.from_numpy(whole.sentence[rows]),
        torch.from_numpy(whole.tokens[rows]),
        torch.from_numpy(whole.mask[rows]),
        torch.from_numpy(pooled[numbers]),
        torch.from_numpy(clauses[numbers]),
        torch.from_numpy(counts[numbers]),
        torch.zeros(numbers.shape, dtype=torch.long),
    )
