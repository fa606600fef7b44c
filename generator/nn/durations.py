"""How long a segment lasts, from its text."""

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import MAX_SEGMENTS, MAX_TOKENS, MIN_TOKENS, TEXT_WIDTH, TOKEN_FRAMES, DurationsConfig
from generator.models.segmo.conditioning import WhitenedText, check_segments
from generator.text.counts import MOST
from ros_free_stack.skeleton import FPS

MIN_LOG_STD, MAX_LOG_STD = -3.0, 1.0


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


def whole_tokens(durations_s: np.ndarray, least: int = MIN_TOKENS, most: int = MAX_TOKENS) -> np.ndarray:
    """Durations (A,) in s to whole tokens (A,), at least one each, with rounding errors that do not add up.

    A total outside of `least` to `most` tokens, by default the 2 to 9.8 s that the models take, stretches or shrinks
    all segments alike.
    """
    wanted = durations_s * FPS / TOKEN_FRAMES
    total = min(max(round(wanted.sum()), least), most)
    check_segments(len(wanted), total)
    ends = np.cumsum(wanted / wanted.sum() * total)
    edges = [0]
    for i, end in enumerate(ends, start=1):
        edges.append(min(max(round(end), edges[-1] + 1), total - (len(ends) - i)))
    return np.diff(edges)
