"""Drafts: what is wrong is drawn again and nothing else, the best draft stays, what is given is kept."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from generator.config import PRESETS, Sampling
from generator.models.segmo.conditioning import Condition, stack_lengths
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.resampling import SEAM_TOKENS, Drafting

PARTS, CODES, LENGTHS = 2, 24, (6, 7, 5)
CONFIG = replace(PRESETS["small"].mask, width=32, layers=1, feed_forward=64, codes=CODES, parts=PARTS)
SAMPLING = Sampling(steps=2, drafts=4, rounds=3, temperature=3.0, top_k=0.0)


@pytest.fixture(scope="module")
def mask() -> MaskTransformer:
    torch.manual_seed(0)
    return MaskTransformer(CONFIG).eval()


def condition(*lengths: Sequence[int]) -> Condition:
    table = stack_lengths(lengths)
    torch.manual_seed(1)
    texts = torch.randn(len(table), 384), torch.randn(*table.shape, 2, 384)
    return Condition(*texts, torch.zeros(*table.shape, 2, dtype=torch.long), table)


def unknown(rows: int, tokens: int) -> torch.Tensor:
    return torch.full((PARTS, rows, tokens), -1)


def noise() -> torch.Generator:
    return torch.Generator().manual_seed(0)


class EvenCodes:
    """Wants even codes, and counts the odd ones of each segment; keeps what it was shown."""

    def __init__(self) -> None:
        self.seen: list[torch.Tensor] = []
        self.found: list[NDArray[np.int64]] = []

    def __call__(self, tokens: torch.Tensor, lengths: Sequence[int]) -> NDArray[np.int64]:
        odd = (tokens % 2).sum(0).split(list(lengths))
        self.seen.append(tokens.clone())
        self.found.append(np.array([int(part.sum()) for part in odd]))
        return self.found[-1]


def test_the_draft_with_the_fewest_mistakes_stays(mask: MaskTransformer) -> None:
    judge = EvenCodes()
    drafting = Drafting(mask, replace(SAMPLING, rounds=1), judge)
    tokens = drafting.draw(condition(LENGTHS), unknown(1, sum(LENGTHS)), noise())[:, 0]
    totals = [found.sum() for found in judge.found]
    assert len(totals) == 1 + SAMPLING.drafts and len(set(totals)) > 1
    assert torch.equal(tokens, judge.seen[int(np.argmin(totals))])


def test_more_rounds_find_what_a_single_one_does_not(mask: MaskTransformer) -> None:
    """Every segment is to begin with an even code in both parts: one draft in 1024 does."""
    lengths = (4, 4, 4, 4, 4)

    def judge(tokens: torch.Tensor, lengths: Sequence[int]) -> NDArray[np.int64]:
        return np.array([int((part[:, 0] % 2).sum()) for part in tokens.split(list(lengths), dim=1)])

    def wrong(rounds: int) -> int:
        drafting = Drafting(mask, replace(SAMPLING, rounds=rounds), judge)
        return int(judge(drafting.draw(condition(lengths), unknown(1, sum(lengths)), noise())[:, 0], lengths).sum())

    found = [wrong(rounds) for rounds in (1, 2, 3, 12)]
    assert found == sorted(found, reverse=True)
    assert found[0] > 0 and found[-1] == 0


def test_only_what_is_wrong_is_drawn_again(mask: MaskTransformer) -> None:
    """The middle segment never pleases: it alone changes, with a token of either neighbour."""
    seen: list[torch.Tensor] = []

    def judge(tokens: torch.Tensor, lengths: Sequence[int]) -> NDArray[np.int64]:
        seen.append(tokens.clone())
        return np.array([0, 1, 0])

    drafting = Drafting(mask, SAMPLING, judge)
    tokens = drafting.draw(condition(LENGTHS), unknown(1, sum(LENGTHS)), noise())[:, 0]
    assert torch.equal(tokens, seen[0]), "no later draft was better"
    first, stop = LENGTHS[0] - SEAM_TOKENS, LENGTHS[0] + LENGTHS[1] + SEAM_TOKENS
    later = torch.stack(seen[1:])
    assert len(later) == SAMPLING.rounds * SAMPLING.drafts
    assert (later[..., :first] == seen[0][:, :first]).all() and (later[..., stop:] == seen[0][:, stop:]).all()
    assert (later[..., first:stop] != seen[0][:, first:stop]).any(0).all()


def test_a_first_draft_without_mistakes_stays(mask: MaskTransformer) -> None:
    calls: list[int] = []

    def judge(tokens: torch.Tensor, lengths: Sequence[int]) -> NDArray[np.int64]:
        calls.append(len(lengths))
        return np.zeros(len(lengths), dtype=np.int64)

    given, tokens = condition(LENGTHS), unknown(1, sum(LENGTHS))
    found = Drafting(mask, SAMPLING, judge).draw(given, tokens, noise())
    assert calls == [3]
    assert torch.equal(found, mask.generate(given, SAMPLING, noise(), tokens))


def test_given_tokens_stay(mask: MaskTransformer) -> None:
    known = unknown(1, sum(LENGTHS))
    known[:, :, 4:9] = 3
    drafting = Drafting(mask, SAMPLING, lambda tokens, lengths: np.ones(len(lengths), dtype=np.int64))
    assert (drafting.draw(condition(LENGTHS), known, noise())[:, :, 4:9] == 3).all()


def test_motions_of_different_lengths(mask: MaskTransformer) -> None:
    shorter = (4, 5, 6)
    judge = EvenCodes()
    tokens = Drafting(mask, SAMPLING, judge).draw(condition(shorter, LENGTHS), unknown(2, sum(LENGTHS)), noise())
    assert {draft.shape[1] for draft in judge.seen} == {sum(shorter), sum(LENGTHS)}
    assert (tokens[:, 0, sum(shorter) :] == 0).all()
    assert tokens.min() >= 0 and tokens.max() < CODES


def test_same_noise_same_tokens(mask: MaskTransformer) -> None:
    one, two = (
        Drafting(mask, SAMPLING, EvenCodes()).draw(condition(LENGTHS), unknown(1, sum(LENGTHS)), noise())
        for _ in range(2)
    )
    assert torch.equal(one, two)
