"""The residual transformer: predicts the tokens of each residual layer from those of the layers below."""

import torch
from torch import Tensor, nn

from generator.config import MAX_TOKENS, Sampling, TransformerConfig
from generator.models.conditioning import Condition, SegmentConditioning
from generator.models.layers import Transformer
from generator.models.mask_transformer import sample


class ResidualTransformer(nn.Module):
    """One transformer for all residual layers, told which one it predicts (SegMo, equation 5).

    A layer's codes have one embedding, which reads them as input and scores them as output.
    """

    def __init__(self, config: TransformerConfig) -> None:
        super().__init__()
        self.config = config
        width, layers, codes = config.width, config.quantizers, config.codes
        self.embedding = nn.Parameter(0.02 * torch.randn(layers, codes, width))
        self.bias = nn.Parameter(torch.zeros(layers, codes))
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
        """Tokens (Q', B, T) of at least the `layer` lowest layers to logits (B, T, K) of that layer, 1 <= layer < Q."""
        given = self.conditioning(condition, keep_sentence, keep_text)
        below = torch.stack([self.embedding[i][tokens[i]] for i in range(layer)]).sum(0)
        motion = below + self.layer.weight[layer] + self.position[: below.shape[1]] + given.local
        mask = torch.cat([given.prefix_mask, condition.token_mask], dim=1)
        hidden = self.transformer(torch.cat([given.prefix, motion], dim=1), mask)[:, given.prefix.shape[1] :]
        return self.output(hidden) @ self.embedding[layer].T + self.bias[layer]

    @torch.inference_mode()
    def generate(
        self,
        base: Tensor,
        condition: Condition,
        sampling: Sampling,
        generator: torch.Generator,
        known: Tensor | None = None,
    ) -> Tensor:
        """Base tokens (B, T) to the tokens of all layers (Q, B, T), layer by layer.

        `known` (Q, B, T) gives tokens that stay as they are, and -1 for those to be generated.
        """
        tokens = base[None]
        for layer in range(1, self.config.quantizers):
            logits = self._guided(tokens, layer, condition, sampling.residual_guidance)
            drawn, _ = sample(logits, sampling.residual_temperature, sampling.top_k, generator)
            if known is not None:
                drawn = torch.where(known[layer] >= 0, known[layer], drawn)
            tokens = torch.cat([tokens, drawn[None]])
        return tokens

    def _guided(self, tokens: Tensor, layer: int, condition: Condition, scale: float) -> Tensor:
        """Logits with classifier-free guidance."""
        keep = torch.ones(tokens.shape[1], dtype=torch.bool, device=tokens.device)
        if scale == 1:
            return self(tokens, layer, condition, keep, keep).float()
        both = torch.cat([keep, ~keep])
        logits = self(tokens.repeat(1, 2, 1), layer, condition.repeated(2), both, both).float()
        with_text, without = logits.chunk(2)
        return without + scale * (with_text - without)
