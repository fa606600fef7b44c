"""ParTY's tokenizer: the equations against plain loops, padding, bodies."""

import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from generator.bodies import channels
from generator.models.party.config import TokenizerConfig
from generator.models.party.temporal import (
    NEAR,
    Adjacency,
    GlobalEnhancement,
    LocalEnhancement,
    normalised_adjacency,
    window_mask,
)
from generator.models.party.tokenizer import PartyTokenizer
from ros_free_stack.errors import InvalidOption, UnknownName
from ros_free_stack.formats.features import CHANNELS

CONFIG = TokenizerConfig(
    bodies=("whole", "arms", "legs"), window=8, part_window=12, width=16, encoder_width=12, depth=2, codes=16,
    part_codes=8, code_width=8, groups=2,
)  # fmt: skip


def tokenizer(config: TokenizerConfig = CONFIG) -> PartyTokenizer:
    torch.manual_seed(0)
    model = PartyTokenizer(config, 0.1 * torch.randn(263), torch.rand(263) + 0.5)
    for name, buffer in model.named_buffers():
        if name.endswith("codebooks"):
            buffer.normal_()
        if name.endswith("started"):
            buffer.fill_(True)
    return model.eval()


def frames(*counts: int) -> Tensor:
    return torch.tensor(counts)


def test_local_enhancement_is_equation_1_and_its_weights_add_up_to_one() -> None:
    torch.manual_seed(1)
    layer, values = LocalEnhancement(6, 4), torch.randn(2, 12, 6)
    mask = torch.arange(12) < frames(12, 6)[:, None]
    weights, found = layer.weights(values, mask), layer(values, mask)
    for row in range(2):
        for window in range(3):
            inside = [4 * window + j for j in range(4) if mask[row, 4 * window + j]]
            scores = [math.exp(layer.score(values[row, place]).item()) for place in inside]
            assert float(weights[row, window].sum()) == pytest.approx(1.0 if inside else 0.0, abs=1e-6)
            expected = sum(
                (score / sum(scores) * values[row, place] for score, place in zip(scores, inside, strict=True)),
                torch.zeros(6),
            )
            assert torch.allclose(found[row, window], expected, atol=1e-5)


@pytest.mark.parametrize("kind", ["full", "banded"])
def test_global_enhancement_is_equation_2(kind: Adjacency) -> None:
    torch.manual_seed(2)
    layer, windows = GlobalEnhancement(5, kind, layers=2), torch.randn(1, 7, 5)
    count = 6
    mask = torch.arange(7)[None] < count
    near = [[abs(i - k) <= NEAR or kind == "full" for k in range(count)] for i in range(count)]
    degree = [sum(row) for row in near]
    expected = list(windows[0, :count])
    for linear in layer.layers:
        heard = [
            sum(
                (linear(expected[k]) / math.sqrt(degree[i] * degree[k]) for k in range(count) if near[i][k]),
                torch.zeros(5),
            )
            for i in range(count)
        ]
        expected = [old + torch.nn.functional.gelu(new) for old, new in zip(expected, heard, strict=True)]
    assert torch.allclose(layer(windows, mask)[0, :count], torch.stack(expected), atol=1e-5)


def test_full_adjacency_alone_would_make_all_windows_one() -> None:
    graph = normalised_adjacency(torch.ones(1, 5, dtype=torch.bool), "full")
    assert torch.allclose(graph, torch.full((1, 5, 5), 0.2)), "so each layer adds to its input"


@pytest.mark.parametrize("graph", ["full", "banded", "none"])
@pytest.mark.parametrize("local", [True, False])
def test_tokenizer_padding_changes_nothing(graph: Adjacency, local: bool) -> None:
    model = tokenizer(replace(CONFIG, graph=graph, local=local))
    short, other = torch.randn(40, 263), torch.randn(64, 263)
    alone = model.encode(short[None], frames(40))
    garbage = torch.cat([short, 1e3 * torch.randn(24, 263)])
    both = model.encode(torch.stack([garbage, other]), frames(40, 64))
    for body, tokens in alone.items():
        assert torch.equal(both[body][0, : tokens.shape[1]], tokens[0]), body
    whole, inside = model.body("whole"), torch.arange(64) < frames(40, 64)[:, None]
    latent = whole.encode(torch.stack([garbage, other]), inside)
    assert torch.allclose(latent[0, :5], whole.encode(short[None], inside[:1, :40])[0], atol=1e-5)
    arms, inside = model.body("arms"), torch.arange(60) < frames(40, 60)[:, None]
    rows = torch.stack([garbage, other])[:, :60, list(channels("arms"))]
    changed = torch.where(inside[..., None], rows, 7.0)
    assert torch.allclose(arms.encode(rows, inside)[0, :4], arms.encode(changed, inside)[0, :4], atol=1e-6)
    decoded = model.decode({"whole": torch.cat([alone["whole"], alone["whole"].flip(1)], dim=1)}, frames(40))
    longer = torch.cat([alone["whole"], 0 * alone["whole"]], dim=1).repeat(2, 1, 1)
    padded = model.decode({"whole": longer}, frames(40, 80))
    assert torch.allclose(decoded[0], padded[0, :40], atol=1e-5)


def test_tokenizer_tokens_cover_the_frames() -> None:
    model = tokenizer()
    tokens = model.encode(torch.randn(3, 56, 263), frames(56, 56, 40))
    assert {body: tuple(rows.shape) for body, rows in tokens.items()} == {
        "whole": (3, 7, 2), "arms": (3, 5, 1), "legs": (3, 5, 1),
    }  # fmt: skip
    assert model.decode(tokens, frames(56, 56, 40)).shape == (3, 56, 263)
    assert window_mask(torch.arange(60) < frames(25)[:, None], 12).sum() == 3


def test_tokenizer_tokens_are_the_nearest_codes() -> None:
    model, features = tokenizer(), torch.randn(1, 24, 263)
    mask = torch.ones(1, 24, dtype=torch.bool)
    body, tokens = model.body("whole"), model.encode(features, frames(24))["whole"]
    latent = body.encode(model.standardise(features), mask)
    for window in range(3):
        for group in range(2):
            share = latent[0, window, 4 * group : 4 * group + 4]
            book = body.books[group].codebooks[0]
            distances = [float((share - code).square().sum()) for code in book]
            assert int(tokens[0, window, group]) == distances.index(min(distances))
            own = body.values(tokens)[0, window, 4 * group : 4 * group + 4]
            assert torch.equal(own, book[tokens[0, window, group]])


def test_tokenizer_part_reads_its_own_features_alone() -> None:
    model, features = tokenizer(), torch.randn(1, 24, 263)
    others = features.clone()
    rest = [i for i in range(263) if i not in channels("arms")]
    others[..., rest] += 5.0
    assert torch.equal(model.encode(features, frames(24))["arms"], model.encode(others, frames(24))["arms"])
    assert not torch.equal(model.encode(features, frames(24))["legs"], model.encode(others, frames(24))["legs"])


def test_tokenizer_without_a_whole_body_merges_its_parts() -> None:
    bodies = ("arms", "legs", "trunk")
    model = tokenizer(replace(CONFIG, bodies=bodies))
    tokens = model.encode(torch.randn(1, 24, 263), frames(24))
    found = model.decode(tokens, frames(24))
    changed = model.decode({**tokens, "trunk": (tokens["trunk"] + 1) % 8}, frames(24))
    own = list(channels("trunk"))
    rest = [i for i in range(263) if i not in own]
    assert torch.equal(found[..., rest], changed[..., rest])
    assert not torch.allclose(found[..., own], changed[..., own])


@pytest.mark.parametrize(
    "bodies", [("arms", "legs", "trunk"), ("left_arm", "right_arm", "left_leg", "right_leg", "backbone", "root")]
)
def test_parts_of_a_body_share_out_its_features(bodies: tuple[str, ...]) -> None:
    assert sorted(i for body in bodies for i in channels(body)) == list(range(len(CHANNELS)))


def test_unusable_bodies_and_windows_are_refused() -> None:
    with pytest.raises(InvalidOption, match="without whole the parts must share out the body"):
        replace(CONFIG, bodies=("arms", "legs"))
    with pytest.raises(UnknownName, match="unknown part of the body 'tail'"):
        replace(CONFIG, bodies=("arms", "tail"))
    with pytest.raises(InvalidOption, match="window: must be even and positive, found 7"):
        replace(CONFIG, window=7)
    with pytest.raises(InvalidOption, match="must divide the code width 8, found 3"):
        replace(CONFIG, groups=3)
    with pytest.raises(InvalidOption, match="parts are known of 263 features, found 251"):
        channels("arms", 251)
