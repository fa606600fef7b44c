"""Training of the mask transformer: mask loss and alignment loss (SegMo, equations 7 to 9)."""

from dataclasses import asdict
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import Training, checked
from generator.models.segmo.config import MaskLosses, SegmoSampling, TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer, mask_tokens
from generator.models.segmo.objectives.batches import TokenBatch, TokenBatches, TokenCorpus
from generator.training.stages import StageJob
from ros_free_stack.errors import InvalidOption

VALIDATION_CLIPS = 512
VALIDATION_SEED = 20


def from_job(job: StageJob) -> "MaskObjective":
    """The objective of a stage of training: of the mask transformer, or of another one that is built like it."""
    config = job.model(TransformerConfig)
    corpus = TokenCorpus.build(job.dataset, job.folder("tokenizer"), job.device, clauses=config.clauses)
    objective = MaskObjective(corpus, config, job.training, job.objective(MaskLosses), job.seed, job.stage)
    objective.facts["sampling"] = asdict(checked(SegmoSampling, job.preset.sampling, "sampling"))
    return objective


def check_tokens(corpus: TokenCorpus, config: TransformerConfig) -> None:
    """InvalidOption unless the model speaks the tokenizer's tokens."""
    layers, parts, codes, _ = corpus.codebooks.shape
    if (config.quantizers, config.parts, config.codes) != (layers, parts, codes):
        raise InvalidOption(
            "model",
            f"is for {config.quantizers} quantizers of {config.codes} codes in {config.parts} parts, the tokenizer "
            f"has {layers} of {codes} in {parts}; train both with the same preset and size",
        )


class MaskObjective:
    """Cross-entropy of the masked base tokens, plus the alignment of text and motion.

    Raises:
        InvalidOption: segments are to be aligned in a model that reads no segments.
    """

    def __init__(
        self,
        corpus: TokenCorpus,
        config: TransformerConfig,
        training: Training,
        losses: MaskLosses,
        seed: int,
        name: str = "mask",
    ) -> None:
        if config.conditioning == "sentence" and losses.alignment not in ("none", "global"):
            raise InvalidOption(
                "alignment", f"a model that reads the sentence alone knows none or global, found {losses.alignment}"
            )
        check_tokens(corpus, config)
        self.name, self.config = name, config
        self.facts = {**corpus.facts(), "training": asdict(training), "objective": asdict(losses)}
        self.model: Any = MaskTransformer(config)
        if losses.start == "codes":
            self.model.start_from(corpus.codebooks[0])
        self.model.conditioning.fit(*corpus.training_texts())
        self._objective = losses
        self._batches = TokenBatches(
            corpus, batch=training.batch, layout=config.layout, segmentation=losses.segmentation, seed=seed
        )
        self._held = self._batches.held(VALIDATION_CLIPS)

    def loss(self, iteration: int) -> dict[str, Tensor]:
        batch = self._batches.training(iteration)
        return self._losses(self.model, batch, *dropped_conditions(len(batch.motion_segments), self.config))

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Losses on held-out clips with the same masks each time."""
        sums: dict[str, float] = {}
        with torch.random.fork_rng():
            torch.manual_seed(VALIDATION_SEED)
            for batch in self._held:
                keep = torch.full((len(batch.motion_segments),), self.config.condition_dropout < 1)
                for name, value in self._losses(model, batch, keep, keep).items():
                    sums[name] = sums.get(name, 0.0) + float(value) / len(self._held)
        return sums

    def _losses(
        self, model: nn.Module, batch: TokenBatch, keep_sentence: Tensor, keep_text: Tensor
    ) -> dict[str, Tensor]:
        """The losses, and the share of masked tokens that are guessed right.

        Motions whose text the model was not shown are aligned too: their hidden tokens cannot repeat the text.
        """
        assert isinstance(model, MaskTransformer)
        device = model.position.device
        tokens, condition = batch.tokens[: self.config.parts].to(device), batch.condition.to(device)
        masked, chosen = mask_tokens(tokens, condition.token_mask, self.config.codes)
        output = model(masked, condition, keep_sentence.to(device), keep_text.to(device))
        logits, target = output.logits[chosen].float(), tokens[chosen]
        mask_loss = functional.cross_entropy(logits, target)
        losses = {"loss": mask_loss, "mask": mask_loss, "accuracy": (logits.argmax(-1) == target).float().mean()}
        if self._objective.alignment != "none":
            losses["alignment"] = model.alignment.loss(
                self._objective.alignment,
                output.hidden,
                output.sentence,
                output.segments,
                batch.motion_segments.to(device),
            )
            losses["loss"] = mask_loss + self._objective.alignment_weight * losses["alignment"]
        return losses


def dropped_conditions(batch: int, config: TransformerConfig) -> tuple[Tensor, Tensor]:
    """Which of the motions are trained with their sentence, and which with any text, two (B,) flags."""
    keep_sentence = torch.rand(batch) >= config.sentence_dropout
    return keep_sentence, torch.rand(batch) >= config.condition_dropout
