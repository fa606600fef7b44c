"""How near paired text and motion segments lie in a model's aligned space, and how well one finds the other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.objectives.batches import TokenBatch


@dataclass(frozen=True)
class Consistency:
    """Intra-segment consistency (SegMo, section 4.3): mean cosine of paired segments and its coefficient of variation.

    The latter is the standard deviation over the mean.
    """

    mean: float
    variation: float


def consistency(text: Tensor, motion: Tensor) -> Consistency:
    """ISC of unit vectors (N, W) of paired text and motion segments."""
    cosine = (text * motion).sum(-1)
    return Consistency(float(cosine.mean()), float(cosine.std(correction=0) / cosine.mean()))


@torch.inference_mode()
def paired_segments(model: MaskTransformer, batches: Sequence[TokenBatch]) -> tuple[Tensor, Tensor]:
    """Unit vectors (N, W) of all text segments and of their motion segments.

    No token is masked. The motion is read together with its texts where the model was trained with texts.
    """
    texts, motions = [], []
    for batch in batches:
        keep = torch.full((len(batch.motion_segments),), model.config.condition_dropout < 1)
        output = model(batch.tokens[: model.config.parts], batch.condition, keep, keep)
        present = batch.motion_segments > 0
        texts.append(model.alignment.text_embeddings(output.segments)[present])
        motions.append(model.alignment.motion_embeddings(output.hidden, batch.motion_segments)[present])
    return torch.cat(texts), torch.cat(motions)


def recall(queries: Tensor, targets: Tensor, group: np.ndarray, *, rank: int, pool: int, seed: int) -> float:
    """Share of queries (N, W) whose own target (N, W) is among the `rank` nearest of a pool of targets.

    Args:
        group: (N,) what counts as the same target, such as the number of a text; a pool holds no group twice.
        pool: targets in a pool, the own one among them.
    """
    rng = np.random.default_rng(seed)
    hits = []
    for i in range(len(queries)):
        others = rng.permutation(len(targets))
        others = others[group[others] != group[i]]
        _, first = np.unique(group[others], return_index=True)
        chosen = others[np.sort(first)[: pool - 1]]
        similarity = targets[chosen] @ queries[i]
        hits.append(int((similarity >= targets[i] @ queries[i]).sum()) < rank)
    return float(np.mean(hits))
