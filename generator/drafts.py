"""Drafts: base tokens are drawn several times, and what does not show its text is drawn again.

Of the drafts of a round the one with the fewest mistakes stays. The segments in which it is wrong are drawn anew in
the next round, with a token of either neighbour, while the rest is held: a mask transformer fills in what is missing.
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
from generator.models.conditioning import Condition
from generator.models.mask_transformer import MaskTransformer

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
        drafts = condition.repeated(self.sampling.drafts)
        lengths = condition.lengths[0]
        best, wrong, held = known, None, known
        for _ in range(self.sampling.rounds):
            tokens = self.mask.generate(
                drafts, self.sampling, noise, held[:, None].expand(-1, self.sampling.drafts, -1)
            )
            found = [self.judge(tokens[:, draft], lengths.tolist()) for draft in range(self.sampling.drafts)]
            least = int(np.argmin([mistakes.sum() for mistakes in found]))
            if wrong is None or found[least].sum() < wrong.sum():
                best, wrong = tokens[:, least], found[least]
            if not wrong.any():
                break
            again = _widened(torch.from_numpy(wrong > 0).to(lengths.device).repeat_interleave(lengths))
            held = torch.where(known >= 0, known, best.masked_fill(again, -1))
        return best


def _widened(chosen: Tensor) -> Tensor:
    """(T,) flags with those of so many neighbours to either side."""
    width = 2 * SEAM_TOKENS + 1
    return functional.max_pool1d(chosen.float()[None], width, stride=1, padding=SEAM_TOKENS)[0] > 0
