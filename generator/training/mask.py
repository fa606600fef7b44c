"""Training of the mask transformer: mask loss and alignment loss (SegMo, equations 7 to 9)."""

from dataclasses import asdict
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import Training, TransformerConfig
from generator.models.alignment import alignment_loss
from generator.models.conditioning import Condition
from generator.models.mask_transformer import MaskTransformer, mask_tokens
from generator.training.batches import TokenBatches, TokenCorpus

VALIDATION_CLIPS = 512
VALIDATION_SEED = 20


class MaskObjective:
    """Cross-entropy of the masked base tokens, plus the alignment of segments with their texts."""

    name = "mask"

    def __init__(self, corpus: TokenCorpus, config: TransformerConfig, training: Training, seed: int) -> None:
        self.config, self.facts = config, {**corpus.facts(), "training": asdict(training)}
        self.model: Any = MaskTransformer(config)
        self.model.conditioning.fit(*corpus.training_texts())
        self._training = training
        self._batches = TokenBatches(corpus, batch=training.batch, layout=config.layout, seed=seed)
        self._held = self._batches.held(VALIDATION_CLIPS)

    def loss(self, iteration: int) -> dict[str, Tensor]:
        batch = self._batches.training(iteration)
        device = self.model.position.device
        keep_sentence, keep_text = dropped_conditions(len(batch.condition.lengths), self.config, device)
        return self._losses(
            self.model, batch.tokens[0].to(device), batch.condition.to(device), keep_sentence, keep_text
        )

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Losses on held-out clips with the same masks each time."""
        device = self.model.position.device
        sums: dict[str, float] = {}
        with torch.random.fork_rng():
            torch.manual_seed(VALIDATION_SEED)
            for batch in self._held:
                keep = torch.ones(len(batch.condition.lengths), dtype=torch.bool, device=device)
                tokens, condition = batch.tokens[0].to(device), batch.condition.to(device)
                for name, value in self._losses(model, tokens, condition, keep, keep).items():
                    sums[name] = sums.get(name, 0.0) + float(value) / len(self._held)
        return sums

    def _losses(
        self, model: nn.Module, tokens: Tensor, condition: Condition, keep_sentence: Tensor, keep_text: Tensor
    ) -> dict[str, Tensor]:
        """The losses, and the share of masked tokens that are guessed right."""
        assert isinstance(model, MaskTransformer)
        masked, chosen = mask_tokens(tokens, condition.token_mask, self.config.codes)
        output = model(masked, condition, keep_sentence, keep_text)
        logits, target = output.logits[chosen].float(), tokens[chosen]
        mask_loss = functional.cross_entropy(logits, target)
        losses = {"loss": mask_loss, "mask": mask_loss, "accuracy": (logits.argmax(-1) == target).float().mean()}
        if self._training.alignment_weight:
            kept = condition[keep_text]
            text = model.alignment.text_embeddings(output.segments[keep_text])
            motion = model.alignment.motion_embeddings(output.hidden[keep_text][:, : kept.tokens], kept)
            losses["alignment"] = alignment_loss(text, motion, kept.segment_mask)
            losses["loss"] = mask_loss + self._training.alignment_weight * losses["alignment"]
        return losses


def dropped_conditions(batch: int, config: TransformerConfig, device: torch.device) -> tuple[Tensor, Tensor]:
    """Which of the motions are trained with their sentence, and which with any text, two (B,) flags."""
    keep_sentence = torch.rand(batch, device=device) >= config.sentence_dropout
    return keep_sentence, torch.rand(batch, device=device) >= config.condition_dropout
