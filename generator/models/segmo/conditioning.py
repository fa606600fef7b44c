"""What a motion is generated from: the sentence, its segments in order, and how long each segment lasts.

MoMask puts the pooled sentence before the motion tokens ("sentence"). SegMo adds the ordered segments ("segments",
section 3.2) and leaves it to attention to find out which segment a token belongs to. Short segments then get lost.
With "layout" each motion token is also told its own segment's text, the segment's number, how far into the segment it
is, and, where the text names a number of repetitions, that number and how far into a repetition it would be.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
import torch
from numpy.typing import ArrayLike
from torch import Tensor, nn
from torch.nn import functional

from generator.config import MAX_SEGMENTS, TEXT_WIDTH
from generator.model import TextCondition
from generator.models.segmo.config import TOKEN_FRAMES, ConditioningKind
from generator.nn.whitening import WhitenedText
from generator.text.counts import MOST

PROGRESS_WAVES = 4
TOKEN_WAVELENGTHS = (4.0, 10.0, 25.0, 60.0)
REPETITION_MARGINS = (0, 2, 4)
"""Tokens at either end of a segment in which, as may be, nothing is repeated yet or any more."""
REPETITION_FEATURES = 4 * len(REPETITION_MARGINS) + MOST


@dataclass(frozen=True)
class Condition:
    """Texts and layout of B motions of at most A segments.

    Attributes:
        sentence: (B, 384) sentence embeddings.
        segments: (B, A, 2, 384) embeddings of each segment's main clause and of what happens meanwhile, zero where
            nothing does; rows beyond a motion's segments do not matter.
        counts: (B, A, 2) how often each clause says that something is done, 0 where it does not say.
        lengths: (B, A) tokens of each segment, 0 beyond a motion's segments.
    """

    sentence: Tensor
    segments: Tensor
    counts: Tensor
    lengths: Tensor

    @classmethod
    def of(cls, text: TextCondition, *, clauses: bool) -> Self:
        """What these models read of texts, in clauses or whole segments; segments last whole tokens."""
        whole = torch.stack([text.segments, torch.zeros_like(text.segments)], dim=2)
        return cls(text.sentence, text.clauses if clauses else whole, text.counts, text.frames // TOKEN_FRAMES)

    @property
    def segment_mask(self) -> Tensor:
        """(B, A) true where there is a segment."""
        return self.lengths > 0

    @cached_property
    def tokens(self) -> int:
        """Tokens of the longest motion."""
        return int(self.lengths.sum(1).max())

    @cached_property
    def token_mask(self) -> Tensor:
        """(B, T) true on tokens, false on padding."""
        return self._places < self.lengths.sum(1, keepdim=True)

    @cached_property
    def segment_of(self) -> Tensor:
        """(B, T) number of the segment that each token belongs to; that of the last one on padding."""
        return segment_numbers(self.lengths, self.tokens)

    @cached_property
    def elapsed(self) -> Tensor:
        """(B, T) tokens since the segment began."""
        starts = self.lengths.cumsum(1) - self.lengths
        return self._places - starts.gather(1, self.segment_of)

    @cached_property
    def lasting(self) -> Tensor:
        """(B, T) length of each token's segment."""
        return self.lengths.gather(1, self.segment_of)

    @property
    def _places(self) -> Tensor:
        return torch.arange(self.tokens, device=self.lengths.device)[None]

    def to(self, device: torch.device | str) -> Self:
        return type(self)(*(part.to(device) for part in (self.sentence, self.segments, self.counts, self.lengths)))

    def repeated(self, times: int) -> Self:
        """The whole batch `times` over."""
        return type(self)(
            self.sentence.repeat(times, 1),
            self.segments.repeat(times, 1, 1, 1),
            self.counts.repeat(times, 1, 1),
            self.lengths.repeat(times, 1),
        )

    def __getitem__(self, rows: Tensor) -> Self:
        return type(self)(self.sentence[rows], self.segments[rows], self.counts[rows], self.lengths[rows])


def segment_numbers(lengths: Tensor, tokens: int) -> Tensor:
    """(B, T) number of the segment that each token belongs to, from (B, A) lengths; that of the last one on padding."""
    places = torch.arange(tokens, device=lengths.device)[None, :, None]
    number = (places >= lengths.cumsum(1)[:, None]).sum(-1)
    return torch.minimum(number, (lengths > 0).sum(1, keepdim=True) - 1)


@dataclass(frozen=True)
class Conditioning:
    """What a transformer reads of a condition.

    Attributes:
        prefix: (B, 1 + A, W) the sentence's token and the segments', to stand before the motion tokens.
        prefix_mask: (B, 1 + A) true where there is such a token.
        local: (B, T, W) to be added to the motion tokens, or a zero.
        sentence: (B, W) the sentence's token before any was dropped.
        segments: (B, A, W) segment tokens before their numbers were added and before any was dropped. A is 0 where
            the model reads the sentence alone.
    """

    prefix: Tensor
    prefix_mask: Tensor
    local: Tensor
    sentence: Tensor
    segments: Tensor


class ClauseProjection(nn.Module):
    """(..., 2, 384) whitened clauses of segments to (..., W): each clause has its own projection, which add up."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.main = nn.Linear(TEXT_WIDTH, width)
        self.meanwhile = nn.Linear(TEXT_WIDTH, width, bias=False)

    def forward(self, clauses: Tensor) -> Tensor:
        main, meanwhile = clauses.unbind(-2)
        return self.main(main) + self.meanwhile(meanwhile)


class SegmentConditioning(nn.Module):
    """Conditioning of the mask and residual transformers, of width W; `reads` is a TransformerConfig.conditioning."""

    def __init__(self, width: int, reads: ConditioningKind) -> None:
        super().__init__()
        self.reads = reads
        self.white_sentence = WhitenedText()
        self.sentence = nn.Linear(TEXT_WIDTH, width)
        if reads != "sentence":
            self.white_segment = WhitenedText()
            self.segment = ClauseProjection(width)
            self.prefix_number = _small_table(width)
        if reads == "layout":
            self.local = ClauseProjection(width)
            self.local_number = _small_table(width)
            self.progress = nn.Linear(2 * PROGRESS_WAVES + 6 * len(TOKEN_WAVELENGTHS), width)
            self.repetition = nn.Linear(2 * REPETITION_FEATURES, width, bias=False)
            nn.init.zeros_(self.repetition.weight)

    def fit(self, sentences: np.ndarray, segments: np.ndarray) -> None:
        """Learn the whitening of the training texts, (N, 384) and (M, 384)."""
        self.white_sentence.fit(sentences)
        if self.reads != "sentence":
            self.white_segment.fit(segments)

    def forward(self, condition: Condition, keep_sentence: Tensor, keep_text: Tensor) -> Conditioning:
        """Condition of B motions; where `keep_text` (B,) is false no text is seen, where `keep_sentence` (B,) is
        false the sentence is not. The layout in time is always seen, so that guidance acts on the words."""
        sentence = self.sentence(self.white_sentence(condition.sentence))
        prefix = (sentence * (keep_sentence & keep_text)[:, None])[:, None]
        nothing = sentence.new_zeros(1, 1, 1)
        if self.reads == "sentence":
            return Conditioning(prefix, condition.segment_mask[:, :1], nothing, sentence, sentence[:, None][:, :0])
        clauses = self.clauses(condition.segments)
        segments = self.segment(clauses)
        numbered = segments + self.prefix_number.weight[: segments.shape[1]]
        keep = keep_text[:, None, None].to(segments.dtype)
        prefix = torch.cat([prefix, numbered * keep], dim=1)
        prefix_mask = functional.pad(condition.segment_mask, (1, 0), value=True)
        local = self._local(clauses, keep, condition) if self.reads == "layout" else nothing
        return Conditioning(prefix, prefix_mask, local, sentence, segments)

    def clauses(self, embeddings: Tensor) -> Tensor:
        """Whitened (..., 2, 384) texts of segments; what is absent stays zero."""
        return self.white_segment(embeddings) * embeddings.any(-1, keepdim=True)

    def _local(self, clauses: Tensor, keep: Tensor, condition: Condition) -> Tensor:
        """(B, T, W) what each token is told of its own segment, from the whitened clauses (B, A, 2, 384)."""
        number = condition.segment_of
        texts = self.local(clauses) * keep
        own_text = texts.gather(1, number[..., None].expand(-1, -1, texts.shape[-1]))
        repeated = self.repetition(_repetition(condition)) * keep
        return own_text + repeated + self.local_number(number) + self.progress(_progress(condition))


def _small_table(width: int) -> nn.Embedding:
    table = nn.Embedding(MAX_SEGMENTS, width)
    nn.init.normal_(table.weight, std=0.02)
    return table


def _progress(condition: Condition) -> Tensor:
    """(B, T, 32) waves of the share of the segment that is over, and of the tokens behind, ahead, and in all."""
    behind, lasting = condition.elapsed.float(), condition.lasting.float().clamp_min(1)
    octaves = math.pi * 2.0 ** torch.arange(PROGRESS_WAVES, device=behind.device)
    rates = 2 * math.pi / torch.tensor(TOKEN_WAVELENGTHS, device=behind.device)
    times = torch.stack([behind, lasting - 1 - behind, lasting], dim=-1)
    angles = torch.cat(
        [((behind + 0.5) / lasting)[..., None] * octaves, (times[..., None] * rates).flatten(-2)], dim=-1
    )
    return torch.cat([angles.sin(), angles.cos()], dim=-1)


def _repetition(condition: Condition) -> Tensor:
    """(B, T, 40) of each clause: waves of the repetitions and of every second one, as if they filled the segment but
    for each of the margins, and which number it is; zeros where there is none."""
    counts = condition.counts.gather(1, condition.segment_of[..., None].expand(-1, -1, 2))
    margins = torch.tensor(REPETITION_MARGINS, device=counts.device)
    behind, lasting = condition.elapsed[..., None] + 0.5, condition.lasting[..., None]
    over = ((behind - margins) / (lasting - 2 * margins).clamp_min(1)).clamp(0, 1)
    angles = math.pi * counts[..., None] * over[:, :, None]
    waves = torch.cat([angles.sin(), angles.cos(), (2 * angles).sin(), (2 * angles).cos()], dim=-1)
    number = functional.one_hot(counts, MOST + 1)[..., 1:]
    return torch.cat([waves * (counts > 0)[..., None], number], dim=-1).flatten(-2)


def stack_lengths(rows: Sequence[ArrayLike]) -> Tensor:
    """(B, A) of segment lengths, padded with zeros."""
    return nn.utils.rnn.pad_sequence([torch.as_tensor(np.asarray(row)) for row in rows], batch_first=True).long()
