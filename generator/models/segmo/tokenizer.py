"""The motion tokenizer: a residual VQ-VAE between 263 features a frame and tokens of four frames.

Each part of the body has an encoder and quantizers of its own; one decoder reads the codes of all parts. The rows of
tokens are the layers, base layer first, and within a layer the parts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn

from generator.models.segmo.config import TOKEN_FRAMES, TokenizerConfig
from generator.models.segmo.parts import part_channels
from generator.nn.convolution import ResidualBlock
from generator.nn.quantizer import Quantized, ResidualQuantizer

MIN_STD = 1e-3  # features that hardly vary are not blown up


@dataclass(frozen=True)
class Reconstruction:
    """Standardised features after a trip through the tokens (B, T, 263), and the commitment loss, a scalar."""

    features: Tensor
    commitment: Tensor


class MotionTokenizer(nn.Module):
    """Residual VQ-VAE (SegMo, section 3.2, after MoMask); works on features in their own units.

    Args:
        config: sizes.
        mean, std: (263,) of the training features; read from the weights where absent.
    """

    mean: Tensor
    std: Tensor

    def __init__(self, config: TokenizerConfig, mean: Tensor | None = None, std: Tensor | None = None) -> None:
        super().__init__()
        self.config = config
        self.register_buffer("mean", torch.zeros(config.features) if mean is None else mean.float())
        self.register_buffer("std", torch.ones(config.features) if std is None else std.float().clamp_min(MIN_STD))
        self.channels = part_channels(config.parts, config.features)
        self.encoders = nn.ModuleList(_encoder(config, len(channels)) for channels in self.channels)
        self.quantizers = nn.ModuleList(
            ResidualQuantizer(
                quantizers=config.quantizers,
                codes=config.codes,
                width=config.code_width,
            )
            for _ in self.channels
        )
        self.decoder = _decoder(config, len(self.channels))

    @property
    def codebooks(self) -> Tensor:
        """(Q, P, K, D) codes of each layer and part."""
        return torch.stack([quantizer.codebooks for quantizer in self._quantizers()], dim=1)

    def standardise(self, features: Tensor) -> Tensor:
        return (features - self.mean) / self.std

    def forward(self, standardised: Tensor) -> Reconstruction:
        """Standardised features (B, T, 263), T a multiple of four, through the tokens and back."""
        found = self._quantized(standardised, self._layers())
        commitment = torch.stack([quantized.commitment for quantized in found]).mean()
        return Reconstruction(self._decode([quantized.values for quantized in found]), commitment)

    @torch.no_grad()
    def encode(self, features: Tensor) -> Tensor:
        """Features (B, T, 263) in their own units to tokens (Q P, B, T // 4) of Q layers of P parts.

        A rest of T modulo 4 frames is left out.
        """
        frames = features.shape[1] // TOKEN_FRAMES * TOKEN_FRAMES
        found = self._quantized(self.standardise(features[:, :frames]))
        return torch.stack([quantized.tokens for quantized in found], dim=1).flatten(0, 1)

    @torch.no_grad()
    def decode(self, tokens: Tensor) -> Tensor:
        """Tokens (Q' P, B, n) of the first Q' layers to features (B, 4 n, 263) in their own units."""
        parts = tokens.unflatten(0, (-1, len(self.quantizers))).unbind(1)
        values = [quantizer.decode(rows) for quantizer, rows in zip(self._quantizers(), parts, strict=True)]
        return self._decode(values) * self.std + self.mean

    def _layers(self) -> int:
        """How many layers this batch uses: one number for all parts, as generation has it."""
        total = self.config.quantizers
        if not self.training or total == 1 or torch.rand(()) >= self.config.quantizer_dropout:
            return total
        return int(torch.randint(1, total, ()))

    def _quantized(self, standardised: Tensor, layers: int | None = None) -> list[Quantized]:
        """The codes of each part."""
        found: list[Quantized] = []
        for encoder, quantizer, channels in zip(self.encoders, self._quantizers(), self.channels, strict=True):
            latent = encoder(standardised[..., channels].transpose(1, 2)).transpose(1, 2)
            with torch.autocast(latent.device.type, enabled=False):
                found.append(quantizer(latent, layers))
        return found

    def _quantizers(self) -> list[ResidualQuantizer]:
        return cast(list[ResidualQuantizer], list(self.quantizers))

    def _decode(self, parts: Sequence[Tensor]) -> Tensor:
        latent = torch.cat(list(parts), dim=-1).transpose(1, 2)
        return self.decoder(latent).transpose(1, 2).float()


def _blocks(config: TokenizerConfig, width: int) -> list[nn.Module]:
    dilations = [config.dilation_growth**i for i in reversed(range(config.depth))]
    return [ResidualBlock(width, dilation) for dilation in dilations]


def _encoder(config: TokenizerConfig, channels: int) -> nn.Sequential:
    width = config.encoder_width
    if config.stem == "patch":
        down: list[nn.Module] = [nn.Conv1d(channels, width, 2 * TOKEN_FRAMES, TOKEN_FRAMES, 2), *_blocks(config, width)]
    else:
        down = [nn.Conv1d(channels, width, 3, padding=1), nn.ReLU()]
        for _ in range(2):
            down += [nn.Conv1d(width, width, 4, 2, 1), *_blocks(config, width)]
    return nn.Sequential(*down, nn.Conv1d(width, config.code_width, 3, padding=1))


def _decoder(config: TokenizerConfig, parts: int) -> nn.Sequential:
    width = config.width
    up: list[nn.Module] = [nn.Conv1d(parts * config.code_width, width, 3, padding=1)]
    if config.stem == "patch":
        # Windows overlap by half, so that token boundaries leave no steps in the motion.
        up += [*_blocks(config, width), nn.ReLU()]
        return nn.Sequential(*up, nn.ConvTranspose1d(width, config.features, 2 * TOKEN_FRAMES, TOKEN_FRAMES, 2))
    up.append(nn.ReLU())
    for _ in range(2):
        up += [*_blocks(config, width), nn.Upsample(scale_factor=2.0), nn.Conv1d(width, width, 3, padding=1)]
    return nn.Sequential(*up, nn.ReLU(), nn.Conv1d(width, config.features, 3, padding=1))
