"""ParTY's grounding, fusion and network: equations against plain loops, causality, padding, stepwise generation."""

import math
from dataclasses import replace

import pytest
import torch
from torch import Tensor

from generator.config import checked
from generator.models.party.condition import Condition
from generator.models.party.config import (
    PartySampling,
    TokenizerConfig,
    TokenizerLosses,
    TransformerConfig,
    TransformerLosses,
)
from generator.models.party.fusion import FusionPast, HolisticPartFusion, merge, part_steps, split
from generator.models.party.generation import Generation
from generator.models.party.grounding import TextGrounding, diversity_loss
from generator.models.party.network import PartyNetwork
from generator.models.party.objectives.transformer import corrupted, token_loss
from generator.nn.causal import Attention
from generator.registry import find_preset
from ros_free_stack.errors import InvalidOption

TOKENS = TokenizerConfig(
    bodies=("whole", "arms", "legs"), window=8, part_window=12, width=16, encoder_width=12, depth=1, codes=11,
    part_codes=7, code_width=8, groups=2,
)  # fmt: skip
CONFIG = TransformerConfig(
    width=16, layers=2, part_layers=2, heads=4, feed_forward=32, dropout=0.0, fusion_heads=2, fusion_head_width=6,
    cycle=3, part_cycle=2, embeddings=3, conditioning="layout",
)  # fmt: skip
EQUAL = replace(TOKENS, part_window=8)
PART_WISE = replace(TOKENS, bodies=("arms", "legs", "trunk"))
ALL = [
    (TOKENS, CONFIG),
    (TOKENS, replace(CONFIG, part_cycle=3)),
    (TOKENS, replace(CONFIG, conditioning="sentence", embeddings=0)),
    (TOKENS, replace(CONFIG, guidance=False)),
    (TOKENS, replace(CONFIG, fusion=False)),
    (EQUAL, replace(CONFIG, part_cycle=3)),
    (replace(TOKENS, part_window=4), replace(CONFIG, part_cycle=6)),
    (PART_WISE, CONFIG),
]  # fmt: skip


def network(tokens: TokenizerConfig = TOKENS, config: TransformerConfig = CONFIG) -> PartyNetwork:
    torch.manual_seed(0)
    model = PartyNetwork(config, tokens)
    for parameter in model.parameters():
        parameter.data.add_(0.1 * torch.randn_like(parameter))
    return model.eval()


def condition(frames: list[list[int]], config: TransformerConfig = CONFIG) -> Condition:
    torch.manual_seed(3)
    rows = 1 + (len(frames[0]) if config.conditioning == "layout" else 0)
    clauses = torch.randn(len(frames), rows, 2, 384)
    clauses[:, 0] = 0
    return Condition(torch.randn(len(frames), rows, 384), clauses, torch.tensor(frames))


def random_tokens(tokens: TokenizerConfig, given: Condition) -> dict[str, Tensor]:
    torch.manual_seed(4)
    shapes = {
        body: (len(given.frames), int(given.counts(tokens.window_of(body)).max()), tokens.groups_of(body))
        for body in tokens.bodies
    }
    return {body: torch.randint(0, tokens.codes_of(body), shape) for body, shape in shapes.items()}


def test_diversity_loss_is_equation_3() -> None:
    torch.manual_seed(1)
    views, text, tau = torch.randn(2, 4, 6), torch.randn(2, 6), 0.05

    def s(a: Tensor, b: Tensor) -> float:
        return (a @ b / (a.norm() * b.norm())).item()

    losses = []
    for row in range(2):
        for n in range(4):
            near = math.exp(s(views[row, n], text[row]) / tau)
            others = sum(math.exp(s(views[row, n], views[row, m]) / tau) for m in range(4) if m != n)
            losses.append(-math.log(near / (near + others)))
    assert diversity_loss(views, text, tau).item() == pytest.approx(sum(losses) / len(losses), rel=1e-4)


def test_diversity_loss_of_one_embedding_is_zero() -> None:
    assert diversity_loss(torch.randn(3, 1, 6), torch.randn(3, 6), 0.05).item() == pytest.approx(0.0, abs=1e-6)


def test_grounding_gates_each_part_by_itself() -> None:
    torch.manual_seed(1)
    grounding = TextGrounding(row_width=9, text_width=6, width=8, embeddings=4, parts=["arms", "legs"])
    rows = torch.randn(2, 3, 9)
    found = grounding(rows)
    for part in ("arms", "legs"):
        assert torch.allclose(found.shares[part].sum(-1), torch.ones(2, 3))
        views = torch.stack([view(rows) for view in grounding.views])
        expected = sum((found.shares[part][..., k, None] * views[k] for k in range(4)), torch.zeros(2, 3, 6))
        assert torch.allclose(found.parts[part], expected, atol=1e-5)
    assert not torch.allclose(found.parts["arms"], found.parts["legs"])


@pytest.mark.parametrize("counts", [(3, 2, 2), (1, 0, 4), (4, 4)])
def test_merge_and_split_are_inverse(counts: tuple[int, ...]) -> None:
    rows = [torch.randn(2, count, 5) for count in counts]
    merged = merge(rows, torch.randn(len(counts) - 1, 5))
    assert merged.shape[1] == sum(counts) + len(counts) - 1
    for row, found in zip(rows, split(merged, counts), strict=True):
        assert torch.equal(row, found)


def attend(layer: Attention, query: Tensor, others: list[Tensor]) -> Tensor:
    """Multi-head attention of one token to a list of tokens, by the formula of the paper."""
    heads = layer.heads
    found = []
    q = layer.queries(query)
    keys, values = zip(*(layer.others(other).chunk(2) for other in others), strict=True)
    size = len(q) // heads
    for head in range(heads):
        own = slice(head * size, (head + 1) * size)
        scores = [math.exp((q[own] @ key[own]).item() / math.sqrt(size)) for key in keys]
        found.append(
            sum((s / sum(scores) * value[own] for s, value in zip(scores, values, strict=True)), torch.zeros(size))
        )
    return layer.output(torch.cat(found))


def test_fusion_is_equations_8_and_9_over_the_tokens_so_far() -> None:
    torch.manual_seed(5)
    fusion = HolisticPartFusion(8, 2, 3, 2).eval()
    whole, arms, legs = torch.randn(1, 4, 8), torch.randn(1, 3, 8), torch.randn(1, 3, 8)
    own, part = torch.arange(4), part_steps(3, 12, 8)
    assert part.tolist() == [0, 1, 3]
    valid = [torch.ones(1, count, dtype=torch.bool) for count in (4, 3, 3)]
    found = fusion(whole, [arms, legs], [own, part, part], valid)[0]
    tokens = [(int(s), whole[0, i]) for i, s in enumerate(own)]
    tokens += [(-1, fusion.separators[0])] + [(int(s), arms[0, i]) for i, s in enumerate(part)]
    tokens += [(-1, fusion.separators[1])] + [(int(s), legs[0, i]) for i, s in enumerate(part)]
    normed = [(step, fusion.norm_own(token)) for step, token in tokens]
    fused = [
        token + attend(fusion.own, fusion.norm_own(token), [other for when, other in normed if when <= step])
        for step, token in tokens
    ]
    for t in range(4):
        expected = fused[t]
        for number, start in ((0, 5), (1, 9)):
            seen = [fusion.norm_split(fused[start + i]) for i in range(3) if part[i] <= t]
            expected = expected + attend(fusion.attentions[number], fusion.norm_split(fused[t]), seen)
        assert torch.allclose(found[t], expected, atol=1e-5)


@pytest.mark.parametrize("windows", [(12, 8), (8, 8), (4, 8)])
def test_fusion_step_by_step_equals_all_at_once(windows: tuple[int, int]) -> None:
    torch.manual_seed(6)
    part_window, window = windows
    fusion, count = HolisticPartFusion(8, 2, 3, 2).eval(), 5
    parts = -(-count * window // part_window)
    whole, rows = torch.randn(2, count, 8), [torch.randn(2, parts, 8) for _ in range(2)]
    steps = part_steps(parts, part_window, window)
    inside = torch.arange(parts) < torch.tensor([[parts], [max(1, parts - 2)]])
    valid = [torch.ones(2, count, dtype=torch.bool), inside, inside]
    whole_found = fusion(whole, rows, [torch.arange(count), steps, steps], valid)
    past = FusionPast(2)
    for step in range(count):
        own = (steps == step).nonzero()[:, 0]
        found = fusion.step(whole[:, step : step + 1], [row[:, own] for row in rows], [inside[:, own]] * 2, past)
        assert torch.allclose(found[:, 0], whole_found[:, step], atol=1e-5)


@pytest.mark.parametrize(("tokens", "config"), ALL)
def test_network_later_tokens_never_change_earlier_logits(tokens: TokenizerConfig, config: TransformerConfig) -> None:
    model, given = network(tokens, config), condition([[24, 32], [30, 26]], config)
    first = random_tokens(tokens, given)
    keep = torch.ones(2, dtype=torch.bool)
    before, _ = model(first, given, keep)
    for body in tokens.bodies:
        for place in range(first[body].shape[1]):
            changed = {name: rows.clone() for name, rows in first.items()}
            changed[body][:, place:] = (changed[body][:, place:] + 1) % tokens.codes_of(body)
            after, _ = model(changed, given, keep)
            assert torch.allclose(after[body][:, :place], before[body][:, :place], atol=1e-5)
            assert torch.allclose(after[body][:, place, 0], before[body][:, place, 0], atol=1e-5)
            if body != "whole" and tokens.holistic:
                guides = place // config.part_cycle * config.cycle
                reads = place * tokens.part_window // tokens.window + 1
                earliest = min(guides if config.guidance else 99, reads if config.fusion else 99)
                unchanged = slice(0, min(earliest, before["whole"].shape[1]))
                assert torch.allclose(after["whole"][:, unchanged], before["whole"][:, unchanged], atol=1e-5)


@pytest.mark.parametrize(("tokens", "config"), ALL)
def test_network_padding_changes_nothing(tokens: TokenizerConfig, config: TransformerConfig) -> None:
    model, both = network(tokens, config), condition([[24, 0], [30, 42]], config)
    padded = random_tokens(tokens, both)
    rows = 2 if config.conditioning == "layout" else 1
    alone = Condition(both.texts[:1, :rows], both.clauses[:1, :rows], both.frames[:1, :1])
    own = {body: tokens_of[:1, : int(alone.counts(tokens.window_of(body))[0])] for body, tokens_of in padded.items()}
    together, _ = model(padded, both, torch.ones(2, dtype=torch.bool))
    apart, _ = model(own, alone, torch.ones(1, dtype=torch.bool))
    for body in tokens.bodies:
        assert torch.allclose(together[body][0, : apart[body].shape[1]], apart[body][0], atol=1e-4), body


@pytest.mark.parametrize("guidance", [1.0, 2.5])
@pytest.mark.parametrize(("tokens", "config"), ALL)
def test_generation_with_its_cache_equals_teacher_forcing(
    tokens: TokenizerConfig, config: TransformerConfig, guidance: float
) -> None:
    """The best code at every place, generated step by step, is the best code of the logits of the whole sequence."""
    model, given = network(tokens, config), condition([[24, 0], [30, 42]], config)
    sampling = PartySampling(top_k=0.01, guidance=guidance)  # one code: greedy
    with torch.inference_mode():
        found, frames = Generation(model, given, sampling, torch.Generator().manual_seed(0)).run()
        assert frames.tolist() == [24, 72]
        said, _ = model(found, given, torch.ones(2, dtype=torch.bool))
        unsaid, _ = model(found, given, torch.zeros(2, dtype=torch.bool))
    for body in tokens.bodies:
        guided = (unsaid[body] + guidance * (said[body] - unsaid[body]))[:, :-1, :, :-1]
        for row, count in enumerate(given.counts(tokens.window_of(body)).tolist()):
            assert torch.equal(guided[row, :count].argmax(-1), found[body][row, :count]), body


def test_generation_same_noise_same_tokens_and_known_ones_stay() -> None:
    model, given = network(), condition([[24, 32], [30, 26]])
    known = random_tokens(TOKENS, given)
    stay = {body: torch.where(torch.arange(rows.shape[1])[:, None] < 2, rows, -1) for body, rows in known.items()}
    one, _ = Generation(model, given, PartySampling(), torch.Generator().manual_seed(1), stay).run()
    two, _ = Generation(model, given, PartySampling(), torch.Generator().manual_seed(1), stay).run()
    other, _ = Generation(model, given, PartySampling(), torch.Generator().manual_seed(2), stay).run()
    for body, rows in one.items():
        assert torch.equal(rows, two[body]) and torch.equal(rows[:, :2], known[body][:, :2])
    assert any(not torch.equal(rows, other[body]) for body, rows in one.items())


def test_generation_ends_where_its_end_token_comes() -> None:
    config = replace(CONFIG, conditioning="sentence")
    model, given = network(TOKENS, config), condition([[8], [8], [8], [8]], config)
    model.body("whole").head.output(0).bias.data[-1] = 4.0
    tokens, frames = Generation(model, given, PartySampling(), torch.Generator().manual_seed(0), most=192).run()
    assert len(set(frames.tolist())) > 1 and frames.min() >= 8 and frames.max() < 192
    for row, count in enumerate((frames // 8).tolist()):
        codes = tokens["whole"][row, :, 0].tolist()
        assert codes.index(11) == count, "the first end token is where the motion ends"
    model.body("whole").head.output(0).bias.data[-1] = -1e3
    _, frames = Generation(model, given, PartySampling(), torch.Generator().manual_seed(0), most=192).run()
    assert frames.tolist() == [192] * 4


def test_token_loss_is_equations_10_and_11_with_the_end() -> None:
    torch.manual_seed(2)
    logits, tokens, counts = torch.randn(2, 4, 2, 6), torch.randint(0, 5, (2, 3, 2)), torch.tensor([3, 1])
    terms = []
    for row in range(2):
        for place in range(int(counts[row])):
            for group in range(2):
                terms.append(-logits[row, place, group].log_softmax(-1)[tokens[row, place, group]].item())
        terms.append(-logits[row, int(counts[row]), 0].log_softmax(-1)[5].item())
    loss, _ = token_loss(logits, tokens, counts)
    assert loss.item() == pytest.approx(sum(terms) / len(terms), rel=1e-5)


def test_corrupted_share_of_the_tokens_is_random() -> None:
    torch.manual_seed(0)
    tokens = torch.zeros(50, 20, 1, dtype=torch.long)
    assert corrupted(tokens, 1000, 0.0) is tokens
    assert float((corrupted(tokens, 1000, 0.3) > 0).float().mean()) == pytest.approx(0.3, abs=0.06)


def test_guidance_that_does_not_cover_its_cycle_is_refused() -> None:
    with pytest.raises(InvalidOption, match="2 part tokens of 8 frames cover 16 frames, the cycle of 3 tokens of 8"):
        PartyNetwork(CONFIG, EQUAL)


def test_condition_tells_each_token_its_segment() -> None:
    given = condition([[24, 32], [40, 0]])
    assert given.counts(12).tolist() == [5, 4]
    assert given.segment(7, 8).tolist() == [[0, 0, 0, 1, 1, 1, 1], [0] * 7]
    assert given.mask(7, 8).sum(1).tolist() == [7, 5]


@pytest.mark.parametrize(("preset", "size"), [("party", "published"), ("party", "small"), ("party-small", "small")])
def test_presets_of_party_fit_together(preset: str, size: str) -> None:
    _, found = find_preset(preset, size)
    tokens = checked(TokenizerConfig, found.stage("tokenizer")["model"], "tokenizer.model")
    config = checked(TransformerConfig, found.stage("transformer")["model"], "transformer.model")
    losses = checked(TokenizerLosses, found.stage("tokenizer")["objective"], "tokenizer.objective")
    checked(TransformerLosses, found.stage("transformer")["objective"], "transformer.objective")
    assert all(losses.window % tokens.window_of(body) == 0 for body in tokens.bodies)
    assert PartyNetwork(config, tokens).fusion is not None


def test_part_wise_preset_has_neither_a_whole_body_nor_guidance() -> None:
    _, found = find_preset("part-wise")
    tokens = checked(TokenizerConfig, found.stage("tokenizer")["model"], "tokenizer.model")
    config = checked(TransformerConfig, found.stage("transformer")["model"], "transformer.model")
    model = PartyNetwork(config, tokens)
    assert not tokens.holistic and len(tokens.parts) == 6
    assert model.mix is None and model.fusion is None and model.grounding is None
