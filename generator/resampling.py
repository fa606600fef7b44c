"""Drafts: what does not show its text is drawn again.

A first draft that shows all of its texts stays. Otherwise the segments in which it is wrong are drawn anew, with a
token of either neighbour, while the rest is held: a mask transformer fills in what is missing. Of several such drafts
the one with the fewest mistakes stays, and what is still wrong in it is drawn again.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from generator.config import Sampling
from generator.models.segmo.conditioning import Condition
from generator.models.segmo.mask_transformer import MaskTransformer

SEAM_TOKENS: Final = 1

Judge = Callable[[Tensor, Sequence[int]], NDArray[np.int64]]
"""Base tokens (P, T) of a motion and the tokens of each segment (A,) to how much is wrong with each (A,)."""


@dataclass(frozen=True)
class Drafting:
    """Draws base tokens; `judge` compares the drafts."""

    mask: MaskTransformer
    sampling: Sampling
    judge: Judge

    def draw(self, condition: Condition, known: Tensor, noise: torch.Generator) -> Tensor:
        """Base tokens (P, B, T), zero on padding; `known` (P, B, T) has those that are given, -1 elsewhere."""
        tokens = torch.zeros_like(known)
        for row in range(known.shape[1]):
            alone = condition[torch.tensor([row], device=known.device)]
            tokens[:, row, : alone.tokens] = self._best(alone, known[:, row, : alone.tokens], noise)
        return tokens

    def _best(self, condition: Condition, known: Tensor, noise: torch.Generator) -> Tensor:
        """Base tokens (P, T) of a single motion."""
        lengths = condition.lengths[0]
        best, wrong = self._least_wrong(condition, known, noise)
        drafts = condition.repeated(self.sampling.drafts)
        for _ in range(self.sampling.rounds):
            if not wrong.any():
                break
            again = _widened(torch.from_numpy(wrong > 0).to(lengths.device).repeat_interleave(lengths))
            held = torch.where(known >= 0, known, best.masked_fill(again, -1))
            tokens, found = self._least_wrong(drafts, held, noise)
            if found.sum() < wrong.sum():
                best, wrong = tokens, found
        return best

    def _least_wrong(self, drafts: Condition, held: Tensor, noise: torch.Generator) -> tuple[Tensor, NDArray[np.int64]]:
        """The draft (P, T) with the fewest mistakes of those that complete the held tokens (P, T), and its mistakes."""
        count = len(drafts.lengths)
        tokens = self.mask.generate(drafts, self.sampling, noise, held[:, None].expand(-1, count, -1))
        found = [self.judge(tokens[:, row], drafts.lengths[row].tolist()) for row in range(count)]
        least = int(np.argmin([mistakes.sum() for mistakes in found]))
        return tokens[:, least], found[least]


def _widened(chosen: Tensor) -> Tensor:
    """(T,) flags with those of so many neighbours to either side."""
    width = 2 * SEAM_TOKENS + 1
    return functional.max_pool1d(chosen.float()[None], width, stride=1, padding=SEAM_TOKENS)[0] > 0
