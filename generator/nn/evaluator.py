"""The evaluator: text and motion in one space, where a motion lies near the sentences that describe it.

The design is T2M's (Guo et al., CVPR 2022): motion at a quarter of the frame rate, static word vectors, one encoder a
side. The encoders are transformers, as in TMR (Petrovich et al., ICCV 2023), where T2M's are recurrent: on processors
they train several times faster.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.rnn import pad_sequence

from generator.bodies import WHOLE, channels
from generator.config import FEATURES, MAX_FRAMES, TEXT_WIDTH
from generator.nn.layers import Transformer

MIN_STD = 1e-3  # features that hardly vary are not blown up
STRIDE = 4
"""Frames that are read together: a quarter of the frame rate, as in T2M."""
CONTACTS = 4
"""The last channels, foot contacts, are not looked at, as in T2M."""


@dataclass(frozen=True)
class EvaluatorConfig:
    """Motion and text encoders of the evaluator.

    Attributes:
        width, layers, heads: of the transformer of each side.
        embedding: width of the space that both sides share.
        words: longest text that is read, in word pieces.
        dropout: of what the transformers read.
        features: width of the features.
        body: whose features are looked at, the "whole" body's or those of a part (ParTY, appendix B).
    """

    width: int
    layers: int
    heads: int
    embedding: int
    words: int = 80
    dropout: float = 0.1
    features: int = FEATURES
    body: str = WHOLE


class MotionTextEvaluator(nn.Module):
    """Embeddings (B, E) of motions and of texts, compared by their Euclidean distance.

    Args:
        config: sizes.
        mean, std: (263,) of the training features; read from the weights where absent.
    """

    mean: Tensor
    std: Tensor

    def __init__(self, config: EvaluatorConfig, mean: Tensor | None = None, std: Tensor | None = None) -> None:
        super().__init__()
        self.config = config
        self.register_buffer("mean", torch.zeros(config.features) if mean is None else mean.float())
        self.register_buffer("std", torch.ones(config.features) if std is None else std.float().clamp_min(MIN_STD))
        self.channels = [i for i in channels(config.body, config.features) if i < config.features - CONTACTS]
        self.motion = SequenceEncoder(len(self.channels) * STRIDE, MAX_FRAMES // STRIDE, config)
        self.text = SequenceEncoder(TEXT_WIDTH, config.words, config)

    def motion_embeddings(self, features: Sequence[Tensor]) -> Tensor:
        """Motions, each (T, 263) in the features' own units with T from 4 to 196, to (B, E).

        A rest of T modulo 4 frames is left out.
        """
        lengths = torch.tensor([len(rows) // STRIDE for rows in features])
        used = [rows[: n * STRIDE] for rows, n in zip(features, lengths.tolist(), strict=True)]
        padded = (pad_sequence(used, batch_first=True).to(self.mean.device) - self.mean) / self.std
        return self.motion(padded[..., self.channels].unflatten(1, (-1, STRIDE)).flatten(2), lengths)

    def text_embeddings(self, words: Sequence[Tensor]) -> Tensor:
        """Texts, each (n, 384) vectors of its words (`WordVectors`), to (B, E)."""
        lengths = torch.tensor([len(row) for row in words])
        return self.text(pad_sequence(list(words), batch_first=True).to(self.mean.device), lengths)


class SequenceEncoder(nn.Module):
    """Sequences (B, N, I) with their lengths (B,), N at most `longest`, to (B, E); padding has no influence."""

    def __init__(self, inputs: int, longest: int, config: EvaluatorConfig) -> None:
        super().__init__()
        self.dropout = config.dropout
        self.inputs = nn.Linear(inputs, config.width)
        self.position = nn.Parameter(0.02 * torch.randn(longest, config.width))
        self.transformer = Transformer(
            width=config.width,
            layers=config.layers,
            heads=config.heads,
            feed_forward=2 * config.width,
            dropout=0.0,
        )
        self.outputs = nn.Linear(config.width, config.embedding)

    def forward(self, values: Tensor, lengths: Tensor) -> Tensor:
        mask = (torch.arange(values.shape[1]) < lengths[:, None]).to(values.device)
        hidden = functional.dropout(self.inputs(values), self.dropout, self.training) + self.position[: mask.shape[1]]
        hidden = self.transformer(hidden, mask).float()
        pooled = (hidden * mask[..., None]).sum(1) / mask.sum(1, keepdim=True)
        return self.outputs(pooled).float()
