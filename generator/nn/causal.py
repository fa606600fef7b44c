"""Attention that reads the past alone, whole sequences at once or token by token with what is kept of the past.

Attention is an explicit product, as in `generator.nn.layers`.
"""

from collections.abc import Sequence

import torch
from torch import Tensor, nn
from torch.nn import functional

NEVER = -1e4
"""Score of what must not be looked at; finite, so that a row without anything to look at stays finite."""


class Past:
    """Keys and values of the tokens that an attention has read, and which of them count."""

    def __init__(self) -> None:
        self._kept: tuple[Tensor, Tensor, Tensor] | None = None

    def append(self, keys: Tensor, values: Tensor, valid: Tensor) -> tuple[Tensor, Tensor, Tensor]:
        """Add keys and values (B, H, N, d) with their validity (B, N); all that there are now."""
        new = (keys, values, valid)
        if self._kept is not None:
            dimensions = (2, 2, 1)
            pairs = zip(self._kept, new, dimensions, strict=True)
            keys, values, valid = (torch.cat([old, own], dim=dimension) for old, own, dimension in pairs)
        self._kept = keys, values, valid
        return self._kept


class Attention(nn.Module):
    """Multi-head attention of queries (B, N, W) to other tokens (B, M, W)."""

    def __init__(self, width: int, heads: int, head_width: int | None = None) -> None:
        super().__init__()
        inner = heads * (head_width or width // heads)
        self.heads = heads
        self.queries = nn.Linear(width, inner)
        self.others = nn.Linear(width, 2 * inner)
        self.output = nn.Linear(inner, width)

    def keys(self, others: Tensor) -> tuple[Tensor, Tensor]:
        """Keys and values (B, H, M, d) of tokens."""
        keys, values = self.others(others).unflatten(-1, (2, self.heads, -1)).permute(2, 0, 3, 1, 4)
        return keys, values

    def weights(self, hidden: Tensor, keys: Tensor, allowed: Tensor) -> Tensor:
        """(B, H, N, M) attention of queries (B, N, W) where `allowed` (B or 1, N, M)."""
        queries = self.queries(hidden).unflatten(-1, (self.heads, -1)).transpose(1, 2)
        scores = (queries * queries.shape[-1] ** -0.5) @ keys.transpose(-1, -2)
        return scores.masked_fill(~allowed[:, None], NEVER).softmax(-1)

    def forward(self, hidden: Tensor, keys: Tensor, values: Tensor, allowed: Tensor) -> Tensor:
        """What queries (B, N, W) find in keys and values (B, H, M, d) where `allowed` (B or 1, N, M)."""
        mixed = self.weights(hidden, keys, allowed).to(values.dtype) @ values
        return self.output(mixed.transpose(1, 2).flatten(2))


class CausalBlock(nn.Module):
    """Causal attention and feed-forward, each behind a norm and added to its input."""

    def __init__(self, width: int, heads: int, feed_forward: int, dropout: float) -> None:
        super().__init__()
        self.norm_attention, self.norm_forward = nn.LayerNorm(width), nn.LayerNorm(width)
        self.attention = Attention(width, heads)
        self.widen, self.narrow = nn.Linear(width, feed_forward), nn.Linear(feed_forward, width)
        self.dropout = dropout

    def forward(self, hidden: Tensor, past: Past | None) -> Tensor:
        normed = self.norm_attention(hidden)
        keys, values = self.attention.keys(normed)
        if past is not None:
            keys, values, _ = past.append(keys, values, torch.ones_like(hidden[..., 0], dtype=torch.bool))
        count, total = hidden.shape[1], keys.shape[2]
        allowed = torch.ones(1, count, total, dtype=torch.bool, device=hidden.device).tril(total - count)
        hidden = hidden + self._drop(self.attention(normed, keys, values, allowed))
        return hidden + self._drop(self.narrow(functional.gelu(self.widen(self.norm_forward(hidden)))))

    def _drop(self, values: Tensor) -> Tensor:
        return functional.dropout(values, self.dropout, self.training) if self.dropout else values


class CausalTransformer(nn.Module):
    """A stack of causal blocks with a norm at the end, (B, N, W) to (B, N, W).

    Padding belongs after a sequence's own tokens, where none of them looks.
    """

    def __init__(self, *, width: int, layers: int, heads: int, feed_forward: int, dropout: float) -> None:
        super().__init__()
        self.blocks = nn.ModuleList(CausalBlock(width, heads, feed_forward, dropout) for _ in range(layers))
        self.norm = nn.LayerNorm(width)

    def forward(self, hidden: Tensor, past: Sequence[Past] | None = None) -> Tensor:
        """Whole sequences, or, with the `past` of each layer, the tokens that come next."""
        for number, block in enumerate(self.blocks):
            hidden = block(hidden, None if past is None else past[number])
        return self.norm(hidden)

    def past(self) -> tuple[Past, ...]:
        """An empty past of each layer."""
        return tuple(Past() for _ in self.blocks)
