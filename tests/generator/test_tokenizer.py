"""The motion tokenizer: shapes at every length, standardisation, losses that see what they should."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from generator.config import FEATURES, checked
from generator.models.segmo.config import TokenizerConfig
from generator.models.segmo.parts import part_channels, part_count
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.nn.quantizer import ResidualQuantizer
from generator.registry import find_preset
from generator.training.reconstruction import (
    BONE_WEIGHT,
    ROOT,
    YAW,
    channel_weights,
    foot_steps,
    reconstruction_losses,
)
from ros_free_stack.formats.features import CHANNELS, HUMANML3D, decode

SMALL = TokenizerConfig(
    "patch", 16, 8, 3, 2, codes=32, code_width=8, quantizers=3, quantizer_dropout=0.8, parts="limbs"
)
STRIDED = replace(SMALL, stem="strided", depth=2, dilation_growth=3, parts="whole")


@pytest.mark.parametrize("config", [SMALL, STRIDED], ids=["patch", "strided"])
@pytest.mark.parametrize("frames", [40, 43, 64, 196])
def test_every_length_makes_whole_tokens(config: TokenizerConfig, frames: int) -> None:
    tokenizer = MotionTokenizer(config).eval()
    tokens = tokenizer.encode(torch.randn(2, frames, FEATURES))
    rows = part_count(config.parts) * config.quantizers
    assert tokens.shape == (rows, 2, frames // 4)
    assert tokenizer.decode(tokens).shape == (2, frames // 4 * 4, FEATURES)
    assert tokenizer.decode(tokens[: part_count(config.parts)]).shape == (2, frames // 4 * 4, FEATURES)


@pytest.mark.parametrize("size", ["small", "published"])
@pytest.mark.parametrize("name", ["segmo-layout", "segmo-published", "momask"])
def test_presets_have_the_shapes_of_their_sizes(name: str, size: str) -> None:
    _, preset = find_preset(name, size)
    config = checked(TokenizerConfig, preset.stage("tokenizer")["model"], "tokenizer.model")
    with torch.device("meta"):
        tokenizer = MotionTokenizer(config)
    shapes = [
        tuple(quantizer.codebooks.shape)
        for quantizer in tokenizer.quantizers
        if isinstance(quantizer, ResidualQuantizer)
    ]
    assert shapes == [(config.quantizers, config.codes, config.code_width)] * part_count(config.parts)


def test_features_are_standardised_inside() -> None:
    mean, std = torch.linspace(-3, 3, FEATURES), torch.linspace(0.5, 2, FEATURES)
    tokenizer = MotionTokenizer(SMALL, mean, std).eval()
    features = mean + std * torch.randn(4, 64, FEATURES)
    standardised = tokenizer.standardise(features)
    assert abs(float(standardised.mean())) < 0.02
    assert abs(float(standardised.std()) - 1) < 0.02
    through = tokenizer(standardised).features * std + mean
    torch.testing.assert_close(through, tokenizer.decode(tokenizer.encode(features)), atol=1e-4, rtol=1e-4)


def test_a_few_steps_learn_a_motion() -> None:
    torch.manual_seed(0)
    tokenizer = MotionTokenizer(replace(SMALL, quantizer_dropout=0.0)).train()
    target = torch.sin(torch.linspace(0, 12, 64)[:, None] + torch.linspace(0, 6, FEATURES)).repeat(4, 1, 1)
    optimiser = torch.optim.AdamW(tokenizer.parameters(), lr=3e-3)
    history = []
    for _ in range(40):
        found = tokenizer(target)
        loss = torch.nn.functional.smooth_l1_loss(found.features, target) + 0.02 * found.commitment
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        history.append(loss.item())
    assert history[-1] < 0.35 * history[0]


def test_all_parts_leave_out_the_same_layers() -> None:
    """Generation reads the lowest layers of all parts: a decoder that never saw that would blur them."""
    torch.manual_seed(0)
    tokenizer = MotionTokenizer(replace(SMALL, quantizer_dropout=0.8)).train()
    used: list[int] = []
    for quantizer in tokenizer.quantizers:
        quantizer.register_forward_hook(lambda module, inputs, found: used.append(len(found.tokens)))
    standardised = torch.randn(4, 64, FEATURES)
    batches = []
    for _ in range(40):
        used.clear()
        tokenizer(standardised)
        batches.append(tuple(used))
    assert batches[0] == (3,) * 5, "the first batch starts the codes of all layers"
    assert {(1,) * 5, (2,) * 5, (3,) * 5} == set(batches)


def test_every_feature_belongs_to_one_part() -> None:
    for kind in ("whole", "limbs"):
        parts = part_channels(kind)
        assert sorted(channel for part in parts for channel in part) == list(range(FEATURES))
    legs, trunk, head, left, right = part_channels("limbs")
    assert {CHANNELS[i].split("_")[0] for i in left} == {"left"}
    assert [CHANNELS[i].replace("left", "right", 1) for i in left] == [CHANNELS[i] for i in right]
    assert CHANNELS.index("root_height") in legs
    assert CHANNELS.index("head_position_up") in head
    assert CHANNELS.index("spine1_position_up") in trunk


def test_a_part_keeps_its_codes_whatever_the_others_do() -> None:
    tokenizer = MotionTokenizer(SMALL).eval()
    for books in tokenizer.quantizers.buffers():
        if books.ndim == 3:
            torch.nn.init.normal_(books)
    features = torch.randn(1, 40, FEATURES)
    other = features.clone()
    other[..., part_channels("limbs")[3]] += 1.0
    same = (tokenizer.encode(features) == tokenizer.encode(other)).flatten(1).all(1).view(-1, 5).all(0)
    assert same.tolist() == [True, True, True, False, True]


def test_root_channels_weigh_most() -> None:
    weights = channel_weights()
    assert weights.shape == (len(CHANNELS),)
    assert float(weights.mean()) == pytest.approx(1.0, abs=1e-5)
    root = [i for i, name in enumerate(CHANNELS) if name.startswith("root_")]
    others = [i for i in range(len(CHANNELS)) if i not in root]
    assert float(weights[root].min()) > float(weights[others].max())


def test_steady_root_errors_add_up_in_the_drift() -> None:
    """The same error costs more when it always has the same sign."""
    target, mean, std = torch.zeros(1, 64, FEATURES), torch.zeros(FEATURES), torch.ones(FEATURES)
    steady, alternating = target.clone(), target.clone()
    steady[..., YAW] = 0.1
    alternating[:, ::2, YAW], alternating[:, 1::2, YAW] = 0.1, -0.1
    steady_loss = reconstruction_losses(steady, target, mean, std)
    alternating_loss = reconstruction_losses(alternating, target, mean, std)
    assert float(steady_loss["features"]) == pytest.approx(float(alternating_loss["features"]))
    assert float(steady_loss["drift"]) > 10 * float(alternating_loss["drift"])


def test_foot_steps_are_those_of_the_decoded_motion() -> None:
    rng = np.random.default_rng(3)
    features = rng.normal(scale=0.2, size=(30, FEATURES))
    steps = np.diff(decode(features)[:, list(HUMANML3D.feet)], axis=0)
    found = foot_steps(torch.from_numpy(features)[None])[0]
    np.testing.assert_allclose(found.norm(dim=-1), np.linalg.norm(steps, axis=-1), atol=1e-12)


def test_a_slipping_planted_foot_costs_more_than_a_swinging_one() -> None:
    mean, std = torch.zeros(FEATURES), torch.ones(FEATURES)
    swinging = torch.zeros(1, 8, FEATURES)
    planted = swinging.clone()
    planted[..., -4:] = 1.0
    slip = torch.zeros(FEATURES)
    slip[1] = 0.01  # the root drifts sideways under a pose that does not change
    losses = [reconstruction_losses(target + slip, target, mean, std)["feet"] for target in (swinging, planted)]
    assert float(losses[0]) == pytest.approx(0.01, rel=1e-3)
    assert float(losses[1]) > 3 * float(losses[0])


def test_a_nod_costs_more_in_bones_than_in_joints() -> None:
    """The head's 2 cm drown among 21 joints, but are all that its bone does."""
    neck, head = 4 + 3 * 11, 4 + 3 * 14
    mean, std = torch.linspace(0, 20, FEATURES), torch.ones(FEATURES)
    mean[head : head + 3] = mean[neck : neck + 3] + torch.tensor([0.0, 0.1, 0.0])
    target = torch.zeros(1, 8, FEATURES)
    target[:, ::2, head], target[:, 1::2, head] = 0.02, -0.02
    still = torch.zeros(1, 8, FEATURES)
    losses = reconstruction_losses(still, target, mean, std)
    assert float(losses["loss"]) > BONE_WEIGHT * float(losses["bones"])
    assert float(losses["joints"]) == pytest.approx(0.02 / 21, abs=2e-4)
    assert float(losses["bones"]) == pytest.approx(1 / 18, rel=0.2)


def test_joint_loss_is_in_metres() -> None:
    target, mean, std = torch.zeros(1, 8, FEATURES), torch.zeros(FEATURES), torch.full((FEATURES,), 0.5)
    found = target.clone()
    found[..., 4:67:3] = 0.06  # 3 cm along one axis of every joint
    assert float(reconstruction_losses(found, target, mean, std)["joints"]) == pytest.approx(0.03, rel=1e-3)
    assert CHANNELS[ROOT] == ("root_yaw_velocity", "root_left_velocity", "root_forward_velocity")
    assert CHANNELS[4].endswith("_position_left")
    assert CHANNELS[67].endswith("_rotation_0")
    assert CHANNELS[193].endswith("_velocity_left")
