"""The mask transformer: fills in masked base tokens, and generates them from nothing but masks."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import torch
from torch import Tensor, nn

from generator.models.segmo.alignment import SegmentAlignment
from generator.models.segmo.conditioning import Condition, Conditioning, SegmentConditioning
from generator.models.segmo.config import MAX_TOKENS, SegmoSampling, TransformerConfig
from generator.nn.layers import Transformer

RANDOM_SHARE, MASK_SHARE = 0.1, 0.88
EMBEDDING_STD = 0.02


@dataclass(frozen=True)
class MaskOutput:
    """Result of the mask transformer.

    Attributes:
        logits: (P, B, T, K) of the codes of each part.
        hidden: (B, T, W) motion tokens of the last layer.
        sentence, segments: (B, W), (B, A, W) text tokens; A is 0 where the model reads the sentence alone.
    """

    logits: Tensor
    hidden: Tensor
    sentence: Tensor
    segments: Tensor


class MaskTransformer(nn.Module):
    """Bidirectional transformer on sentence token, segment tokens and motion tokens (SegMo, equation 4).

    Where the tokenizer takes the body in P parts, the parts' tokens of one time enter as the sum of their embeddings,
    each masked or not by itself, and leave as one prediction each.
    """

    def __init__(self, config: TransformerConfig) -> None:
        super().__init__()
        self.config = config
        width = config.width
        self.embedding = nn.Embedding(config.parts * (config.codes + 1), width)
        self.position = nn.Parameter(0.02 * torch.randn(MAX_TOKENS, width))
        self.conditioning = SegmentConditioning(width, config.conditioning)
        self.transformer = Transformer(
            width=width,
            layers=config.layers,
            heads=config.heads,
            feed_forward=config.feed_forward,
            dropout=config.dropout,
        )
        self.output = nn.Linear(width, config.parts * config.codes)
        self.alignment = SegmentAlignment(width)
        nn.init.normal_(self.embedding.weight, std=EMBEDDING_STD)

    @torch.no_grad()
    def start_from(self, codebooks: Tensor) -> None:
        """Let codes that mean almost the same begin with almost the same embeddings and scores.

        The tokenizer's base codes (P, K, D) are projected at random, which keeps their distances (Johnson and
        Lindenstrauss 1984). Training would have to find them out from how codes are used.
        """
        parts, codes, _ = codebooks.shape
        centred = codebooks - codebooks.mean(1, keepdim=True)
        unit = centred / centred.square().sum(-1, keepdim=True).mean(1, keepdim=True).sqrt()

        def projected() -> Tensor:
            return unit @ torch.randn(parts, unit.shape[-1], self.config.width)

        self.embedding.weight.unflatten(0, (parts, -1))[:, :codes] = EMBEDDING_STD * projected()
        self.output.weight.copy_((self.output.weight.std() * projected()).flatten(0, 1))

    @property
    def mask_token(self) -> int:
        return self.config.codes

    def forward(self, tokens: Tensor, condition: Condition, keep_sentence: Tensor, keep_text: Tensor) -> MaskOutput:
        """Tokens (P, B, T), some of them the mask token, to predictions; for the (B,) flags see SegmentConditioning."""
        return self._predict(tokens, self.conditioning(condition, keep_sentence, keep_text), condition.token_mask)

    def _predict(self, tokens: Tensor, given: Conditioning, token_mask: Tensor) -> MaskOutput:
        tables = torch.arange(len(tokens), device=tokens.device)[:, None, None] * (self.config.codes + 1)
        motion = self.embedding(tokens + tables).sum(0) + self.position[: tokens.shape[2]] + given.local
        mask = torch.cat([given.prefix_mask, token_mask], dim=1)
        hidden = self.transformer(torch.cat([given.prefix, motion], dim=1), mask)[:, given.prefix.shape[1] :]
        logits = self.output(hidden).unflatten(-1, (len(tokens), -1)).permute(2, 0, 1, 3)
        return MaskOutput(logits, hidden, given.sentence, given.segments)

    @torch.inference_mode()
    def generate(
        self, condition: Condition, sampling: SegmoSampling, generator: torch.Generator, known: Tensor | None = None
    ) -> Tensor:
        """Base tokens (P, B, T): all masks at first, at each step the surest ones stay (cosine schedule of MaskGIT).

        `known` (P, B, T) gives tokens that stay as they are, and -1 for those to be generated.
        """
        valid = condition.token_mask.expand(self.config.parts, -1, -1)
        tokens = torch.full(valid.shape, self.mask_token, device=valid.device)
        if known is not None:
            tokens = torch.where(known >= 0, known, tokens)
        length = ((tokens == self.mask_token) & valid).sum((0, 2))
        guided = self._guided(condition, sampling.mask_guidance)
        for step in range(1, sampling.steps + 1):
            logits = guided(tokens)
            drawn, chance = sample(logits, sampling.temperature, sampling.top_k, generator)
            masked = tokens == self.mask_token
            tokens = torch.where(masked, drawn, tokens)
            # Tokens of earlier steps and padding rank last, so that only this step's least sure ones are masked again.
            surety = chance.masked_fill(~masked | ~valid, torch.inf)
            again = (math.cos(math.pi / 2 * step / sampling.steps) * length).floor().long()
            tokens = tokens.masked_fill((_ranks(surety) < again[:, None]) & masked & valid, self.mask_token)
        return tokens.masked_fill(~valid, 0)

    def _guided(self, condition: Condition, scale: float) -> Callable[[Tensor], Tensor]:
        """Tokens to logits with classifier-free guidance; what is conditioned on is read once for all steps."""
        times = 1 if scale == 1 else 2
        both = condition.repeated(times)
        keep = torch.arange(len(both.lengths), device=both.lengths.device) < len(condition.lengths)
        given = self.conditioning(both, keep, keep)

        def logits(tokens: Tensor) -> Tensor:
            found = self._predict(tokens.repeat(1, times, 1), given, both.token_mask).logits.float()
            with_text, without = found[:, : len(condition.lengths)], found[:, -len(condition.lengths) :]
            return without + scale * (with_text - without)

        return logits


def sample(logits: Tensor, temperature: float, top_k: float, generator: torch.Generator) -> tuple[Tensor, Tensor]:
    """Draw one code for each (..., K) of logits from the best share 1 - `top_k` of them.

    Returns: (...) codes and (...) their probability among all codes.
    """
    best, codes = logits.topk(max(1, round((1 - top_k) * logits.shape[-1])), dim=-1)
    weights = (best / temperature).softmax(-1)
    choice = torch.multinomial(weights.flatten(0, -2), 1, generator=generator).view(*logits.shape[:-1], 1)
    drawn = codes.gather(-1, choice)
    return drawn[..., 0], logits.softmax(-1).gather(-1, drawn)[..., 0]


def mask_tokens(tokens: Tensor, valid: Tensor, codes: int) -> tuple[Tensor, Tensor]:
    """Mask tokens (P, B, T) for training, as MoMask does.

    Of each motion's tokens, valid (B, T) in every part, the share cos(pi u / 2) is chosen, u uniform; of the chosen
    ones 10 % become random codes, 88 % of the rest the mask token (number `codes`), and what remains stays.

    Returns: the masked tokens and which were chosen, both (P, B, T).
    """
    shape, device = tokens.shape, tokens.device
    valid = valid.expand(shape)
    share = torch.cos(math.pi / 2 * torch.rand(shape[1], device=device))
    count = (share * valid.sum((0, 2))).round().clamp_min(1)
    order = _ranks(torch.rand(shape, device=device).masked_fill(~valid, torch.inf))
    chosen = (order < count[:, None]) & valid
    draw = torch.rand(shape, device=device)
    randomised = chosen & (draw < RANDOM_SHARE)
    hidden = chosen & (draw >= RANDOM_SHARE) & (draw < RANDOM_SHARE + (1 - RANDOM_SHARE) * MASK_SHARE)
    masked = torch.where(randomised, torch.randint_like(tokens, codes), tokens)
    return masked.masked_fill(hidden, codes), chosen


def _ranks(values: Tensor) -> Tensor:
    """(P, B, T) rank of each value among all those of its motion, from 0."""
    parts, batch, _ = values.shape
    order = values.transpose(0, 1).reshape(batch, -1).argsort(dim=1, stable=True)
    return order.argsort(1).view(batch, parts, -1).transpose(0, 1)
