"""What every generator is: a model from text to frames of features, and what it is given.

Evaluation, verification, editing and continuation know this file alone. Whether a model has tokens, how long a token
lasts and how it was trained are its own affair.
"""

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Literal, Protocol, Self

import torch
from torch import Tensor


@dataclass(frozen=True)
class FeatureSpec:
    """What a model's frames are.

    Attributes:
        width: features of a frame.
        fps: frames a second.
        least_frames, most_frames: shortest and longest motion.
        token_frames: frames that come and stay together; the lengths of segments are multiples of it.
        layout: how a sentence's segments share its time: "predicted" from their texts, or "uniform".
    """

    width: int
    fps: float
    least_frames: int
    most_frames: int
    token_frames: int = 1
    layout: Literal["predicted", "uniform"] = "predicted"

    @property
    def token_s(self) -> float:
        """Duration of what comes and stays together."""
        return self.token_frames / self.fps

    @property
    def least_s(self) -> float:
        """Duration of the shortest motion."""
        return self.least_frames / self.fps

    @property
    def most_s(self) -> float:
        """Duration of the longest motion."""
        return self.most_frames / self.fps

    def whole(self, frames: int) -> int:
        """As many of the frames as fill whole tokens."""
        return frames // self.token_frames * self.token_frames


@dataclass(frozen=True)
class TextCondition:
    """Texts of B motions of at most A segments, and how long each segment lasts; W is the text encoder's width.

    Attributes:
        sentence: (B, W) pooled embedding of the whole sentence.
        tokens, token_mask: (B, L, W) embeddings of its word pieces, (B, L) true on them.
        segments: (B, A, W) pooled embeddings of the segment texts; rows beyond a motion's segments do not matter.
        clauses: (B, A, 2, W) the same of each segment's main clause and of its concurrent one, zero where it has none.
        counts: (B, A, 2) how often each clause says that something is done, 0 where it does not say.
        frames: (B, A) of each segment, 0 beyond a motion's segments.
        parts: (B, P, W) texts of parts of the body; in training only.
    """

    sentence: Tensor
    tokens: Tensor
    token_mask: Tensor
    segments: Tensor
    clauses: Tensor
    counts: Tensor
    frames: Tensor
    parts: Tensor | None = None

    def __len__(self) -> int:
        return len(self.sentence)

    @property
    def segment_mask(self) -> Tensor:
        """(B, A) true where there is a segment."""
        return self.frames > 0

    def __getitem__(self, rows: Tensor | slice) -> Self:
        """The motions of these rows."""
        return replace(self, **{name: value[rows] for name in _names() if (value := getattr(self, name)) is not None})

    def lasting(self, frames: Tensor) -> Self:
        """The same texts with (B, A) frames of each segment."""
        return replace(self, frames=frames.to(self.frames))

    def repeated(self, times: int) -> Self:
        """The whole batch `times` over."""
        return self[torch.arange(len(self), device=self.sentence.device).repeat(times)]

    def to(self, device: torch.device | str) -> Self:
        """The condition on a device."""
        return replace(self, **{n: value.to(device) for n in _names() if (value := getattr(self, n)) is not None})


@dataclass(frozen=True)
class Known:
    """Frames of B motions that stay as they are.

    Attributes:
        features: (B, T, F) in their own units; where `mask` is false they do not matter.
        mask: (B, T) true on frames that stay.
        lead, trail: (P, F) and (Q, F) frames before the first and after the last one, the same for all motions, for a
            model that reads a frame together with its neighbours.
        latent: (..., B, n) what the model's own samples were made from, where the frames are such; exact, where
            reading the features again need not be.
    """

    features: Tensor
    mask: Tensor
    lead: Tensor
    trail: Tensor
    latent: Tensor | None = None

    def row(self, number: int, frames: int) -> Self:
        """The motion of that row, of so many frames, alone."""
        latent = None if self.latent is None else self.latent[..., number : number + 1, :]
        only = slice(number, number + 1)
        return replace(self, features=self.features[only, :frames], mask=self.mask[only, :frames], latent=latent)

    def repeated(self, times: int) -> Self:
        """The whole batch `times` over."""
        latent = None if self.latent is None else torch.cat([self.latent] * times, dim=-2)
        return replace(self, features=self.features.repeat(times, 1, 1), mask=self.mask.repeat(times, 1), latent=latent)


@dataclass(frozen=True)
class Sample:
    """A generated motion: (T, F) features in their own units, and what the model made them from (..., n) if it can
    take that back; see `Known.latent`."""

    features: Tensor
    latent: Tensor | None = None


@dataclass(frozen=True)
class Sampling:
    """How a model samples; None is what its preset says.

    Attributes:
        steps: iterations of decoding or denoising.
        guidance: scale of classifier-free guidance; 1 is none.
        temperature: of the distributions that are sampled from.
    """

    steps: int | None = None
    guidance: float | None = None
    temperature: float | None = None


class MotionModel(Protocol):
    """A trained generator."""

    @property
    def name(self) -> str:
        """Says which weights made a motion."""
        ...

    @property
    def spec(self) -> FeatureSpec:
        """What its frames are."""
        ...

    def sample(
        self, text: TextCondition, *, known: Known | None, sampling: Sampling, noise: torch.Generator
    ) -> list[Sample]:
        """A motion for each row of the texts, of as many frames as its segments have; the same noise, the same motion.

        Args:
            known: frames that stay.
            noise: of the device that the model is on.
        """
        ...

    def reconstruct(self, features: Tensor) -> Tensor | None:
        """Features (T, F) after a trip through the model's own representation; None where it has none."""
        ...

    @classmethod
    def load(cls, folder: Path, *, device: str) -> Self:
        """Read a folder of trained weights.

        Raises:
            NoWeights: a stage is not trained; the message says what to do.
        """
        ...


def _names() -> list[str]:
    return [field.name for field in fields(TextCondition)]
