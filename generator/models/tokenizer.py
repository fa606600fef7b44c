"""The motion tokenizer: a residual VQ-VAE between 263 features a frame and tokens of four frames."""

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import FEATURES, TOKEN_FRAMES, TokenizerConfig
from generator.models.quantizer import ResidualQuantizer

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
        self.register_buffer("mean", torch.zeros(FEATURES) if mean is None else mean.float())
        self.register_buffer("std", torch.ones(FEATURES) if std is None else std.float().clamp_min(MIN_STD))
        self.encoder = _encoder(config)
        self.quantizer = ResidualQuantizer(
            quantizers=config.quantizers,
            codes=config.codes,
            width=config.code_width,
            dropout=config.quantizer_dropout,
        )
        self.decoder = _decoder(config)

    def standardise(self, features: Tensor) -> Tensor:
        return (features - self.mean) / self.std

    def forward(self, standardised: Tensor) -> Reconstruction:
        """Standardised features (B, T, 263), T a multiple of four, through the tokens and back."""
        latent = self.encoder(standardised.transpose(1, 2)).transpose(1, 2)
        with torch.autocast(latent.device.type, enabled=False):
            quantized = self.quantizer(latent)
        return Reconstruction(self._decode(quantized.values), quantized.commitment)

    @torch.no_grad()
    def encode(self, features: Tensor) -> Tensor:
        """Features (B, T, 263) in their own units to tokens (Q, B, T // 4); a rest of T modulo 4 frames is left out."""
        frames = features.shape[1] // TOKEN_FRAMES * TOKEN_FRAMES
        latent = self.encoder(self.standardise(features[:, :frames]).transpose(1, 2)).transpose(1, 2)
        return self.quantizer(latent).tokens

    @torch.no_grad()
    def decode(self, tokens: Tensor) -> Tensor:
        """Tokens (Q', B, n) of the first Q' layers to features (B, 4 n, 263) in their own units."""
        return self._decode(self.quantizer.decode(tokens)) * self.std + self.mean

    def _decode(self, latent: Tensor) -> Tensor:
        return self.decoder(latent.transpose(1, 2)).transpose(1, 2).float()


class ResidualBlock(nn.Module):
    """x + conv1(relu(dilated conv3(relu(x)))) on (B, C, T)."""

    def __init__(self, width: int, dilation: int) -> None:
        super().__init__()
        self.wide = nn.Conv1d(width, width, 3, padding=dilation, dilation=dilation)
        self.point = nn.Conv1d(width, width, 1)

    def forward(self, inputs: Tensor) -> Tensor:
        return inputs + self.point(functional.relu(self.wide(functional.relu(inputs))))


def _blocks(config: TokenizerConfig) -> list[nn.Module]:
    dilations = [config.dilation_growth**i for i in reversed(range(config.depth))]
    return [ResidualBlock(config.width, dilation) for dilation in dilations]


def _encoder(config: TokenizerConfig) -> nn.Sequential:
    width = config.width
    if config.stem == "patch":
        down: list[nn.Module] = [nn.Conv1d(FEATURES, width, 2 * TOKEN_FRAMES, TOKEN_FRAMES, 2), *_blocks(config)]
    else:
        down = [nn.Conv1d(FEATURES, width, 3, padding=1), nn.ReLU()]
        for _ in range(2):
            down += [nn.Conv1d(width, width, 4, 2, 1), *_blocks(config)]
    return nn.Sequential(*down, nn.Conv1d(width, config.code_width, 3, padding=1))


def _decoder(config: TokenizerConfig) -> nn.Sequential:
    width = config.width
    up: list[nn.Module] = [nn.Conv1d(config.code_width, width, 3, padding=1)]
    if config.stem == "patch":
        # Windows overlap by half, so that token boundaries leave no steps in the motion.
        up += [*_blocks(config), nn.ReLU(), nn.ConvTranspose1d(width, FEATURES, 2 * TOKEN_FRAMES, TOKEN_FRAMES, 2)]
        return nn.Sequential(*up)
    up.append(nn.ReLU())
    for _ in range(2):
        up += [*_blocks(config), nn.Upsample(scale_factor=2.0), nn.Conv1d(width, width, 3, padding=1)]
    return nn.Sequential(*up, nn.ReLU(), nn.Conv1d(width, FEATURES, 3, padding=1))
