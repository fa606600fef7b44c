"""Motion grounding: where in a motion each text happens, by the similarity of windows (SegMo, section 4.4)."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from torch import Tensor

from generator.grounding.space import SHORTEST_TOKENS, AlignedSpace
from generator.models.segmo.config import TOKEN_S
from ros_free_stack.errors import InvalidOption

BACKGROUND: Final = 0.4
"""Similarity of a window that is not the text's, chosen on validation clips: less and windows of single texts grow too
long, more and those of several in order grow too short."""


@dataclass(frozen=True)
class Found:
    """Where a text was found, in s, and the cosine similarity there."""

    start_s: float
    end_s: float
    similarity: float


def similarity_map(space: AlignedSpace, hidden: Tensor, texts: Tensor, length: int) -> np.ndarray:
    """(A, n - length + 1) cosine of texts (A, W) with each window of `length` tokens of hidden tokens (n, W)."""
    return (texts @ space.windows(hidden, length).T).numpy()


def ground(space: AlignedSpace, hidden: Tensor, texts: Tensor) -> list[Found]:
    """Windows of hidden tokens (n, W) for texts (A, W): one after the other in the order of the texts, gaps allowed.

    Of all such windows these have the greatest sum of evidence (similarity - BACKGROUND) * sqrt(tokens). The paper's
    way is `most_similar`; its windows are too short: a part of a wave is as similar to "waves" as the whole.

    Raises:
        InvalidOption: the motion has fewer tokens than there are texts.
    """
    tokens = len(hidden)
    if tokens < len(texts):
        raise InvalidOption("segments", f"{len(texts)} do not fit into a motion of {tokens * TOKEN_S:.1f} s")
    similarity = _window_similarities(space, hidden, texts, shortest=min(SHORTEST_TOKENS, tokens // len(texts)))
    start, end = np.indices(similarity.shape[1:])
    evidence = (similarity - BACKGROUND) * np.sqrt(np.maximum(end - start, 1))
    return [
        Found(first * TOKEN_S, last * TOKEN_S, float(own[first, last]))
        for (first, last), own in zip(_in_order(evidence), similarity, strict=True)
    ]


def most_similar(space: AlignedSpace, hidden: Tensor, texts: Tensor, length: int) -> list[Found]:
    """The most similar window of `length` tokens for each text (A, W) by itself, as the paper has it (section 4.4)."""
    similarity = similarity_map(space, hidden, texts, length)
    starts = similarity.argmax(axis=1).tolist()
    return [
        Found(start * TOKEN_S, (start + length) * TOKEN_S, float(own[start]))
        for start, own in zip(starts, similarity, strict=True)
    ]


def _window_similarities(space: AlignedSpace, hidden: Tensor, texts: Tensor, shortest: int) -> np.ndarray:
    """(A, n + 1, n + 1) cosine of texts with the window of tokens [start, end); -inf where there is none so short."""
    tokens = len(hidden)
    found = np.full((len(texts), tokens + 1, tokens + 1), -np.inf)
    for length in range(shortest, tokens + 1):
        starts = np.arange(tokens - length + 1)
        found[:, starts, starts + length] = similarity_map(space, hidden, texts, length)
    return found


def _in_order(evidence: np.ndarray) -> list[tuple[int, int]]:
    """Windows [start, end) that follow each other, of the greatest sum of (A, n + 1, n + 1) evidence: by dynamic
    programming over the texts and the token by which all windows so far have ended."""
    edges = evidence.shape[1]
    best, choices = np.zeros(edges), []
    for own in evidence:
        total = best[:, None] + own
        start, value = total.argmax(axis=0), total.max(axis=0)
        best = np.maximum.accumulate(value)
        last = np.maximum.accumulate(np.where(value == best, np.arange(edges), 0))
        choices.append((start, last))
    windows, until = [], edges - 1
    for start, last in reversed(choices):
        end = int(last[until])
        until = int(start[end])
        windows.append((until, end))
    return windows[::-1]
