"""Segment aggregation (equation 6) and alignment loss (equation 8) against their definitions."""

import numpy as np
import torch
from torch.nn import functional

from generator.models.alignment import TEMPERATURE, SegmentAlignment, aggregate, alignment_loss
from generator.models.conditioning import Condition, stack_lengths


def condition(*lengths: list[int]) -> Condition:
    table = stack_lengths(lengths)
    return Condition(torch.zeros(len(table), 384), torch.zeros(*table.shape, 384), table)


def test_aggregate_is_mean_and_maximum_of_each_segment() -> None:
    hidden = torch.randn(2, 6, 5, generator=torch.Generator().manual_seed(0))
    mean, largest = aggregate(hidden, condition([2, 1, 3], [4]))
    torch.testing.assert_close(mean[0, 2], hidden[0, 3:6].mean(0))
    torch.testing.assert_close(largest[0, 0], hidden[0, :2].amax(0))
    torch.testing.assert_close(mean[1, 0], hidden[1, :4].mean(0))
    torch.testing.assert_close(largest[1, 0], hidden[1, :4].amax(0))
    assert mean[1, 1:].abs().max() == 0
    assert largest[1, 1:].abs().max() == 0


def test_loss_is_equation_8() -> None:
    rng = np.random.default_rng(0)
    text, motion = (functional.normalize(torch.from_numpy(rng.normal(size=(2, 3, 4))), dim=-1) for _ in range(2))
    mask = torch.tensor([[True, True, True], [True, True, False]])
    terms = []
    for sample, count in enumerate((3, 2)):
        similarity = np.exp((text[sample, :count] @ motion[sample, :count].T).numpy() / TEMPERATURE)
        for j in range(count):
            to_motion = -np.log(similarity[j, j] / similarity[j].sum())
            to_text = -np.log(similarity[j, j] / similarity[:, j].sum())
            terms.append(0.5 * (to_motion + to_text))
    assert np.isclose(float(alignment_loss(text, motion, mask)), np.mean(terms))


def test_padded_segments_do_not_matter() -> None:
    text, motion = (functional.normalize(torch.randn(4, 3, 8), dim=-1) for _ in range(2))
    mask = torch.tensor([[True, True, False]] * 4)
    other_text, other_motion = text.clone(), motion.clone()
    other_text[:, 2], other_motion[:, 2] = motion[:, 0], text[:, 1]
    assert torch.equal(alignment_loss(text, motion, mask), alignment_loss(other_text, other_motion, mask))


def test_training_aligns_pairs() -> None:
    torch.manual_seed(0)
    module, layout = SegmentAlignment(16), condition(*[[3, 2, 4]] * 16)
    segments = torch.randn(16, 3, 16)
    hidden = segments.gather(1, layout.segment_of[..., None].expand(-1, -1, 16)) + 0.1 * torch.randn(16, 9, 16)
    optimiser = torch.optim.AdamW(module.parameters(), lr=3e-3)

    def loss() -> torch.Tensor:
        motion = module.motion_embeddings(hidden, layout)
        return alignment_loss(module.text_embeddings(segments), motion, layout.segment_mask)

    before = loss().item()
    for _ in range(60):
        optimiser.zero_grad()
        value = loss()
        value.backward()
        optimiser.step()
    assert loss().item() < 0.3 * before
