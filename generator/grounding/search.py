"""Motion grounding: the window of a motion that is most similar to a text (SegMo, section 4.4)."""

from dataclasses import dataclass

import numpy as np
from torch import Tensor

from generator.config import TOKEN_FRAMES
from generator.grounding.space import SHORTEST_TOKENS, AlignedSpace
from ros_free_stack.skeleton import FPS

TOKEN_S = TOKEN_FRAMES / FPS


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
    """The most similar window to each text (A, W), among those of all lengths from four tokens on."""
    best = [Found(0.0, 0.0, -np.inf)] * len(texts)
    for length in range(SHORTEST_TOKENS, len(hidden) + 1):
        similarity = similarity_map(space, hidden, texts, length)
        for i, row in enumerate(similarity):
            start = int(row.argmax())
            if row[start] > best[i].similarity:
                best[i] = Found(start * TOKEN_S, (start + length) * TOKEN_S, float(row[start]))
    return best
