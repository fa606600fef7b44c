"""Segment aggregation (equation 6) and the contrasts of table 3 against their definitions."""

import numpy as np
import pytest
import torch
from torch.nn import functional

from generator.config import AlignmentKind
from generator.models.segmo.alignment import TEMPERATURE, SegmentAlignment, aggregate, contrastive_loss, pair_loss
from generator.models.segmo.conditioning import segment_numbers, stack_lengths


def unit(*shape: int, seed: int) -> torch.Tensor:
    return functional.normalize(torch.from_numpy(np.random.default_rng(seed).normal(size=shape)).float(), dim=-1)


def terms(text: torch.Tensor, motion: torch.Tensor, own: list[int]) -> list[float]:
    """The two terms of equation 8 for each motion part and its own text, averaged, computed one by one."""
    exponential = np.exp((text @ motion.T).numpy().astype(np.float64) / TEMPERATURE)
    return [
        -0.5 * (np.log(exponential[j, i] / exponential[j].sum()) + np.log(exponential[j, i] / exponential[:, i].sum()))
        for i, j in enumerate(own)
    ]


def test_aggregate_is_mean_and_maximum_of_each_segment() -> None:
    hidden = torch.randn(2, 6, 5, generator=torch.Generator().manual_seed(0))
    mean, largest = aggregate(hidden, stack_lengths([[2, 1, 3], [4]]))
    torch.testing.assert_close(mean[0, 2], hidden[0, 3:6].mean(0))
    torch.testing.assert_close(largest[0, 0], hidden[0, :2].amax(0))
    torch.testing.assert_close(mean[1, 0], hidden[1, :4].mean(0))
    torch.testing.assert_close(largest[1, 0], hidden[1, :4].amax(0))
    assert mean[1, 1:].abs().max() == 0
    assert largest[1, 1:].abs().max() == 0


def test_loss_is_equation_8() -> None:
    text, motion = unit(2, 3, 4, seed=0), unit(2, 3, 4, seed=1)
    mask = torch.tensor([[True, True, True], [True, True, False]])
    expected = [
        term
        for sample, count in enumerate((3, 2))
        for term in terms(text[sample, :count], motion[sample, :count], list(range(count)))
    ]
    assert float(pair_loss(text, motion, mask)) == pytest.approx(np.mean(expected), rel=1e-5)


def test_tokens_are_paired_with_the_text_of_their_segment() -> None:
    text, motion, lengths = unit(2, 2, 4, seed=2), unit(2, 5, 4, seed=3), stack_lengths([[3, 2], [4]])
    own = segment_numbers(lengths, 5)
    valid = torch.arange(5) < lengths.sum(1, keepdim=True)
    found = contrastive_loss(text, motion, own, text_mask=lengths > 0, motion_mask=valid)
    expected = terms(text[0], motion[0], [0, 0, 0, 1, 1]) + terms(text[1, :1], motion[1, :4], [0] * 4)
    assert float(found) == pytest.approx(np.mean(expected), rel=1e-5)


def test_padded_segments_do_not_matter() -> None:
    text, motion = unit(4, 3, 8, seed=4), unit(4, 3, 8, seed=5)
    mask = torch.tensor([[True, True, False]] * 4)
    other_text, other_motion = text.clone(), motion.clone()
    other_text[:, 2], other_motion[:, 2] = motion[:, 0], text[:, 1]
    assert torch.equal(pair_loss(text, motion, mask), pair_loss(other_text, other_motion, mask))


@pytest.mark.parametrize("kind", ["segment", "batch", "global", "token"])
def test_variants_contrast_what_they_say(kind: AlignmentKind) -> None:
    """Each variant's loss from its definition on the module's own embeddings."""
    torch.manual_seed(0)
    module, lengths = SegmentAlignment(8), stack_lengths([[2, 1, 3], [4, 1]])
    hidden, sentence, segments = torch.randn(2, 6, 8), torch.randn(2, 8), torch.randn(2, 3, 8)
    found = float(module.loss(kind, hidden, sentence, segments, lengths).detach())
    with torch.no_grad():
        text, motion = module.text_embeddings(segments), module.motion_embeddings(hidden, lengths)
        if kind == "segment":
            expected = terms(text[0], motion[0], [0, 1, 2]) + terms(text[1, :2], motion[1, :2], [0, 1])
        elif kind == "batch":
            texts, motions = torch.cat([text[0], text[1, :2]]), torch.cat([motion[0], motion[1, :2]])
            expected = terms(texts, motions, list(range(5)))
        elif kind == "global":
            whole = module.motion_embeddings(hidden, torch.tensor([[6], [5]]))[:, 0]
            expected = terms(module.text_embeddings(sentence), whole, [0, 1])
        else:
            alone = torch.stack([module.motion_embeddings(hidden[:, i : i + 1], torch.ones(2, 1).long())[:, 0]
                                 for i in range(6)], dim=1)  # fmt: skip
            expected = terms(text[0], alone[0], [0, 0, 1, 2, 2, 2]) + terms(text[1, :2], alone[1, :5], [0] * 4 + [1])
    assert found == pytest.approx(np.mean(expected), rel=1e-4)


def test_training_aligns_pairs() -> None:
    torch.manual_seed(0)
    module, lengths = SegmentAlignment(16), stack_lengths([[3, 2, 4]] * 16)
    segments = torch.randn(16, 3, 16)
    hidden = segments.gather(1, segment_numbers(lengths, 9)[..., None].expand(-1, -1, 16))
    hidden = hidden + 0.1 * torch.randn(16, 9, 16)
    optimiser = torch.optim.AdamW(module.parameters(), lr=3e-3)

    def loss() -> torch.Tensor:
        return module.loss("segment", hidden, segments[:, 0], segments, lengths)

    before = loss().item()
    for _ in range(60):
        optimiser.zero_grad()
        value = loss()
        value.backward()
        optimiser.step()
    assert loss().item() < 0.3 * before
