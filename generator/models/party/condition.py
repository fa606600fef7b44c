"""What the transformers are conditioned on: texts as rows, the sentence first, and where each token stands in time."""

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Self

import torch
from torch import Tensor, nn

from generator.config import MAX_FRAMES, TEXT_WIDTH
from generator.model import TextCondition
from generator.models.party.config import ConditioningKind
from generator.nn.whitening import WhitenedText

ROW_WIDTH = 3 * TEXT_WIDTH
"""Of what is read of a row: the text, its main clause and what happens meanwhile."""
PROGRESS_WAVES = 4
WAVELENGTHS_S = (0.8, 2.0, 5.0, 12.0)
PROGRESS_WIDTH = 2 * (PROGRESS_WAVES + 3 * len(WAVELENGTHS_S))
FPS = 20.0  # of the wavelengths; another rate only scales them


@dataclass(frozen=True)
class Condition:
    """Texts of B motions of at most A segments.

    Attributes:
        texts: (B, R, 384) embeddings of the sentence, and of the segments where these are read.
        clauses: (B, R, 2, 384) of each row's main clause and of what happens meanwhile, zero where there is none.
        frames: (B, A) of each segment, 0 beyond a motion's segments.
    """

    texts: Tensor
    clauses: Tensor
    frames: Tensor

    @classmethod
    def of(cls, text: TextCondition, conditioning: ConditioningKind) -> Self:
        """What a model of that conditioning reads of texts."""
        sentence, nothing = text.sentence[:, None], torch.zeros_like(text.clauses[:, :1])
        if conditioning == "sentence":
            return cls(sentence, nothing, text.frames)
        return cls(torch.cat([sentence, text.segments], 1), torch.cat([nothing, text.clauses], 1), text.frames)

    @cached_property
    def total(self) -> Tensor:
        """(B,) frames of each motion."""
        return self.frames.sum(1)

    @cached_property
    def row_mask(self) -> Tensor:
        """(B, R) true on rows that hold a text."""
        there = torch.ones_like(self.frames[:, :1], dtype=torch.bool)
        return torch.cat([there, self.frames > 0], dim=1)[:, : self.texts.shape[1]]

    def counts(self, window: int) -> Tensor:
        """(B,) tokens of so many frames that cover each motion."""
        return -(-self.total // window)

    def mask(self, count: int, window: int) -> Tensor:
        """(B, count) true on tokens of each motion."""
        return torch.arange(count, device=self.frames.device) < self.counts(window)[:, None]

    def segment(self, count: int, window: int) -> Tensor:
        """(B, count) number of the segment that the middle of each token lies in; the last one beyond a motion."""
        middle = (torch.arange(count, device=self.frames.device) + 0.5) * window
        number = (middle[None, :, None] >= self.frames.cumsum(1)[:, None]).sum(-1)
        return torch.minimum(number, (self.frames > 0).sum(1, keepdim=True) - 1)

    def progress(self, count: int, window: int) -> Tensor:
        """(B, count, 32) waves of the share of its segment that is over at each token, of the time since the segment
        began and until it ends, and until the motion ends."""
        middle = (torch.arange(count, device=self.frames.device) + 0.5) * window
        number, ends = self.segment(count, window), self.frames.cumsum(1)
        end = ends.gather(1, number)
        lasting = self.frames.gather(1, number).clamp_min(1)
        left = end - middle
        octaves = math.pi * 2.0 ** torch.arange(PROGRESS_WAVES, device=middle.device)
        rates = 2 * math.pi / (FPS * torch.tensor(WAVELENGTHS_S, device=middle.device))
        times = torch.stack([lasting - left, left, self.total[:, None] - middle], dim=-1)
        over = (1 - left / lasting)[..., None] * octaves
        angles = torch.cat([over, (times[..., None] * rates).flatten(-2)], dim=-1)
        return torch.cat([angles.sin(), angles.cos()], dim=-1)

    def repeated(self, times: int) -> Self:
        """The whole batch `times` over."""
        return type(self)(*(torch.cat([getattr(self, field.name)] * times) for field in fields(self)))

    def to(self, device: torch.device | str) -> Self:
        return type(self)(*(getattr(self, field.name).to(device) for field in fields(self)))


class TextRows(nn.Module):
    """Whitened rows of texts: (B, R, 384) of the texts themselves, (B, R, 1152) with their clauses."""

    def __init__(self) -> None:
        super().__init__()
        self.white = WhitenedText()

    def forward(self, condition: Condition) -> tuple[Tensor, Tensor]:
        texts = self.white(condition.texts)
        clauses = self.white(condition.clauses) * condition.clauses.any(-1, keepdim=True)
        return texts, torch.cat([texts, clauses.flatten(-2)], dim=-1)


class StepConditioning(nn.Module):
    """What each token's place is told: its position; the first one the sentence; with "layout" its own segment's text
    and its progress too."""

    def __init__(self, width: int, row_width: int, conditioning: ConditioningKind) -> None:
        super().__init__()
        self.position = nn.Parameter(0.02 * torch.randn(MAX_FRAMES // 2 + 1, width))
        self.sentence = nn.Linear(row_width, width)
        self.layout = conditioning == "layout"
        if self.layout:
            self.segment = nn.Linear(row_width, width)
            self.progress = nn.Linear(PROGRESS_WIDTH, width)

    def forward(self, rows: Tensor, condition: Condition, keep: Tensor, count: int, window: int) -> Tensor:
        """(B, count, W) from rows (B, R, I) of texts, of which nothing is seen where `keep` (B,) is false."""
        seen = keep[:, None, None].to(rows.dtype)
        first = self.sentence(rows[:, :1]) * seen
        told = self.position[:count] + nn.functional.pad(first, (0, 0, 0, count - 1))
        if not self.layout:
            return told
        segments = (self.segment(rows[:, 1:]) * seen).gather(
            1, condition.segment(count, window)[..., None].expand(-1, -1, told.shape[-1])
        )
        return told + segments + self.progress(condition.progress(count, window))
