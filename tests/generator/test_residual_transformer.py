"""The residual transformer: what it may see, and what it learns."""

import pytest
import torch
from torch.nn import functional

from generator.models.segmo.conditioning import Condition, stack_lengths
from generator.models.segmo.config import SegmoSampling, TransformerConfig
from generator.models.segmo.residual_transformer import ResidualTransformer

CONFIG = TransformerConfig(32, 1, 4, 64, dropout=0.0, codes=8, quantizers=3, parts=2)


def condition(*lengths: list[int]) -> Condition:
    table = stack_lengths(lengths)
    return Condition(
        torch.randn(len(table), 384),
        torch.randn(*table.shape, 2, 384),
        torch.zeros(*table.shape, 2, dtype=torch.long),
        table,
    )


def flags(count: int) -> torch.Tensor:
    return torch.ones(count, dtype=torch.bool)


@pytest.mark.parametrize("layer", [1, 2])
def test_only_lower_layers_are_seen(layer: int) -> None:
    torch.manual_seed(0)
    model, given, tokens = ResidualTransformer(CONFIG).eval(), condition([4, 5]), torch.randint(8, (6, 1, 9))
    changed = tokens.clone()
    changed[2 * layer :] = (changed[2 * layer :] + 1) % 8
    before = model(tokens, layer, given, flags(1), flags(1))
    torch.testing.assert_close(before, model(changed, layer, given, flags(1), flags(1)))
    changed[2 * layer - 1] = (changed[2 * layer - 1] + 1) % 8
    assert (before - model(changed, layer, given, flags(1), flags(1))).abs().max() > 1e-4


def test_generation_keeps_the_base_and_adds_all_layers() -> None:
    torch.manual_seed(0)
    model, given = ResidualTransformer(CONFIG).eval(), condition([4, 5], [6])
    base = torch.randint(8, (2, 2, 9))
    tokens = model.generate(base, given, SegmoSampling(layers=3), torch.Generator().manual_seed(0))
    assert tokens.shape == (6, 2, 9)
    assert torch.equal(tokens[:2], base)
    assert int(tokens.max()) < 8


def test_learns_each_layer_from_the_ones_below() -> None:
    """Layer 1 is the base plus one, layer 2 the sum of both, modulo 8; chance is 1 in 8. So for each of two parts."""
    torch.manual_seed(0)
    model = ResidualTransformer(CONFIG)
    optimiser = torch.optim.AdamW(model.parameters(), lr=3e-3)
    given = condition(*[[5, 4]] * 64)

    def batch() -> torch.Tensor:
        base = torch.randint(8, (2, 64, 9))
        return torch.cat([base, (base + 1) % 8, (2 * base + 1) % 8])

    for step in range(200):
        tokens, layer = batch(), 1 + step % 2
        logits = model(tokens, layer, given, flags(64), torch.rand(64) > 0.1)
        loss = functional.cross_entropy(logits.flatten(0, 2), tokens[2 * layer : 2 * layer + 2].flatten())
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
    tokens = batch()
    found = model.eval().generate(tokens[:2], given, SegmoSampling(layers=3), torch.Generator().manual_seed(0))
    assert float((found == tokens).float().mean()) > 0.9


@pytest.mark.parametrize("scale", [1.0, 2.0, 5.0])
def test_guidance_in_generation_is_the_scale_that_was_asked_for(scale: float) -> None:
    """With one code to draw from, what is drawn is the best of: without + scale (with - without)."""
    torch.manual_seed(0)
    model, given = ResidualTransformer(CONFIG).eval(), condition([4, 5], [6])
    base = torch.randint(8, (2, 2, 9))
    with torch.no_grad():
        with_text = model(base, 1, given, flags(2), flags(2))
        without = model(base, 1, given, ~flags(2), ~flags(2))
    sampling = SegmoSampling(layers=2, residual_guidance=scale, top_k=1)
    found = model.generate(base, given, sampling, torch.Generator().manual_seed(0))
    assert torch.equal(found[2:], (without + scale * (with_text - without)).argmax(-1))
