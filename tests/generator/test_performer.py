"""Generation with untrained weights: shapes, timing of segments, same bytes twice, refusals. Also the commands."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from generator import weights
from generator.cli import Generate, Train
from generator.model import Sampling
from generator.models.segmo.config import TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.model import SegMo
from generator.nn.durations import DurationModel, DurationsConfig
from generator.performer import Performer, PerformerSettings
from generator.registry import SHARED
from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from generator.text.understanding import DOMAIN
from ros_free_stack.errors import InvalidOption, NoWeights, OutOfDomain, UnknownName
from ros_free_stack.files import load_motion
from tests.generator.tiny_dataset import write_tiny_dataset
from tests.generator.tiny_models import SMALLER, write_tiny_models

PROMPT = "a person waves, then bows"
SEGMENTS = ("a person waves", "a person bows")
QUICK = PerformerSettings(Sampling(steps=3))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights of tiny models that were never trained."""
    folder = write_tiny_models(tmp_path_factory.mktemp("weights"))
    Domain.fit(SEGMENTS, TextEncoder()).save(folder / SHARED / DOMAIN)
    return folder


@pytest.fixture(scope="module")
def generator(folder: Path) -> Performer:
    return Performer.load(folder)


def test_motion_has_its_prompt_segments_and_floor(generator: Performer) -> None:
    (motion,) = generator.generate(PROMPT, SEGMENTS, seed=0, settings=QUICK)
    assert motion.prompt == PROMPT
    assert tuple(segment.text for segment in motion.segments) == SEGMENTS
    assert motion.segments[0].end_s == motion.segments[1].start_s
    assert motion.segments[-1].end_s == pytest.approx(motion.duration_s)
    assert 2.0 <= motion.duration_s <= 9.8
    assert motion.joints[..., 2].min() == pytest.approx(0.0, abs=1e-9)


def test_same_seed_same_bytes(generator: Performer) -> None:
    def run(seed: int) -> list[bytes]:
        motions = generator.generate(PROMPT, SEGMENTS, seed=seed, candidates=3, settings=QUICK)
        return [motion.joints.tobytes() for motion in motions]

    first = run(5)
    assert first == run(5)
    assert first != run(6)
    assert len(set(first)) == 3


def test_durations_are_kept(generator: Performer) -> None:
    motions = generator.generate(PROMPT, SEGMENTS, seed=0, candidates=2, durations_s=(1.6, 3.2), settings=QUICK)
    for motion in motions:
        assert [(s.start_s, s.end_s) for s in motion.segments] == [(0.0, 1.6), (1.6, 4.8)]
    (motion,) = generator.generate(PROMPT, SEGMENTS, seed=0, duration_s=7.0, settings=QUICK)
    assert motion.duration_s == pytest.approx(7.0)


def test_uniform_layout_shares_the_time(generator: Performer) -> None:
    model = generator.model
    assert isinstance(model, SegMo)
    mask = MaskTransformer(replace(model.mask.config, layout="uniform")).eval()
    uniform = replace(generator, model=replace(model, mask=mask))
    (motion,) = uniform.generate(PROMPT, SEGMENTS, seed=0, durations_s=(1.6, 3.2), settings=QUICK)
    assert motion.segments[0].end_s == pytest.approx(2.4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"candidates": 0}, "candidates: must be at least 1"),
        ({"duration_s": 12.0}, "duration: 12 s is outside of 2 to 9.8 s"),
        ({"durations_s": (1.0,)}, "2 segments need as many durations, found 1"),
        ({"durations_s": (9.0, 9.0)}, "add up to 2 to 9.8 s"),
        ({"durations_s": (3.0, -0.5)}, "must be positive"),
    ],
)
def test_unusable_numbers_are_refused(generator: Performer, arguments: dict, message: str) -> None:
    with pytest.raises(InvalidOption, match=message):
        generator.generate(PROMPT, SEGMENTS, seed=0, **arguments)


def lasting(seconds: float) -> DurationModel:
    """A model by which every segment takes so long."""
    model = DurationModel(DurationsConfig(8)).eval()
    last = model.network[-1]
    assert isinstance(last, torch.nn.Linear)
    torch.nn.init.zeros_(last.weight)
    with torch.no_grad():
        last.bias.copy_(torch.tensor([np.log(seconds), -9.0]))
    return model


def test_a_long_sentence_is_generated_in_parts(generator: Performer) -> None:
    """Nothing is hurried, and no part begins with a jump."""
    texts = (*SEGMENTS, "a person squats")
    slow = replace(generator, durations=lasting(4.0))
    motions = slow.generate(PROMPT, texts, seed=0, candidates=2, settings=QUICK)
    for motion in motions:
        assert motion.prompt == PROMPT
        assert [segment.text for segment in motion.segments] == list(texts)
        assert [s.end_s - s.start_s for s in motion.segments] == pytest.approx([4.0, 4.0, 4.0], abs=0.9)
        assert motion.duration_s == pytest.approx(motion.segments[-1].end_s)
    assert motions[0].joints.tobytes() != motions[1].joints.tobytes()
    again = slow.generate(PROMPT, texts, seed=0, candidates=2, settings=QUICK)
    assert [m.joints.tobytes() for m in again] == [m.joints.tobytes() for m in motions]


def test_an_action_that_takes_too_long_is_hurried_and_said(
    generator: Performer, capsys: pytest.CaptureFixture[str]
) -> None:
    slow = replace(generator, durations=lasting(12.0))
    (motion,) = slow.generate(SEGMENTS[0], SEGMENTS[:1], seed=0, settings=QUICK)
    assert motion.duration_s == pytest.approx(9.8)
    assert "performed faster, within 9.8 s" in capsys.readouterr().err


def test_missing_and_foreign_weights_are_named(folder: Path, tmp_path: Path) -> None:
    with pytest.raises(NoWeights, match="no trained tokenizer; train it with"):
        Performer.load(tmp_path)
    copy = tmp_path / "copy"
    shutil.copytree(folder, copy)
    saved = weights.load(folder / "segmo" / "mask", "mask")
    mask = MaskTransformer(saved.config_as(TransformerConfig))
    weights.save(copy / "segmo" / "mask", mask.config, mask, {"tokenizer": "another"})
    with pytest.raises(NoWeights, match="trained with another tokenizer"):
        Performer.load(copy)
    with pytest.raises(UnknownName, match="unknown generator 'mdm'; valid: momask, part-wise, party, segmo"):
        Performer.load(folder, generator="mdm")


def test_generate_command_writes_a_motion(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "new" / "motion.npz"
    assert Generate(prompt=PROMPT, out=out, weights=folder, candidates=2, seed=1).run() == 0
    first, second = load_motion(out), load_motion(out.with_stem("motion_1"))
    assert len(first.segments) == len(second.segments) == 2
    assert first.prompt == PROMPT
    assert not np.array_equal(first.joints, second.joints)


def test_generate_command_refuses_what_the_model_does_not_know(folder: Path, tmp_path: Path) -> None:
    out = tmp_path / "motion.npz"
    with pytest.raises(OutOfDomain):
        Generate(prompt="a person photosynthesises", out=out, weights=folder).run()
    assert not out.exists()
    assert Generate(prompt="a person photosynthesises", out=out, weights=folder, anyway=True).run() == 0
    assert out.exists()


def test_train_command_trains_all_stages(tmp_path: Path) -> None:
    dataset = write_tiny_dataset(tmp_path / "data", clips=8)
    before = torch.get_num_threads()
    command = Train(
        stage="all", dataset=dataset, out=tmp_path / "out", set=SMALLER, iterations=2, threads=1, device="cpu"
    )
    assert command.run() == 0
    torch.set_num_threads(before)
    (motion,) = Performer.load(tmp_path / "out").generate(PROMPT, SEGMENTS, seed=0, settings=QUICK)
    assert motion.joints.shape[1:] == (22, 3)


def test_generate_command_goes_on_edits_and_appends(folder: Path, tmp_path: Path) -> None:
    first, second, third, fourth = (tmp_path / f"{name}.npz" for name in ("first", "second", "third", "fourth"))
    assert Generate(prompt=PROMPT, out=first, weights=folder, durations=(2.0, 2.0)).run() == 0
    assert Generate(prompt=PROMPT, out=second, weights=folder, start=first, duration=2.4).run() == 0
    whole = load_motion(first)
    assert load_motion(second).duration_s == pytest.approx(2.4)
    assert Generate(prompt=PROMPT, out=third, weights=folder, edit=first, range=(1.0, 2.0)).run() == 0
    assert load_motion(third).joints[:20].tobytes() == whole.joints[:20].tobytes()
    assert len(load_motion(third).joints) == len(whole.joints)
    assert Generate(prompt=PROMPT, out=fourth, weights=folder, then=("a person bows", "a person waves")).run() == 0
    assert [segment.text for segment in load_motion(fourth).segments][-2:] == ["a person bows", "a person waves"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"range": (1.0, 2.0)}, "--range needs --edit"),
        ({"duration": 3.0, "durations": (1.0, 2.0)}, "--durations: cannot be combined with --duration"),
        ({"duration": 3.0, "then": ("a person bows",)}, "--duration: cannot be combined with --edit or --then"),
    ],
)
def test_generate_command_names_options_that_do_not_go_together(
    folder: Path, tmp_path: Path, options: dict, message: str
) -> None:
    with pytest.raises(InvalidOption, match=message):
        Generate(prompt=PROMPT, out=tmp_path / "motion.npz", weights=folder, **options).run()
