"""Alignment of text and motion in one space (SegMo, sections 3.4 and 3.5), in the variants of its table 3.

All contrast pairs of a text and a motion part in both directions at temperature 0.1, as equation 8 does. What is a
pair, and which others it is told apart from:

- "segment": text segment and motion segment, among those of the same sample (SegMo's own);
- "batch": text segment and motion segment, among those of all samples of the batch;
- "global": sentence and whole motion, among those of all samples of the batch;
- "token": motion token and the text of its segment, among the tokens and texts of the same sample.

Equal texts in a batch count as different ones, as in contrastive training in general.
"""

import torch
from torch import Tensor, nn
from torch.nn import functional

from generator.config import AlignmentKind
from generator.models.segmo.conditioning import segment_numbers

TEMPERATURE = 0.1


class SegmentAlignment(nn.Module):
    """Maps motion segments and texts into one space, of width W."""

    def __init__(self, width: int) -> None:
        super().__init__()
        self.motion = nn.Sequential(nn.Linear(2 * width, width), nn.GELU(), nn.Linear(width, width))
        self.text = nn.Linear(width, width)

    def motion_embeddings(self, hidden: Tensor, lengths: Tensor) -> Tensor:
        """Unit vectors (B, A, W) of the segments of motion tokens (B, T, W): MLP(concat(mean, max)), equation 6.

        Args:
            lengths: (B, A) tokens of each segment, 0 where there is none.
        """
        return self.embed(*aggregate(hidden, lengths))

    def token_embeddings(self, hidden: Tensor) -> Tensor:
        """Unit vectors (B, T, W) of motion tokens, each taken as a segment of its own."""
        return self.embed(hidden, hidden)

    def text_embeddings(self, texts: Tensor) -> Tensor:
        """Unit vectors (..., W) of text tokens (..., W)."""
        return functional.normalize(self.text(texts).float(), dim=-1)

    def embed(self, mean: Tensor, largest: Tensor) -> Tensor:
        """Unit vectors (..., W) of segments from the mean and the maximum (..., W) of their tokens."""
        return functional.normalize(self.motion(torch.cat([mean, largest], dim=-1)).float(), dim=-1)

    def loss(self, kind: AlignmentKind, hidden: Tensor, sentence: Tensor, segments: Tensor, lengths: Tensor) -> Tensor:
        """Alignment loss of motion tokens (B, T, W) with the sentence (B, W) or the segments (B, A, W) of `lengths`."""
        present = lengths > 0
        if kind == "global":
            text = self.text_embeddings(sentence)[None]
            motion = self.motion_embeddings(hidden, lengths.sum(1, keepdim=True)).transpose(0, 1)
            return pair_loss(text, motion)
        text = self.text_embeddings(segments)
        if kind == "token":
            valid = torch.arange(hidden.shape[1], device=hidden.device) < lengths.sum(1, keepdim=True)
            own = segment_numbers(lengths, hidden.shape[1])
            return contrastive_loss(text, self.token_embeddings(hidden), own, text_mask=present, motion_mask=valid)
        motion = self.motion_embeddings(hidden, lengths)
        if kind == "batch":
            return pair_loss(text[present][None], motion[present][None])
        return pair_loss(text, motion, present)


def aggregate(hidden: Tensor, lengths: Tensor) -> tuple[Tensor, Tensor]:
    """Mean and maximum (B, A, W) of the tokens (B, T, W) of segments of (B, A) tokens; zeros where there is none."""
    hidden = hidden.float()
    place = torch.arange(hidden.shape[1], device=hidden.device)
    ends = lengths.cumsum(1)[..., None]
    inside = (place < ends) & (place >= ends - lengths[..., None])
    # Under autocast the product would be of bfloat16, unlike the maximum, and a mean of many tokens wants float32.
    with torch.autocast(hidden.device.type, enabled=False):
        mean = inside.float() @ hidden / lengths[..., None].clamp_min(1)
    number = segment_numbers(lengths, hidden.shape[1])[..., None].expand_as(hidden)
    outside = (place >= lengths.sum(1, keepdim=True))[..., None]
    lowest = torch.full_like(mean, -torch.inf)
    largest = lowest.scatter_reduce(1, number, hidden.masked_fill(outside, -torch.inf), "amax")
    return mean, largest.masked_fill(lengths[..., None] == 0, 0.0)


def pair_loss(text: Tensor, motion: Tensor, mask: Tensor | None = None) -> Tensor:
    """Equation 8 on unit vectors (G, A, W): the j-th text and the j-th motion of a group are a pair.

    Args:
        mask: (G, A) true where there is a pair; padded ones are neither counted nor contrasted with.
    """
    if mask is None:
        mask = torch.ones(text.shape[:2], dtype=torch.bool, device=text.device)
    own = torch.arange(text.shape[1], device=text.device).expand(mask.shape)
    return contrastive_loss(text, motion, own, text_mask=mask, motion_mask=mask)


def contrastive_loss(text: Tensor, motion: Tensor, own: Tensor, *, text_mask: Tensor, motion_mask: Tensor) -> Tensor:
    """Mean over the pairs of a motion part and its text of the two cross-entropies of equation 8.

    Args:
        text: (G, A, W) unit vectors of G groups.
        motion: (G, T, W) unit vectors.
        own: (G, T) number of the text that each motion part belongs to.
        text_mask, motion_mask: (G, A), (G, T) false on padding.
    """
    with torch.autocast(text.device.type, enabled=False):
        similarity = motion.float() @ text.float().transpose(1, 2) / TEMPERATURE
    to_text = similarity.masked_fill(~text_mask[:, None], -1e4).log_softmax(2)
    to_motion = similarity.masked_fill(~motion_mask[..., None], -1e4).log_softmax(1)
    pairs = (to_text + to_motion).gather(2, own[..., None])[..., 0]
    return -0.5 * pairs[motion_mask].mean()
