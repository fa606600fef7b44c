"""Layout of segments on tokens: boundaries, places within a segment, dropped texts."""

from dataclasses import replace

import numpy as np
import torch

from generator.models.segmo.conditioning import (
    Condition,
    SegmentConditioning,
    stack_lengths,
)


def condition(*lengths: list[int], seed: int = 0) -> Condition:
    torch.manual_seed(seed)
    table = stack_lengths(lengths)
    return Condition(
        torch.randn(len(table), 384),
        torch.randn(*table.shape, 2, 384),
        torch.zeros(*table.shape, 2, dtype=torch.long),
        table,
    )


def test_places_within_segments() -> None:
    found = condition([2, 3], [4])
    assert found.tokens == 5
    assert found.token_mask.tolist() == [[True] * 5, [True] * 4 + [False]]
    assert found.segment_mask.tolist() == [[True, True], [True, False]]
    assert found.segment_of.tolist() == [[0, 0, 1, 1, 1], [0, 0, 0, 0, 0]]
    assert found.elapsed[0].tolist() == [0, 1, 0, 1, 2]
    assert found.lasting.tolist() == [[2, 2, 3, 3, 3], [4, 4, 4, 4, 4]]


def test_dropped_text_leaves_the_layout() -> None:
    torch.manual_seed(1)
    module = SegmentConditioning(16, "layout")
    first, second = condition([3, 4], seed=1), condition([3, 4], seed=2)
    no, yes = torch.zeros(1, dtype=torch.bool), torch.ones(1, dtype=torch.bool)
    torch.testing.assert_close(module(first, yes, no).prefix, module(second, yes, no).prefix)
    torch.testing.assert_close(module(first, yes, no).local, module(second, yes, no).local)
    assert (module(first, yes, yes).local - module(second, yes, yes).local).abs().max() > 1e-3
    other_layout = condition([4, 3], seed=1)
    assert (module(first, yes, no).local - module(other_layout, yes, no).local).abs().max() > 1e-3
    without_sentence = module(first, no, yes).prefix
    assert without_sentence[:, 0].abs().max() == 0
    assert without_sentence[:, 1:].abs().max() > 0


def test_token_reads_its_own_segment() -> None:
    """Changing the second segment's text changes the local condition of its tokens alone."""
    torch.manual_seed(2)
    module, yes = SegmentConditioning(16, "layout"), torch.ones(1, dtype=torch.bool)
    first = condition([3, 4])
    segments = first.segments.clone()
    segments[:, 1] += 1
    second = replace(first, segments=segments)
    changed = (module(first, yes, yes).local - module(second, yes, yes).local).abs().sum(-1)[0]
    assert changed[:3].max() == 0
    assert changed[3:].min() > 0


def test_token_is_told_where_in_the_repetitions_it_is() -> None:
    """Only the tokens of the segment whose text names a number, and only while they may read the text."""
    torch.manual_seed(2)
    module, yes, no = (
        SegmentConditioning(16, "layout"),
        torch.ones(1, dtype=torch.bool),
        torch.zeros(1, dtype=torch.bool),
    )
    torch.nn.init.normal_(module.repetition.weight)
    silent = condition([8, 4])
    twice = replace(silent, counts=torch.tensor([[[2, 0], [0, 0]]]))
    added = (module(twice, yes, yes).local - module(silent, yes, yes).local)[0]
    assert added[8:].abs().max() == 0
    assert added[:8].abs().sum(-1).min() > 0
    assert (added[0] - added[2]).abs().max() > 1e-3
    thrice = replace(silent, counts=torch.tensor([[[3, 0], [0, 0]]]))
    assert (module(thrice, yes, yes).local - module(twice, yes, yes).local)[0, :8].abs().max() > 1e-3
    assert torch.equal(module(twice, yes, no).local, module(silent, yes, no).local)


def test_sentence_conditioning_knows_no_segments() -> None:
    torch.manual_seed(3)
    module, yes = SegmentConditioning(16, "sentence"), torch.ones(1, dtype=torch.bool)
    first = condition([3, 4])
    given = module(first, yes, yes)
    assert given.prefix.shape == (1, 1, 16)
    assert given.prefix_mask.tolist() == [[True]]
    other = module(replace(first, segments=first.segments + 1, lengths=stack_lengths([[2, 2, 3]])), yes, yes)
    assert torch.equal(given.prefix, other.prefix)
    assert torch.equal(given.local, other.local)


def test_segment_conditioning_knows_no_layout() -> None:
    torch.manual_seed(4)
    module, yes = SegmentConditioning(16, "segments"), torch.ones(1, dtype=torch.bool)
    first = condition([3, 4])
    given, moved = (module(replace(first, lengths=stack_lengths([lengths])), yes, yes) for lengths in ([3, 4], [5, 2]))
    assert torch.equal(given.prefix, moved.prefix)
    assert torch.equal(given.local, moved.local)
    swapped = module(replace(first, segments=first.segments.flip(1)), yes, yes)
    assert (given.prefix - swapped.prefix).abs().max() > 1e-3


def test_whitening_makes_small_directions_as_large_as_the_rest() -> None:
    rng = np.random.default_rng(0)
    texts = rng.normal(size=(4000, 384)) * np.linspace(1, 0.3, 384)
    module = SegmentConditioning(8, "layout")
    module.fit(texts.astype(np.float32), texts.astype(np.float32))
    white = module.white_segment(torch.from_numpy(texts).float()).numpy()
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(white.T)))
    assert spread.min() > 0.75
    assert spread.max() < 1.05
