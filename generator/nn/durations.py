"""How long a segment lasts, from its text."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import MAX_SEGMENTS, TEXT_WIDTH
from generator.nn.whitening import WhitenedText
from generator.text.counts import MOST

MIN_LOG_STD, MAX_LOG_STD = -3.0, 1.0


@dataclass(frozen=True)
class DurationsConfig:
    """Multi-layer perceptron from a segment's text to the distribution of its duration."""

    width: int


class DurationModel(nn.Module):
    """Log-normal distribution of a segment's duration in s, from its text, the repetitions that it
    names, its place and the number of segments."""

    def __init__(self, config: DurationsConfig) -> None:
        super().__init__()
        self.white = WhitenedText()
        self.network = nn.Sequential(
            nn.Linear(TEXT_WIDTH + 2 * MOST + 2 * MAX_SEGMENTS, config.width),
            nn.GELU(),
            nn.Dropout(0.2),
            nn.Linear(config.width, config.width),
            nn.GELU(),
            nn.Linear(config.width, 2),
        )

    def forward(self, text: Tensor, repetitions: Tensor, place: Tensor, count: Tensor) -> tuple[Tensor, Tensor]:
        """Embeddings (N, 384), repetitions in both clauses (N, 2), place of each segment (N,) from 0, number of
        segments in its motion (N,).

        Returns: mean and log of the standard deviation of the log of the duration in s, both (N,).
        """
        steps = torch.arange(MAX_SEGMENTS, device=text.device)
        around = torch.cat([place[:, None] == steps, count[:, None] - 1 == steps], dim=1).to(text.dtype)
        numbers = functional.one_hot(repetitions, MOST + 1)[..., 1:].flatten(1).to(text.dtype)
        mean, log_std = self.network(torch.cat([self.white(text), numbers, around], dim=1)).float().unbind(-1)
        return mean, log_std.clamp(MIN_LOG_STD, MAX_LOG_STD)
