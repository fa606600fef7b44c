"""The mask transformer: masking shares, independence of padding, decoding that ends, guidance, learning."""

from dataclasses import replace

import pytest
import torch
from torch.nn import functional

from generator.models.segmo.conditioning import Condition, stack_lengths
from generator.models.segmo.config import ConditioningKind, SegmoSampling, TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer, mask_tokens, sample

PARTS = 2
CONFIG = TransformerConfig(32, 2, 4, 64, dropout=0.0, codes=24, quantizers=3, parts=PARTS)


def condition(*lengths: list[int], seed: int = 0) -> Condition:
    torch.manual_seed(seed)
    table = stack_lengths(lengths)
    return Condition(
        torch.randn(len(table), 384),
        torch.randn(*table.shape, 2, 384),
        torch.zeros(*table.shape, 2, dtype=torch.long),
        table,
    )


@pytest.fixture(scope="module")
def model() -> MaskTransformer:
    torch.manual_seed(0)
    return MaskTransformer(CONFIG).eval()


def flags(count: int) -> torch.Tensor:
    return torch.ones(count, dtype=torch.bool)


def test_masking_shares() -> None:
    torch.manual_seed(0)
    tokens, valid = torch.randint(24, (PARTS, 4000, 40)), torch.ones(4000, 40, dtype=torch.bool)
    valid[:, 30:] = False
    masked, chosen = mask_tokens(tokens, valid, 24)
    assert not chosen[..., 30:].any()
    assert chosen.sum((0, 2)).min() >= 1
    assert (chosen[0] != chosen[1]).any()
    assert torch.equal(masked[~chosen], tokens[~chosen])
    assert float(chosen[..., :30].float().mean()) == pytest.approx(0.637, abs=0.02)  # mean of cos is 2 / pi
    assert float((masked[chosen] == 24).float().mean()) == pytest.approx(0.9 * 0.88, abs=0.01)
    kept = float((masked[chosen] == tokens[chosen]).float().mean())
    assert kept == pytest.approx(0.9 * 0.12 + 0.1 / 24, abs=0.01)


def test_padding_does_not_reach_the_tokens(model: MaskTransformer) -> None:
    alone, padded = condition([3, 4]), condition([3, 4], [6, 6])
    padded = replace(alone.repeated(2), lengths=padded.lengths)
    tokens = torch.randint(24, (PARTS, 2, 12))
    single = model(tokens[:, :1, :7], alone, flags(1), flags(1)).logits[:, 0]
    double = model(tokens, padded, flags(2), flags(2)).logits[:, 0, :7]
    torch.testing.assert_close(single, double, atol=1e-5, rtol=1e-5)


def test_generation_fills_every_token(model: MaskTransformer) -> None:
    given = condition([3, 4], [10], [5, 5, 5])
    tokens = model.generate(given, SegmoSampling(), torch.Generator().manual_seed(0))
    assert tokens.shape == (PARTS, 3, 15)
    assert int(tokens.max()) < 24
    assert tokens[:, 0, 7:].abs().max() == 0
    again = model.generate(given, SegmoSampling(), torch.Generator().manual_seed(0))
    other = model.generate(given, SegmoSampling(), torch.Generator().manual_seed(1))
    assert torch.equal(tokens, again)
    assert not torch.equal(tokens, other)


@pytest.mark.parametrize("steps", [1, 2, 7, 30])
def test_any_number_of_steps_ends_without_masks(model: MaskTransformer, steps: int) -> None:
    tokens = model.generate(condition([5, 6]), SegmoSampling(steps=steps), torch.Generator().manual_seed(0))
    assert int(tokens.max()) < 24


@pytest.mark.parametrize("conditioning", ["sentence", "segments"])
def test_every_conditioning_generates(conditioning: ConditioningKind) -> None:
    torch.manual_seed(0)
    model = MaskTransformer(replace(CONFIG, conditioning=conditioning)).eval()
    tokens = model.generate(condition([3, 4], [10]), SegmoSampling(), torch.Generator().manual_seed(0))
    assert tokens.shape == (PARTS, 2, 10)
    assert int(tokens.max()) < 24


def test_guidance_of_one_is_the_conditional_model(model: MaskTransformer) -> None:
    given, tokens = condition([4, 4]), torch.full((PARTS, 1, 8), 24)
    plain = model(tokens, given, flags(1), flags(1)).logits
    without = model(tokens, given, ~flags(1), ~flags(1)).logits
    torch.testing.assert_close(model._guided(given, 1.0)(tokens), plain)
    torch.testing.assert_close(model._guided(given, 3.0)(tokens), without + 3 * (plain - without), atol=1e-4, rtol=1e-4)


def test_sampling_takes_only_the_best_codes() -> None:
    logits = torch.arange(20.0).repeat(1, 500, 1)
    drawn, chance = sample(logits, 100.0, 0.8, torch.Generator().manual_seed(0))
    assert set(drawn.flatten().tolist()) == {16, 17, 18, 19}
    expected = logits.softmax(-1).gather(-1, drawn[..., None])[..., 0]
    torch.testing.assert_close(chance, expected)


def test_learns_which_text_means_which_token() -> None:
    """Each segment's text decides its tokens; after a few steps generation follows the order of the segments."""
    torch.manual_seed(0)
    model = MaskTransformer(replace(CONFIG, sentence_dropout=0.0))
    texts = torch.randn(4, 384)
    optimiser = torch.optim.AdamW(model.parameters(), lr=3e-3)
    for _ in range(60):
        words = torch.randint(4, (32, 2))
        given = replace(condition(*[[4, 3]] * 32), segments=texts[words][:, :, None] * torch.tensor([[1.0], [0.0]]))
        tokens = words.gather(1, given.segment_of)
        tokens = torch.stack([tokens, tokens + 10])
        masked, chosen = mask_tokens(tokens, given.token_mask, 24)
        keep = torch.rand(32) > 0.1
        loss = functional.cross_entropy(model(masked, given, keep, keep).logits[chosen], tokens[chosen])
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    model.eval()
    told = texts[torch.tensor([[2, 1]])][:, :, None] * torch.tensor([[1.0], [0.0]])
    given = replace(condition([3, 4]), segments=told)
    tokens = model.generate(given, SegmoSampling(), torch.Generator().manual_seed(0))
    assert tokens.tolist() == [[[2, 2, 2, 1, 1, 1, 1]], [[12, 12, 12, 11, 11, 11, 11]]]


def test_known_tokens_stay(model: MaskTransformer) -> None:
    given = condition([5, 6], [4, 4])
    known = torch.full((PARTS, 2, 11), -1)
    known[..., :3] = torch.tensor([7, 8, 9])
    known[0, 0, 10], known[1, 1, 7] = 11, 12
    tokens = model.generate(given, SegmoSampling(), torch.Generator().manual_seed(0), known)
    assert torch.equal(tokens[known >= 0], known[known >= 0])
    assert int(tokens.max()) < 24
    free = model.generate(given, SegmoSampling(), torch.Generator().manual_seed(0), torch.full((PARTS, 2, 11), -1))
    assert torch.equal(free, model.generate(given, SegmoSampling(), torch.Generator().manual_seed(0)))


def test_codes_that_are_alike_begin_alike() -> None:
    torch.manual_seed(0)
    codebooks = torch.randn(PARTS, 24, 16)
    codebooks[:, 1] = codebooks[:, 0] + 0.01
    model = MaskTransformer(CONFIG)
    mask_embedding = model.embedding.weight.unflatten(0, (PARTS, -1))[:, 24].clone()
    model.start_from(codebooks)
    for table in (model.embedding.weight.unflatten(0, (PARTS, -1)), model.output.weight.unflatten(0, (PARTS, -1))):
        near, far = (table[:, 1] - table[:, 0]).norm(dim=1), (table[:, 2] - table[:, 0]).norm(dim=1)
        assert (near < 0.1 * far).all()
    assert torch.equal(model.embedding.weight.unflatten(0, (PARTS, -1))[:, 24], mask_embedding)
