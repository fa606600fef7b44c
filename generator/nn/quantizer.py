"""Residual vector quantization with codebooks that follow the data by moving averages."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

DECAY = 0.99
DEAD_SHARE = 0.02  # of the mean usage of a code, below which it is placed anew


@dataclass(frozen=True)
class Quantized:
    """Result of quantization.

    Attributes:
        values: (B, T, D) sum of the chosen codes; the gradient passes straight through to the input.
        tokens: (Q', B, T) indices of the Q' quantizers used, base layer first.
        commitment: mean squared distance of each layer's input to its code, a scalar.
    """

    values: Tensor
    tokens: Tensor
    commitment: Tensor


class ResidualQuantizer(nn.Module):
    """Each quantizer codes what the ones before it left over (SegMo, equation 2).

    Codebooks are no parameters: they follow the exponential moving average of the vectors that chose them. The first
    training batch initialises them; a code that is hardly ever chosen moves onto a random input.

    Args:
        quantizers, codes, width: Q layers of K codes of D numbers.
    """

    codebooks: Tensor
    usage: Tensor
    started: Tensor

    def __init__(self, *, quantizers: int, codes: int, width: int) -> None:
        super().__init__()
        self.register_buffer("codebooks", torch.zeros(quantizers, codes, width))
        self.register_buffer("usage", torch.ones(quantizers, codes))
        self.register_buffer("started", torch.zeros((), dtype=torch.bool))

    def forward(self, inputs: Tensor, layers: int | None = None) -> Quantized:
        """Quantize (B, T, D) by the first layers, all if not told; in training also learn their codebooks."""
        residual = inputs.float().flatten(0, 1)
        flat, commitment, tokens = residual, residual.new_zeros(()), []
        layers = layers if layers is not None and self.started else len(self.codebooks)
        for layer in range(layers):
            if self.training and not self.started:
                self.codebooks[layer] = _sample(residual.detach(), len(self.usage[layer]))
            chosen = self.nearest(residual.detach(), layer)
            code = functional.embedding(chosen, self.codebooks[layer])
            commitment = commitment + functional.mse_loss(residual, code) / layers
            if self.training:
                self._learn(residual.detach(), chosen, layer)
            residual = residual - code
            tokens.append(chosen)
        if self.training and layers == len(self.codebooks):
            self.started.fill_(True)
        values = flat - residual.detach()  # straight through: value of the codes, gradient of the input
        return Quantized(values.view(inputs.shape), torch.stack(tokens).view(layers, *inputs.shape[:2]), commitment)

    def decode(self, tokens: Tensor) -> Tensor:
        """Tokens (Q', B, T) of the first Q' <= Q layers to their vectors (B, T, D)."""
        return torch.stack(
            [functional.embedding(chosen, book) for chosen, book in zip(tokens, self.codebooks, strict=False)]
        ).sum(0)

    def nearest(self, vectors: Tensor, layer: int) -> Tensor:
        """Index (N,) of the code nearest to each of (N, D) vectors."""
        book = self.codebooks[layer]
        return (book.square().sum(1) - 2 * vectors @ book.T).argmin(1)

    @torch.no_grad()
    def _learn(self, vectors: Tensor, chosen: Tensor, layer: int) -> None:
        """Move the codes towards the mean of the vectors that chose them.

        With usage u and code c = s / u, the averages u' = g u + (1 - g) n and s' = g s + (1 - g) S give
        c' = c + (1 - g) (S - n c) / u', so that the sums s need not be kept.
        """
        book, usage = self.codebooks[layer], self.usage[layer]
        count = torch.bincount(chosen, minlength=len(book)).to(usage)
        total = torch.zeros_like(book).index_add_(0, chosen, vectors)
        usage.mul_(DECAY).add_(count, alpha=1 - DECAY)
        book.add_((total - count[:, None] * book) / usage.clamp_min(1e-3)[:, None], alpha=1 - DECAY)
        dead = usage < DEAD_SHARE * len(vectors) / len(book)
        if dead.any():
            book[dead] = _sample(vectors, int(dead.sum()))
            usage[dead] = 1.0


def _sample(vectors: Tensor, count: int) -> Tensor:
    """`count` rows of the vectors; distinct ones where there are enough."""
    if len(vectors) >= count:
        return vectors[torch.randperm(len(vectors))[:count].to(vectors.device)]
    return vectors[torch.randint(len(vectors), (count,)).to(vectors.device)]
