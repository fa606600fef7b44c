"""Training of the residual transformer: a random layer at each iteration, given all layers below it."""

from dataclasses import asdict
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import Training
from generator.models.segmo.config import TransformerConfig
from generator.models.segmo.objectives.batches import TokenBatch, TokenBatches, TokenCorpus
from generator.models.segmo.objectives.mask import VALIDATION_CLIPS, check_tokens, dropped_conditions
from generator.models.segmo.residual_transformer import ResidualTransformer
from generator.training.stages import StageJob


def from_job(job: StageJob) -> "ResidualObjective":
    """The objective of a stage of training."""
    config = job.model(TransformerConfig)
    corpus = TokenCorpus.build(job.dataset, job.folder("tokenizer"), job.device, clauses=config.clauses)
    return ResidualObjective(corpus, config, job.training, job.seed)


class ResidualObjective:
    """Cross-entropy of the tokens of one residual layer."""

    name = "residual"

    def __init__(self, corpus: TokenCorpus, config: TransformerConfig, training: Training, seed: int) -> None:
        check_tokens(corpus, config)
        self.config, self.facts = config, {**corpus.facts(), "training": asdict(training)}
        self.model: Any = ResidualTransformer(config)
        self.model.conditioning.fit(*corpus.training_texts())
        self._batches = TokenBatches(
            corpus, batch=training.batch, layout=config.layout, segmentation=config.layout, seed=seed
        )
        self._held = self._batches.held(VALIDATION_CLIPS)

    def loss(self, iteration: int) -> dict[str, Tensor]:
        batch = self._batches.training(iteration)
        layer = int(torch.randint(1, self.config.quantizers, ()))
        return self._losses(self.model, batch, layer, *dropped_conditions(len(batch.motion_segments), self.config))

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Mean over held-out clips and over the layers."""
        layers = range(1, self.config.quantizers)
        sums: dict[str, float] = {}
        for batch in self._held:
            keep = torch.ones(len(batch.motion_segments), dtype=torch.bool)
            for layer in layers:
                for name, value in self._losses(model, batch, layer, keep, keep).items():
                    sums[name] = sums.get(name, 0.0) + float(value) / (len(self._held) * len(layers))
        return sums

    def _losses(
        self, model: nn.Module, batch: TokenBatch, layer: int, keep_sentence: Tensor, keep_text: Tensor
    ) -> dict[str, Tensor]:
        device = self.model.position.device
        tokens, condition = batch.tokens.to(device), batch.condition.to(device)
        logits = model(tokens, layer, condition, keep_sentence.to(device), keep_text.to(device))
        own = tokens[layer * self.config.parts : (layer + 1) * self.config.parts]
        valid = condition.token_mask.expand(own.shape)
        logits, target = logits[valid].float(), own[valid]
        loss = functional.cross_entropy(logits, target)
        return {"loss": loss, "accuracy": (logits.argmax(-1) == target).float().mean()}
