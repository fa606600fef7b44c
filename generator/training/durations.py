"""Training of the duration model: likelihood of the labelled segments' durations."""

from dataclasses import asdict
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from generator.config import Training
from generator.datasets.dataset import Clip, MotionDataset
from generator.datasets.text_cache import TextTable, text_table
from generator.nn.durations import DurationModel, DurationsConfig
from generator.text.counts import segment_counts
from generator.timing import segment_lengths, uniform_lengths
from generator.training.stages import StageJob


def from_job(job: StageJob) -> "DurationsObjective":
    """The objective of a stage of training."""
    return DurationsObjective(job.dataset, job.model(DurationsConfig), job.training, job.seed)


class DurationsObjective:
    """Gaussian negative log-likelihood of the log of the duration."""

    name = "durations"

    def __init__(self, dataset: MotionDataset, config: DurationsConfig, training: Training, seed: int) -> None:
        clips = dataset.split("train")
        self.config, self.facts = config, {"clips": len(clips), "training": asdict(training)}
        captions = (caption for clip in dataset.clips for caption in clip.captions)
        table = text_table(dataset.path, (text for caption in captions for text in caption.segments))
        fps, self._texts = dataset.layout.fps, torch.from_numpy(table.embeddings)
        self._rows, self._held = _rows(clips, table, fps), _rows(dataset.split("val") or clips, table, fps)
        self._batch, self._seed = training.batch, seed
        self.model: Any = DurationModel(config)
        self.model.white.fit(table.embeddings[np.unique(self._rows[:, 0].astype(int))].astype(np.float32))

    def loss(self, iteration: int) -> dict[str, Tensor]:
        rng = np.random.default_rng((self._seed, iteration))
        return self._losses(self.model, self._rows[rng.integers(len(self._rows), size=self._batch)])

    def validate(self, model: nn.Module) -> dict[str, float]:
        return {name: float(value) for name, value in self._losses(model, self._held).items()}

    def _losses(self, model: nn.Module, rows: np.ndarray) -> dict[str, Tensor]:
        """Likelihood, and the median ratio between the predicted and the true duration, less one."""
        table = torch.from_numpy(rows).to(self.model.white.mean.device)
        text = self._texts[rows[:, 0].astype(int)].float().to(table.device)
        mean, log_std = model(text, table[:, 3:5].long(), table[:, 1].long(), table[:, 2].long())
        error = table[:, 5].float().log() - mean
        loss = (0.5 * (error / log_std.exp()).square() + log_std).mean()
        return {"loss": loss, "relative_error": error.abs().exp().median() - 1}


def _rows(clips: tuple[Clip, ...], table: TextTable, fps: float) -> np.ndarray:
    """(N, 6): row of the text, place, number of segments, repetitions in both clauses, duration in s; one for each
    caption and segment. Segments that nobody labelled share their clip evenly."""
    rows = []
    for clip in clips:
        spans = [(segment.start, segment.end) for segment in clip.segments]
        for caption in clip.captions:
            texts, count = table.rows(caption.segments), len(caption.segments)
            frames = segment_lengths(spans, clip.length, 1) if spans else uniform_lengths(count, clip.length)
            lasting = frames / fps
            counts = segment_counts(caption.segments)
            rows += [(row, i, len(texts), *counts[i], lasting[i]) for i, row in enumerate(texts)]
    return np.array(rows)
