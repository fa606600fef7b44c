"""Training of the part-guided network: equations 10 and 11, text diversity and part texts, all at once."""

from dataclasses import asdict
from typing import Any

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import Training, checked
from generator.models.party.config import PartySampling, TransformerConfig, TransformerLosses
from generator.models.party.grounding import diversity_loss
from generator.models.party.network import PartyNetwork, Read
from generator.models.party.objectives.corpus import TokenBatch, TokenBatches, TokenCorpus
from generator.training.stages import StageJob
from ros_free_stack.console import say

VALIDATION_CLIPS = 512
VALIDATION_SEED = 20
IGNORED = -100


def from_job(job: StageJob) -> "TransformerObjective":
    """The objective of a stage of training."""
    corpus = TokenCorpus.build(job.dataset, job.folder("tokenizer"), job.device)
    objective = TransformerObjective(
        corpus, job.model(TransformerConfig), job.training, job.objective(TransformerLosses), job.seed
    )
    objective.facts["generator"] = job.generator.name
    objective.facts["sampling"] = asdict(checked(PartySampling, job.preset.sampling, "sampling"))
    return objective


class TransformerObjective:
    """Cross-entropy of every body's next token, the text diversity loss, and L1 of the grounded texts against what the
    parts do. A data set without part texts is trained without the latter, which is said."""

    name = "transformer"

    def __init__(
        self,
        corpus: TokenCorpus,
        config: TransformerConfig,
        training: Training,
        losses: TransformerLosses,
        seed: int,
    ) -> None:
        self.config = config
        self.facts: dict[str, Any] = {**corpus.facts(), "training": asdict(training), "objective": asdict(losses)}
        self.model: Any = PartyNetwork(config, corpus.config)
        self.model.text.white.fit(corpus.training_texts())
        if self.model.grounding is not None and losses.auxiliary and not corpus.with_parts:
            say("the data set does not say what arms and legs do: trained without the auxiliary loss of part texts")
        self._losses_of = losses
        self._batches = TokenBatches(corpus, batch=training.batch, conditioning=config.conditioning, seed=seed)
        self._held = self._batches.held(VALIDATION_CLIPS)

    def loss(self, iteration: int) -> dict[str, Tensor]:
        batch = self._batches.training(iteration).to(self._device)
        keep = torch.rand(len(batch.condition.frames), device=self._device) >= self.config.condition_dropout
        return self._losses(self.model, batch, keep, self._losses_of.corruption)

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Losses on held-out clips, their tokens read as they are."""
        sums: dict[str, float] = {}
        with torch.random.fork_rng():
            torch.manual_seed(VALIDATION_SEED)
            for held in self._held:
                batch = held.to(self._device)
                keep = torch.ones(len(batch.condition.frames), dtype=torch.bool, device=self._device)
                for name, value in self._losses(model, batch, keep, 0.0).items():
                    sums[name] = sums.get(name, 0.0) + float(value) / len(self._held)
        return sums

    @property
    def _device(self) -> torch.device:
        return self.model.text.white.mean.device

    def _losses(self, model: nn.Module, batch: TokenBatch, keep: Tensor, corruption: float) -> dict[str, Tensor]:
        assert isinstance(model, PartyNetwork)
        read_as = {
            body: corrupted(rows, model.tokens.codes_of(body), corruption) for body, rows in batch.tokens.items()
        }
        logits, read = model(read_as, batch.condition, keep)
        found, total = dict[str, Tensor](), torch.zeros((), device=keep.device)
        for body, said in logits.items():
            counts = batch.condition.counts(model.tokens.window_of(body))
            loss, accuracy = token_loss(said, batch.tokens[body], counts)
            total = total + loss
            found |= {body: loss, f"{body}_accuracy": accuracy}
        if model.grounding is not None:
            found |= self._text_losses(model, batch, read)
            total = total + self._losses_of.diversity * found["diversity"]
            total = total + self._losses_of.auxiliary * found.get("auxiliary", torch.zeros_like(total))
        return {"loss": total, **found}

    def _text_losses(self, model: PartyNetwork, batch: TokenBatch, read: Read) -> dict[str, Tensor]:
        """Equation 3, and the L1 loss of the grounded texts where the parts' texts are known."""
        assert read.grounded is not None
        there = batch.condition.row_mask
        found = {
            "diversity": diversity_loss(
                read.grounded.embeddings[there].float(), read.texts[there], self._losses_of.temperature
            )
        }
        errors = [
            (read.grounded.parts[part] - model.text.white(batch.parts[part])).abs().mean(-1)[told & there]
            for part, told in batch.told.items()
        ]
        if any(len(error) for error in errors):
            found["auxiliary"] = torch.cat(errors).mean()
        return found


def token_loss(logits: Tensor, tokens: Tensor, counts: Tensor) -> tuple[Tensor, Tensor]:
    """Mean negative log likelihood of a body's codes and of its end (equations 10 and 11), and how many are right.

    Args:
        logits: (B, n + 1, G, K + 1).
        tokens: (B, n, G), of which a motion has (B,) `counts`; code K of the first codebook comes after them.
    """
    end = logits.shape[-1] - 1
    target = functional.pad(tokens, (0, 0, 0, 1))
    place = torch.arange(target.shape[1], device=tokens.device)[None]
    target = target.masked_fill((place >= counts[:, None])[..., None], IGNORED)
    target[..., 0] = torch.where(place == counts[:, None], end, target[..., 0])
    chosen = target != IGNORED
    said, wanted = logits[chosen].float(), target[chosen]
    return functional.cross_entropy(said, wanted), (said.argmax(-1) == wanted).float().mean()


def corrupted(tokens: Tensor, codes: int, share: float) -> Tensor:
    """Tokens (B, n, G), a share of them with random codes."""
    if not share:
        return tokens
    wrong = torch.rand(tokens.shape[:2], device=tokens.device) < share
    return torch.where(wrong[..., None], torch.randint_like(tokens, codes), tokens)
