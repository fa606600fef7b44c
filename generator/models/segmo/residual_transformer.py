"""The residual transformer: predicts the tokens of each residual layer from those of the layers below."""

import torch
from torch import Tensor, nn

from generator.models.segmo.conditioning import Condition, SegmentConditioning
from generator.models.segmo.config import MAX_TOKENS, SegmoSampling, TransformerConfig
from generator.models.segmo.mask_transformer import sample
from generator.nn.layers import Transformer


class ResidualTransformer(nn.Module):
    """One transformer for all residual layers, told which one it predicts (SegMo, equation 5).

    A layer's codes have one embedding, which reads them as input and scores them as output.
    """

    def __init__(self, config: TransformerConfig) -> None:
        super().__init__()
        self.config = config
        width, layers, codes = config.width, config.quantizers, config.codes
        self.embedding = nn.Parameter(0.02 * torch.randn(layers * config.parts, codes, width))
        self.bias = nn.Parameter(torch.zeros(layers * config.parts, codes))
        self.layer = nn.Embedding(layers, width)
        self.position = nn.Parameter(0.02 * torch.randn(MAX_TOKENS, width))
        self.conditioning = SegmentConditioning(width, config.conditioning)
        self.transformer = Transformer(
            width=width,
            layers=config.layers,
            heads=config.heads,
            feed_forward=config.feed_forward,
            dropout=config.dropout,
        )
        self.output = nn.Linear(width, width)
        nn.init.normal_(self.layer.weight, std=0.02)

    def forward(
        self, tokens: Tensor, layer: int, condition: Condition, keep_sentence: Tensor, keep_text: Tensor
    ) -> Tensor:
        """Tokens (Q' P, B, T) of at least the `layer` lowest layers of P parts to logits of that layer, 1 <= layer < Q.

        Returns: (P, B, T, K).
        """
        given = self.conditioning(condition, keep_sentence, keep_text)
        rows = layer * self.config.parts
        below = torch.stack([self.embedding[i][tokens[i]] for i in range(rows)]).sum(0)
        motion = below + self.layer.weight[layer] + self.position[: below.shape[1]] + given.local
        mask = torch.cat([given.prefix_mask, condition.token_mask], dim=1)
        hidden = self.transformer(torch.cat([given.prefix, motion], dim=1), mask)[:, given.prefix.shape[1] :]
        own = slice(rows, rows + self.config.parts)
        scores = torch.einsum("btw,pkw->pbtk", self.output(hidden), self.embedding[own])
        return scores + self.bias[own, None, None]

    @torch.inference_mode()
    def generate(
        self,
        base: Tensor,
        condition: Condition,
        sampling: SegmoSampling,
        generator: torch.Generator,
        known: Tensor | None = None,
    ) -> Tensor:
        """Base tokens (P, B, T) to those of as many layers as `sampling` asks for (Q' P, B, T), one after the other.

        `known` (Q P, B, T) gives tokens that stay as they are, and -1 for those to be generated.
        """
        tokens, parts = base, self.config.parts
        for layer in range(1, min(sampling.layers, self.config.quantizers)):
            logits = self._guided(tokens, layer, condition, sampling.residual_guidance)
            drawn, _ = sample(logits, sampling.residual_temperature, sampling.top_k, generator)
            if known is not None:
                given = known[layer * parts : (layer + 1) * parts]
                drawn = torch.where(given >= 0, given, drawn)
            tokens = torch.cat([tokens, drawn])
        return tokens

    def _guided(self, tokens: Tensor, layer: int, condition: Condition, scale: float) -> Tensor:
        """Logits with classifier-free guidance."""
        keep = torch.ones(tokens.shape[1], dtype=torch.bool, device=tokens.device)
        if scale == 1:
            return self(tokens, layer, condition, keep, keep).float()
        both = torch.cat([keep, ~keep])
        logits = self(tokens.repeat(1, 2, 1), layer, condition.repeated(2), both, both).float()
        with_text, without = logits.chunk(2, dim=1)
        return without + scale * (with_text - without)
