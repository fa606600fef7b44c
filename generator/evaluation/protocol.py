"""The published protocol: 20 runs over newly drawn pools, each metric with its mean and 95 % interval."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from generator.evaluation import metrics
from generator.evaluation.embedder import Embedder
from generator.evaluation.metrics import POOL, Floats
from generator.evaluation.pairs import Features
from ros_free_stack.coherence import spatial_coherence, temporal_coherence
from ros_free_stack.formats.features import decode

DIVERSITY_PAIRS: Final = 300
MULTIMODALITY_SAMPLES: Final = 30
MULTIMODALITY_PAIRS: Final = 10


@dataclass(frozen=True)
class Score:
    """Mean of a metric over the runs, and half of its 95 % interval: 1.96 std / sqrt(runs)."""

    mean: float
    interval: float

    @classmethod
    def of(cls, values: Sequence[float]) -> "Score":
        return cls(float(np.mean(values)), float(1.96 * np.std(values) / np.sqrt(len(values))))


@dataclass(frozen=True)
class MotionSet:
    """Motions for the N texts, as the metrics see them.

    Attributes:
        embeddings: (N, E).
        each: metrics of a single motion, (N,) by name.
    """

    embeddings: Floats
    each: dict[str, Floats]

    @classmethod
    def measure(
        cls, features: Sequence[Features], embedder: Embedder, real: Sequence[Features] | None = None
    ) -> "MotionSet":
        """Embed the motions and measure their coherence (ParTY), and their joint error in mm where `real` is given."""
        joints = [decode(rows) for rows in features]
        each = {
            "tc": np.array([temporal_coherence(points) for points in joints]),
            "sc": np.array([spatial_coherence(points) for points in joints]),
        }
        if real is not None:
            pairs = zip(joints, real, strict=True)
            each["mpjpe_mm"] = np.array([1e3 * metrics.mpjpe(points, decode(rows)) for points, rows in pairs])
        return cls(embedder.motions(features), each)


def score(
    texts: Floats,
    real: MotionSet,
    generations: Sequence[MotionSet],
    samples: Floats | None = None,
    *,
    runs: int,
    seed: int,
) -> dict[str, Score]:
    """Scores of one row of the table.

    Args:
        texts: (N, E) embeddings of the texts.
        real: the real motions.
        generations: the motions to score; run i takes the one of number i modulo their number.
        samples: (texts, samples, E) embeddings of several motions a text, for MultiModality.
    """
    rng = np.random.default_rng(seed)
    found: dict[str, list[float]] = {}
    for run in range(runs):
        motion = generations[run % len(generations)]
        rows = rng.permutation(len(texts))[: len(texts) // POOL * POOL]
        for name, value in _run(texts[rows], real.embeddings[rows], motion.embeddings[rows], rng).items():
            found.setdefault(name, []).append(value)
        for name, values in motion.each.items():
            found.setdefault(name, []).append(float(values[rows].mean()))
        if samples is not None:
            pairs = min(MULTIMODALITY_PAIRS, samples.shape[1])
            found.setdefault("multimodality", []).append(metrics.multimodality(samples, pairs, rng))
    return {name: Score.of(values) for name, values in found.items()}


def _run(text: Floats, real: Floats, motion: Floats, rng: np.random.Generator) -> dict[str, float]:
    top = metrics.r_precision(text, motion)
    return {
        "top1": float(top[0]),
        "top2": float(top[1]),
        "top3": float(top[2]),
        "fid": metrics.frechet_distance(real, motion),
        "mm_dist": metrics.matching_distance(text, motion),
        "diversity": metrics.diversity(motion, min(DIVERSITY_PAIRS, len(motion)), rng),
    }
