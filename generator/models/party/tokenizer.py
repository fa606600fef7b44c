"""Temporal-aware VQ-VAEs (ParTY, section 3.1): features of a body to tokens of a window of frames, and back.

Padded frames and windows have no influence: every convolution reads zeros there, as it does beyond the ends.
"""

from dataclasses import dataclass
from typing import cast

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.bodies import WHOLE, channels
from generator.models.party.config import TokenizerConfig
from generator.models.party.temporal import GlobalEnhancement, LocalEnhancement, Mean, window_mask
from generator.nn.convolution import ResidualBlock
from generator.nn.quantizer import ResidualQuantizer

MIN_STD = 1e-3  # features that hardly vary are not blown up


@dataclass(frozen=True)
class Reconstruction:
    """Standardised features of a body after a trip through its tokens (B, T, C), and the approximation loss."""

    features: Tensor
    approximation: Tensor


class BodyTokenizer(nn.Module):
    """The VQ-VAE of one body, on its C standardised features."""

    def __init__(self, config: TokenizerConfig, body: str) -> None:
        super().__init__()
        self.window, self.groups = config.window_of(body), config.groups_of(body)
        self.channels = channels(body, config.features)
        inner, code = config.encoder_width, config.code_width
        self.first = nn.Conv1d(len(self.channels), inner, 3, padding=1)
        self.frames = nn.ModuleList(ResidualBlock(inner, 2**i) for i in reversed(range(config.depth)))
        self.last = nn.Conv1d(inner, code, 3, padding=1)
        self.local = LocalEnhancement(code, self.window) if config.local else Mean(self.window)
        self.graph = None if config.graph == "none" else GlobalEnhancement(code, config.graph)
        self.quantizers = nn.ModuleList(
            ResidualQuantizer(quantizers=1, codes=config.codes_of(body), width=code // self.groups)
            for _ in range(self.groups)
        )
        self.enter = nn.Conv1d(code, config.width, 3, padding=1)
        self.blocks = nn.ModuleList(ResidualBlock(config.width, 2**i) for i in reversed(range(config.depth)))
        # Windows overlap by half, so that their boundaries leave no steps in the motion.
        self.leave = nn.ConvTranspose1d(
            config.width, len(self.channels), 2 * self.window, self.window, self.window // 2
        )

    def forward(self, features: Tensor, mask: Tensor) -> Reconstruction:
        """Features (B, T, C) with their mask (B, T), T whole windows, through the tokens and back."""
        windows = window_mask(mask, self.window)
        latent = self.encode(features, mask)
        with torch.autocast(latent.device.type, enabled=False):
            values, approximation = self._straight_through(latent.float(), windows)
        return Reconstruction(self.decode(values, windows), approximation)

    def encode(self, features: Tensor, mask: Tensor) -> Tensor:
        """(B, n, D) what the codes of features (B, T, C) stand for."""
        kept = mask[:, None].to(features.dtype)
        hidden = self.first(features.transpose(1, 2) * kept)
        for block in self.frames:
            hidden = block(hidden * kept)
        hidden = self.last(functional.relu(hidden) * kept).transpose(1, 2)
        windows = self.local(hidden, mask)
        return windows if self.graph is None else self.graph(windows, window_mask(mask, self.window))

    def decode(self, values: Tensor, mask: Tensor) -> Tensor:
        """Codes (B, n, D) with their mask (B, n) to features (B, n * window, C)."""
        kept = mask[:, None].to(values.dtype)
        hidden = functional.relu(self.enter(values.transpose(1, 2) * kept))
        for block in self.blocks:
            hidden = block(hidden * kept)
        return self.leave(functional.relu(hidden) * kept).transpose(1, 2).float()

    def tokens(self, features: Tensor, mask: Tensor) -> Tensor:
        """(B, n, G) tokens of features (B, T, C); those of windows without frames do not matter."""
        shares = self.encode(features, mask).float().chunk(self.groups, dim=-1)
        found = [book.nearest(share.flatten(0, 1), 0) for book, share in zip(self.books, shares, strict=True)]
        return torch.stack(found, dim=-1).unflatten(0, (len(features), -1))

    def values(self, tokens: Tensor) -> Tensor:
        """(B, n, D) codes of tokens (B, n, G)."""
        books = zip(self.books, tokens.unbind(-1), strict=True)
        return torch.cat([book.decode(own[None]) for book, own in books], dim=-1)

    def _straight_through(self, latent: Tensor, windows: Tensor) -> tuple[Tensor, Tensor]:
        """Codes (B, n, D) in place of what they stand for, and the approximation loss; padding teaches no codebook."""
        found = [
            book(share[windows][None])
            for book, share in zip(self.books, latent.chunk(self.groups, dim=-1), strict=True)
        ]
        values = torch.zeros_like(latent)
        values[windows] = torch.cat([one.values[0] for one in found], dim=-1)
        return values, torch.stack([one.commitment for one in found]).mean()

    @property
    def books(self) -> list[ResidualQuantizer]:
        """The codebook of each group."""
        return cast(list[ResidualQuantizer], list(self.quantizers))


class PartyTokenizer(nn.Module):
    """The VQ-VAEs of all bodies; works on features in their own units.

    Args:
        config: sizes.
        mean, std: (F,) of the training features; read from the weights where absent.
    """

    mean: Tensor
    std: Tensor

    def __init__(self, config: TokenizerConfig, mean: Tensor | None = None, std: Tensor | None = None) -> None:
        super().__init__()
        self.config = config
        self.register_buffer("mean", torch.zeros(config.features) if mean is None else mean.float())
        self.register_buffer("std", torch.ones(config.features) if std is None else std.float().clamp_min(MIN_STD))
        self.bodies = nn.ModuleDict({body: BodyTokenizer(config, body) for body in config.bodies})

    def body(self, name: str) -> BodyTokenizer:
        """The VQ-VAE of a body."""
        return cast(BodyTokenizer, self.bodies[name])

    def standardise(self, features: Tensor) -> Tensor:
        return (features - self.mean) / self.std

    @torch.no_grad()
    def encode(self, features: Tensor, frames: Tensor) -> dict[str, Tensor]:
        """Features (B, T, F) in their own units, of (B,) frames each, to the tokens (B, n, G) of each body.

        A motion has as many tokens of a body as cover its frames; the last one may cover less than its window.
        """
        standard = self.standardise(features)
        mask = torch.arange(features.shape[1], device=features.device) < frames.to(features.device)[:, None]
        found = {}
        for name in self.config.bodies:
            body = self.body(name)
            rest = -features.shape[1] % body.window
            own = functional.pad(standard[..., list(body.channels)], (0, 0, 0, rest))
            found[name] = body.tokens(own, functional.pad(mask, (0, rest)))
        return found

    @torch.no_grad()
    def decode(self, tokens: dict[str, Tensor], frames: Tensor) -> Tensor:
        """Tokens (B, n, G) of the whole body, or of all parts where there is none, to features (B, T, F) in their own
        units, T the most of the (B,) frames."""
        most = int(frames.max())
        out = torch.zeros(len(frames), most, len(self.mean), device=self.mean.device)
        for name in (WHOLE,) if self.config.holistic else self.config.parts:
            body = self.body(name)
            count = -(-most // body.window)
            places = torch.arange(count, device=self.mean.device) * body.window
            mask = places < frames.to(places.device)[:, None]
            found = body.decode(body.values(tokens[name][:, :count]), mask)
            out[..., list(body.channels)] = found[:, :most]
        return out * self.std + self.mean
