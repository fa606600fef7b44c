"""The residual quantizer: exactness of encode and decode, learning of codebooks, straight-through gradient."""

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.nn.quantizer import DECAY, ResidualQuantizer


def trained(inputs: torch.Tensor, *, quantizers: int = 3, codes: int = 16, steps: int = 60) -> ResidualQuantizer:
    torch.manual_seed(0)
    quantizer = ResidualQuantizer(quantizers=quantizers, codes=codes, width=inputs.shape[-1])
    for _ in range(steps):
        quantizer(inputs)
    return quantizer.eval()


@pytest.fixture(scope="module")
def inputs() -> torch.Tensor:
    return torch.randn(8, 40, 6, generator=torch.Generator().manual_seed(1))


def test_values_are_the_sum_of_the_chosen_codes(inputs: torch.Tensor) -> None:
    quantizer = trained(inputs)
    result = quantizer(inputs)
    assert result.tokens.shape == (3, 8, 40)
    torch.testing.assert_close(quantizer.decode(result.tokens), result.values, atol=1e-5, rtol=0)


def test_each_layer_lowers_the_error(inputs: torch.Tensor) -> None:
    quantizer = trained(inputs)
    tokens = quantizer(inputs).tokens
    errors = [float((quantizer.decode(tokens[:used]) - inputs).square().mean()) for used in (1, 2, 3)]
    assert errors[0] < float(inputs.square().mean())
    assert errors[0] > errors[1] > errors[2]


def test_chosen_code_is_the_nearest(inputs: torch.Tensor) -> None:
    quantizer = trained(inputs)
    flat = inputs.flatten(0, 1)
    assert torch.equal(quantizer.nearest(flat, 0), torch.cdist(flat, quantizer.codebooks[0]).argmin(1))


def test_gradient_passes_straight_through(inputs: torch.Tensor) -> None:
    quantizer = trained(inputs)
    variable = inputs.clone().requires_grad_()
    weight = torch.randn_like(variable)
    (quantizer(variable).values * weight).sum().backward()
    torch.testing.assert_close(variable.grad, weight)


def test_clusters_are_found() -> None:
    """With some codes to spare, every cluster gets its own."""
    centres = 10 * torch.eye(8)
    noise = torch.randn(100, 8, 8, generator=torch.Generator().manual_seed(2))
    quantizer = trained(centres + 0.1 * noise, quantizers=1, codes=32, steps=200)
    assert torch.cdist(centres, quantizer.codebooks[0]).min(1).values.max() < 0.5


def test_moving_average_is_that_of_sums_and_counts(inputs: torch.Tensor) -> None:
    """The update without kept sums equals the published one with them."""
    quantizer = trained(inputs, quantizers=1, steps=3).train()
    usage, book = quantizer.usage[0].clone(), quantizer.codebooks[0].clone()
    flat = inputs.flatten(0, 1)
    chosen = quantizer.nearest(flat, 0)
    count = torch.bincount(chosen, minlength=16).float()
    sums = torch.zeros_like(book).index_add_(0, chosen, flat)
    expected = (DECAY * usage[:, None] * book + (1 - DECAY) * sums) / (DECAY * usage + (1 - DECAY) * count)[:, None]
    quantizer(inputs)
    torch.testing.assert_close(quantizer.codebooks[0], expected)


def test_dead_codes_come_back(inputs: torch.Tensor) -> None:
    quantizer = trained(inputs).train()
    quantizer.codebooks[0, :8] = 1e4
    for _ in range(500):
        quantizer(inputs)
    assert quantizer.codebooks[0].abs().max() < 10


def test_evaluation_changes_nothing(inputs: torch.Tensor) -> None:
    quantizer = trained(inputs)
    before = {name: value.clone() for name, value in quantizer.state_dict().items()}
    quantizer(torch.randn_like(inputs))
    for name, value in quantizer.state_dict().items():
        assert torch.equal(value, before[name])


@settings(max_examples=20, deadline=None)
@given(batch=st.integers(1, 4), frames=st.integers(1, 9), used=st.integers(1, 3))
def test_shapes(batch: int, frames: int, used: int) -> None:
    quantizer = ResidualQuantizer(quantizers=3, codes=5, width=4)
    result = quantizer(torch.randn(batch, frames, 4))
    assert result.values.shape == (batch, frames, 4)
    assert result.tokens.shape == (3, batch, frames)
    assert quantizer.decode(result.tokens[:used]).shape == (batch, frames, 4)


def test_commitment_pulls_the_input_to_its_codes(inputs: torch.Tensor) -> None:
    """By its gradient: of each layer, twice the way from the code to what the layer saw, over all numbers."""
    quantizer = trained(inputs)
    variable = inputs.clone().requires_grad_()
    quantizer(variable).commitment.backward()
    residual, expected = inputs.clone(), torch.zeros_like(inputs)
    for layer in range(3):
        chosen = quantizer.nearest(residual.flatten(0, 1), layer)
        code = quantizer.codebooks[layer][chosen].view_as(inputs)
        residual = residual - code
        expected += 2 * residual / inputs.numel() / 3
    torch.testing.assert_close(variable.grad, expected)
