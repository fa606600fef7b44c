"""The autoregressive transformer of one body: its next token from the ones before and what its place is told."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn

from generator.models.party.condition import StepConditioning
from generator.models.party.config import ConditioningKind
from generator.nn.causal import NEVER, CausalTransformer, Past

STD = 0.02


@dataclass(frozen=True)
class BodySizes:
    """Sizes of a body's transformer: G codebooks of K codes; `row_width` of the texts that it reads."""

    width: int
    layers: int
    heads: int
    feed_forward: int
    dropout: float
    groups: int
    codes: int
    row_width: int
    conditioning: ConditioningKind


class BodyTransformer(nn.Module):
    """Causal transformer over tokens of one body, each of G codes; the code number K of the first codebook ends it."""

    def __init__(self, sizes: BodySizes) -> None:
        super().__init__()
        self.groups, self.codes = sizes.groups, sizes.codes
        self.embedding = nn.Embedding(sizes.groups * sizes.codes, sizes.width)
        self.places = StepConditioning(sizes.width, sizes.row_width, sizes.conditioning)
        self.transformer = CausalTransformer(
            width=sizes.width,
            layers=sizes.layers,
            heads=sizes.heads,
            feed_forward=sizes.feed_forward,
            dropout=sizes.dropout,
        )
        self.head = TokenHead(sizes.width, sizes.groups, sizes.codes)
        nn.init.normal_(self.embedding.weight, std=STD)

    def embed(self, tokens: Tensor) -> Tensor:
        """Tokens (B, n, G) to (B, n, W); what ends a body counts as code 0, which nothing reads."""
        tables = torch.arange(self.groups, device=tokens.device) * self.codes
        return self.embedding(tokens.clamp(0, self.codes - 1) + tables).sum(-2)

    def hidden(self, earlier: Tensor, told: Tensor, past: Sequence[Past] | None = None) -> Tensor:
        """(B, N, W) of the last layer at each place.

        Args:
            earlier: (B, N, W) of the token before each place, zero at the first one.
            told: (B, N, W) what the places are told.
            past: of each layer, where the places are the next ones.
        """
        return self.transformer(earlier + told, past)


class TokenHead(nn.Module):
    """Logits of the G codes of a token, one after the other: each is told the ones before it."""

    def __init__(self, width: int, groups: int, codes: int) -> None:
        super().__init__()
        self.codes = codes
        self.outputs = nn.ModuleList(nn.Linear(width, codes + 1) for _ in range(groups))
        self.told = nn.ModuleList(nn.Embedding(codes, width) for _ in range(groups - 1))
        self.norms = nn.ModuleList(nn.LayerNorm(width) for _ in range(groups - 1))

    def forward(self, hidden: Tensor, tokens: Tensor) -> Tensor:
        """(B, n, G, K + 1) logits from hidden tokens (B, n, W) and the tokens themselves (B, n, G)."""
        codes = iter(tokens.unbind(-1))
        found: list[Tensor] = []

        def remember(logits: Tensor) -> Tensor:
            found.append(logits)
            return next(codes)

        self.draw(hidden, remember)
        return torch.stack(found, dim=-2)

    def draw(self, hidden: Tensor, choose: Callable[[Tensor], Tensor]) -> Tensor:
        """(B, n, G) codes, each chosen from its logits (B, n, K + 1); only the first one can be K, the end."""
        chosen = choose(self.output(0)(hidden))
        codes = [chosen]
        for group, (told, norm) in enumerate(zip(self.told, self.norms, strict=True), start=1):
            hidden = hidden + told(chosen.clamp(0, self.codes - 1))
            logits = self.output(group)(norm(hidden))
            end = torch.full_like(logits[..., -1:], NEVER)
            chosen = choose(torch.cat([logits[..., :-1], end], dim=-1))
            codes.append(chosen)
        return torch.stack(codes, dim=-1)

    def output(self, group: int) -> nn.Linear:
        """What scores the codes of a codebook."""
        return cast(nn.Linear, self.outputs[group])
