"""How long a segment lasts, from its text."""

import torch
from torch import Tensor, nn

from generator.config import MAX_SEGMENTS, TEXT_WIDTH, DurationsConfig
from generator.models.conditioning import WhitenedText

MIN_LOG_STD, MAX_LOG_STD = -3.0, 1.0


class DurationModel(nn.Module):
    """Log-normal distribution of a segment's duration in s, from its text, its place and the number of segments."""

    def __init__(self, config: DurationsConfig) -> None:
        super().__init__()
        self.white = WhitenedText()
        self.network = nn.Sequential(
            nn.Linear(TEXT_WIDTH + 2 * MAX_SEGMENTS, config.width),
            nn.GELU(),
            nn.Dropout(0.2),
            nn.Linear(config.width, config.width),
            nn.GELU(),
            nn.Linear(config.width, 2),
        )

    def forward(self, text: Tensor, place: Tensor, count: Tensor) -> tuple[Tensor, Tensor]:
        """Embeddings (N, 384), place of each segment (N,) from 0, number of segments in its motion (N,).

        Returns: mean and log of the standard deviation of the log of the duration in s, both (N,).
        """
        steps = torch.arange(MAX_SEGMENTS, device=text.device)
        around = torch.cat([place[:, None] == steps, count[:, None] - 1 == steps], dim=1).to(text.dtype)
        mean, log_std = self.network(torch.cat([self.white(text), around], dim=1)).float().unbind(-1)
        return mean, log_std.clamp(MIN_LOG_STD, MAX_LOG_STD)
