"""Training of the evaluator: each motion and its caption against all others of the batch, and their mirror images."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import MAX_FRAMES, Training
from generator.corpus.mirror import mirror_words
from generator.corpus.mirrored_features import mirror_features
from generator.datasets.dataset import Clip, MotionDataset
from generator.nn.evaluator import STRIDE, EvaluatorConfig, MotionTextEvaluator
from generator.text.word_vectors import WordVectors
from generator.training.stages import StageJob
from ros_free_stack.errors import InvalidOption

BUCKET = 12  # batches that are drawn together and then sorted by length, so that little padding is computed
VALIDATION_CLIPS = 512


@dataclass(frozen=True)
class PairBatch:
    """Motions, each (T, 263) in the features' own units, and the text of each."""

    features: list[Tensor]
    texts: list[str]


def contrastive_loss(motion: Tensor, text: Tensor, same: Tensor) -> Tensor:
    """Cross-entropy of finding each motion's text among the batch and each text's motion, by Euclidean distance.

    T2M pushes mismatched pairs apart up to a margin; comparing each pair with all others of the batch at once ranks
    better, and the distance stays the one that the metrics measure.

    Args:
        motion, text: (B, E) embeddings of matching pairs.
        same: (B, B) true where two rows carry the same words, which are no mismatch.
    """
    logits = -torch.cdist(motion, text)
    pair = torch.arange(len(logits), device=logits.device)
    logits = logits.masked_fill(same & (pair[:, None] != pair), -torch.inf)
    return 0.5 * (functional.cross_entropy(logits, pair) + functional.cross_entropy(logits.T, pair))


def from_job(job: StageJob) -> "EvaluatorObjective":
    """The objective of a stage of training."""
    config = replace(job.model(EvaluatorConfig), features=job.dataset.layout.width)
    return EvaluatorObjective(job.dataset, config, job.training, job.seed)


class EvaluatorObjective:
    """The contrastive loss over the training split, a half of every batch being the mirror image of the other half.

    Mirror images are the mismatches that are hardest to tell: left against right.

    Raises:
        InvalidOption: the batch is odd.
    """

    name = "evaluator"

    def __init__(self, dataset: MotionDataset, config: EvaluatorConfig, training: Training, seed: int) -> None:
        self._clips = [clip for clip in dataset.split("train") if clip.length >= STRIDE]
        self.config, self.facts = config, {"clips": len(self._clips), "training": asdict(training)}
        if training.batch % 2:
            raise InvalidOption("batch", f"half of it are mirror images, found {training.batch}")
        self.model: Any = MotionTextEvaluator(config, torch.from_numpy(dataset.mean), torch.from_numpy(dataset.std))
        self._dataset, self._half, self._seed = dataset, training.batch // 2, seed
        self._vectors = WordVectors()
        self._lengths = np.array([clip.length for clip in self._clips])
        self._chance = np.array([clip.weight for clip in self._clips])
        self._chance /= self._chance.sum()
        self._drawn: tuple[int, np.ndarray] = (-1, np.empty(0))
        held = (dataset.split("val") or tuple(self._clips))[:VALIDATION_CLIPS]
        chunks = [held[start : start + training.batch] for start in range(0, len(held), training.batch)]
        self._held = [self._pairs(chunk, [0] * len(chunk)) for chunk in chunks]

    def loss(self, iteration: int) -> dict[str, Tensor]:
        batch = self._training(iteration)
        mirrored = [
            torch.from_numpy(mirror_features(rows.numpy(), self._dataset.layout.skeleton)) for rows in batch.features
        ]
        texts = [mirror_words(text) for text in batch.texts]
        return self._losses(self.model, PairBatch(batch.features + mirrored, batch.texts + texts))

    def validate(self, model: nn.Module) -> dict[str, float]:
        sums: dict[str, float] = {}
        for batch in self._held:
            for name, value in self._losses(model, batch).items():
                sums[name] = sums.get(name, 0.0) + float(value.detach()) / len(self._held)
        return sums

    def _losses(self, model: nn.Module, batch: PairBatch) -> dict[str, Tensor]:
        """The loss, and the share of texts whose own motion is the nearest of the batch."""
        assert isinstance(model, MotionTextEvaluator)
        numbers = {text: number for number, text in enumerate(dict.fromkeys(batch.texts))}
        words = torch.tensor([numbers[text] for text in batch.texts], device=model.mean.device)
        motion = model.motion_embeddings([rows.to(model.mean.device) for rows in batch.features])
        text = model.text_embeddings(self._vectors(batch.texts, self.config.words))
        loss = contrastive_loss(motion, text, words[:, None] == words)
        nearest = words[torch.cdist(text, motion).argmin(1)]
        return {"loss": loss, "top1": (nearest == words).float().mean()}

    def _training(self, iteration: int) -> PairBatch:
        """Clips drawn by weight, each with one of its captions; of similar length within a batch."""
        number, place = divmod(iteration, BUCKET)
        rng = np.random.default_rng((self._seed, number, place))
        if self._drawn[0] != number:
            draw = np.random.default_rng((self._seed, number))
            rows = draw.choice(len(self._clips), BUCKET * self._half, p=self._chance)
            rows = rows[np.argsort(self._lengths[rows], kind="stable")].reshape(BUCKET, self._half)
            self._drawn = number, draw.permutation(rows)
        clips = [self._clips[row] for row in self._drawn[1][place]]
        return self._pairs(clips, [int(rng.integers(len(clip.captions))) for clip in clips])

    def _pairs(self, clips: Sequence[Clip], captions: Sequence[int]) -> PairBatch:
        features = [torch.from_numpy(self._dataset.features(clip)[:MAX_FRAMES]) for clip in clips]
        return PairBatch(features, [clip.captions[i].text for clip, i in zip(clips, captions, strict=True)])
