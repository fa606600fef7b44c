"""Segment-level alignment of text and motion (SegMo, sections 3.4 and 3.5)."""

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.models.conditioning import Condition

TEMPERATURE = 0.1


class SegmentAlignment(nn.Module):
    """Maps motion segments and text segments into one space, of width W."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.motion = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, width))
        self.text = nn.Linear(width, width)

    def motion_embeddings(self, hidden: Tensor, condition: Condition) -> Tensor:
        """Unit vectors (B, A, W) of the segments of motion tokens (B, T, W): MLP(concat(mean, max)), equation 6."""
        mean, largest = aggregate(hidden.float(), condition)
        return functional.normalize(self.motion(torch.cat([mean, largest], dim=-1)).float(), dim=-1)

    def text_embeddings(self, segments: Tensor) -> Tensor:
        """Unit vectors (B, A, W) of segment tokens (B, A, W)."""
        return functional.normalize(self.text(segments).float(), dim=-1)


def aggregate(hidden: Tensor, condition: Condition) -> tuple[Tensor, Tensor]:
    """Mean and maximum (B, A, W) of the tokens (B, T, W) of each segment; zeros where there is no segment."""
    batch, _, width = hidden.shape
    number = condition.segment_of[..., None].expand(-1, -1, width)
    mask = condition.token_mask[..., None]
    empty = hidden.new_zeros(batch, condition.lengths.shape[1], width)
    total = empty.scatter_add(1, number, hidden * mask)
    largest = torch.full_like(empty, -torch.inf).scatter_reduce(
        1, number, hidden.masked_fill(~mask, -torch.inf), "amax"
    )
    count = condition.lengths[..., None]
    return total / count.clamp_min(1), largest.masked_fill(count == 0, 0.0)


def alignment_loss(text: Tensor, motion: Tensor, mask: Tensor) -> Tensor:
    """Contrast of each segment with the others of its own sample, in both directions (equation 8).

    Args:
        text, motion: (B, A, W) unit vectors.
        mask: (B, A) true where there is a segment; padded ones are neither counted nor contrasted with.
    """
    similarity = text @ motion.transpose(1, 2) / TEMPERATURE
    absent = ~mask[:, None]
    from_text = similarity.masked_fill(absent, -1e4)[mask]
    from_motion = similarity.transpose(1, 2).masked_fill(absent, -1e4)[mask]
    pair = torch.arange(mask.shape[1], device=mask.device).expand(mask.shape)[mask]
    return 0.5 * (functional.cross_entropy(from_text, pair) + functional.cross_entropy(from_motion, pair))
