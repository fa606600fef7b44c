"""Whitening of text embeddings, kept with a model's weights."""

import numpy as np
import torch
from torch import Tensor, nn

from generator.config import TEXT_WIDTH
from generator.text.encoder import Whitener


class WhitenedText(nn.Module):
    """Whitening of text embeddings, kept with the weights. In a raw sentence embedding left and right hardly differ."""

    mean: Tensor
    matrix: Tensor

    def __init__(self) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(TEXT_WIDTH))
        self.register_buffer("matrix", torch.eye(TEXT_WIDTH))

    def fit(self, embeddings: np.ndarray) -> None:
        """Learn the whitening of (N, 384) training texts."""
        whitener = Whitener.fit(embeddings)
        self.mean.copy_(torch.from_numpy(whitener.mean))
        self.matrix.copy_(torch.from_numpy(whitener.matrix))

    def forward(self, embeddings: Tensor) -> Tensor:
        return (embeddings - self.mean) @ self.matrix
