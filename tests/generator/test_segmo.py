"""SegMo as a model: lengths, what is known stays, sampling settings."""

from dataclasses import replace

import pytest
import torch

from generator.model import Known, Sampling, TextCondition
from generator.models.segmo.config import SegmoSampling, TokenizerConfig, TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.model import SegMo
from generator.models.segmo.residual_transformer import ResidualTransformer
from generator.models.segmo.tokenizer import MotionTokenizer

QUICK = Sampling(steps=3)


@pytest.fixture(scope="module")
def model() -> SegMo:
    """Tiny models that were never trained."""
    torch.manual_seed(0)
    tokenizer = MotionTokenizer(
        TokenizerConfig("patch", 16, 8, 1, 2, codes=32, code_width=8, quantizers=2, parts="limbs")
    )
    for books in tokenizer.quantizers.buffers():
        if books.ndim == 3:
            books.normal_()
    config = TransformerConfig(32, 1, 4, 64, dropout=0.0, codes=32, quantizers=2, parts=5)
    return SegMo(tokenizer.eval(), MaskTransformer(config).eval(), ResidualTransformer(config).eval(), "tiny")


def text(*frames: tuple[int, ...]) -> TextCondition:
    rows, count = len(frames), len(frames[0])
    torch.manual_seed(1)
    return TextCondition(
        torch.randn(rows, 384),
        torch.zeros(rows, 1, 384),
        torch.ones(rows, 1, dtype=torch.bool),
        torch.randn(rows, count, 384),
        torch.randn(rows, count, 2, 384),
        torch.zeros(rows, count, 2, dtype=torch.long),
        torch.tensor(frames),
    )


def noise() -> torch.Generator:
    return torch.Generator().manual_seed(0)


@pytest.mark.parametrize("layers", [1, 2])
def test_samples_are_as_long_as_their_segments(model: SegMo, layers: int) -> None:
    deep = replace(model, settings=SegmoSampling(layers=layers))
    samples = deep.sample(text((24, 16), (40, 60)), known=None, sampling=QUICK, noise=noise())
    assert [tuple(sample.features.shape) for sample in samples] == [(40, 263), (100, 263)]
    for sample, tokens in zip(samples, (10, 25), strict=True):
        assert sample.latent is not None and sample.latent.shape == (5 * layers, tokens)


def test_tokens_of_own_samples_stay_exactly(model: SegMo) -> None:
    condition = text((40, 40))
    (first,) = model.sample(condition, known=None, sampling=QUICK, noise=noise())
    assert first.latent is not None
    mask = torch.ones(1, 80, dtype=torch.bool)
    mask[:, 20:44] = False
    known = Known(first.features[None], mask, *[first.features[:0]] * 2, latent=first.latent[:, None])
    (again,) = model.sample(condition, known=known, sampling=QUICK, noise=noise().manual_seed(5))
    assert again.latent is not None
    assert torch.equal(again.latent[:, :5], first.latent[:, :5])
    assert torch.equal(again.latent[:, 11:], first.latent[:, 11:])
    assert not torch.equal(again.latent[:, 5:11], first.latent[:, 5:11])


def test_given_features_are_read_together_with_what_lies_beyond_them(model: SegMo) -> None:
    given = torch.randn(60, 263)
    tokens = model.tokenizer.encode(given[None])[:5, 0]
    mask = torch.zeros(1, 60, dtype=torch.bool)
    mask[:, :20] = True
    known = Known(given[None, 40:].repeat(1, 3, 1), mask, given[:40], given[:0])
    (found,) = model.sample(text((20, 40)), known=known, sampling=QUICK, noise=noise())
    assert found.latent is not None
    assert torch.equal(found.latent[:, :5], tokens[:, -5:])


def test_settings_that_are_asked_for_replace_the_own_ones(model: SegMo) -> None:
    own = SegmoSampling(steps=10, mask_guidance=4.0, temperature=1.0)
    assert own.told(Sampling()) == own
    assert own.told(Sampling(steps=3, guidance=1.0)) == replace(own, steps=3, mask_guidance=1.0)


def test_reconstruction_goes_through_the_tokens(model: SegMo) -> None:
    features = torch.randn(42, 263)
    found = model.reconstruct(features)
    assert found.shape == (40, 263)
    assert torch.equal(found, model.tokenizer.decode(model.tokenizer.encode(features[None]))[0])
