"""Holistic-part fusion (ParTY, section 3.3, equations 8 and 9): what the parts did, in what the whole body did.

Equation 8 fuses the tokens 1 to t - 1 anew for each t. So that tokens need not be read again, every token has a step
and looks at tokens of its own and of earlier steps only: a token of the whole body at its own index, a part's token at
the index of the whole body's token in whose time it begins. What a token becomes then never changes, whole sequences
are fused at once in training, and generation keeps keys and values.
"""

from collections.abc import Sequence
from typing import cast

import torch
from torch import Tensor, nn

from generator.nn.causal import Attention, Past

SEPARATOR_STEP = -1


def part_steps(count: int, part_window: int, window: int, device: torch.device | str = "cpu") -> Tensor:
    """(count,) step of each of a part's tokens."""
    return torch.arange(count, device=device) * part_window // window


def merge(rows: Sequence[Tensor], separators: Tensor) -> Tensor:
    """Rows of tokens, each (B, n, W), one after the other with a separator between them, from separators (P, W)."""
    batch = len(rows[0])
    out = [rows[0]]
    for separator, row in zip(separators, rows[1:], strict=True):
        out += [separator.expand(batch, 1, -1), row]
    return torch.cat(out, dim=1)


def split(merged: Tensor, counts: Sequence[int]) -> list[Tensor]:
    """The inverse of `merge` for rows of so many tokens."""
    sizes = [size for count in counts for size in (count, 1)][:-1]
    return list(merged.split(sizes, dim=1)[::2])


class FusionPast:
    """What the fusion has read: of the self-attention, and of the attention to each part."""

    def __init__(self, parts: int) -> None:
        self.own, self.parts = Past(), [Past() for _ in range(parts)]
        self.begun = False


class HolisticPartFusion(nn.Module):
    """Self-attention over the tokens of the whole body and of P parts, then cross-attention to each part, added up.

    Both attentions are added to what they read, as in every transformer layer; the paper does not say.
    """

    def __init__(self, width: int, heads: int, head_width: int, parts: int) -> None:
        super().__init__()
        self.separators = nn.Parameter(0.02 * torch.randn(parts, width))
        self.norm_own, self.norm_split = nn.LayerNorm(width), nn.LayerNorm(width)
        self.own = Attention(width, heads, head_width)
        self.cross = nn.ModuleList(Attention(width, heads, head_width) for _ in range(parts))

    def forward(
        self, whole: Tensor, parts: Sequence[Tensor], steps: Sequence[Tensor], valid: Sequence[Tensor]
    ) -> Tensor:
        """Tokens (B, n, W) of the whole body fused with those of the parts, each (B, m, W).

        Args:
            steps: (n,) of the whole body's tokens, then (m,) of each part's.
            valid: (B, n), then (B, m) true on tokens that count.
        """
        counts = [whole.shape[1], *(part.shape[1] for part in parts)]
        between = torch.full((1,), SEPARATOR_STEP, device=whole.device)
        when = torch.cat([steps[0], *(torch.cat([between, own]) for own in steps[1:])])
        there = torch.ones_like(valid[0][:, :1])
        counted = torch.cat([valid[0], *(torch.cat([there, own], dim=1) for own in valid[1:])], dim=1)
        merged = merge([whole, *parts], self.separators)
        normed = self.norm_own(merged)
        allowed = (when <= when[:, None])[None] & counted[:, None]
        merged = merged + self.own(normed, *self.own.keys(normed), allowed)
        whole, *parts = split(merged, counts)
        query, out = self.norm_split(whole), whole
        for cross, part, own, counts_too in zip(self.attentions, parts, steps[1:], valid[1:], strict=True):
            seen = (own <= steps[0][:, None])[None] & counts_too[:, None]
            out = out + cross(query, *cross.keys(self.norm_split(part)), seen)
        return out

    def step(self, whole: Tensor, parts: Sequence[Tensor], valid: Sequence[Tensor], past: FusionPast) -> Tensor:
        """The next token (B, 1, W) of the whole body, fused with the parts' tokens of its step, each (B, m, W).

        Args:
            valid: (B, m) of each part, true on tokens that count.
        """
        if not past.begun:
            self._begin(whole, past)
        there = torch.ones_like(whole[..., 0], dtype=torch.bool)
        merged, counted = torch.cat([whole, *parts], dim=1), torch.cat([there, *valid], dim=1)
        normed = self.norm_own(merged)
        keys, values, seen = past.own.append(*self.own.keys(normed), counted)
        merged = merged + self.own(normed, keys, values, seen[:, None].expand(-1, merged.shape[1], -1))
        whole, *fused = merged.split([1, *(part.shape[1] for part in parts)], dim=1)
        query, out = self.norm_split(whole), whole
        for cross, part, own, kept in zip(self.attentions, fused, valid, past.parts, strict=True):
            keys, values, seen = kept.append(*cross.keys(self.norm_split(part)), own)
            out = out + cross(query, keys, values, seen[:, None])
        return out

    @property
    def attentions(self) -> list[Attention]:
        """The attention to each part."""
        return cast(list[Attention], list(self.cross))

    def _begin(self, whole: Tensor, past: FusionPast) -> None:
        """Let the separators be seen, which every later token looks at."""
        separators = self.norm_own(self.separators.expand(len(whole), -1, -1))
        past.own.append(*self.own.keys(separators), torch.ones_like(separators[..., 0], dtype=torch.bool))
        past.begun = True
