"""Grounding and captioning as commands, on a space that was trained on a tiny data set; measures from definitions."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch.nn import functional

from generator.datasets.authored import AuthoredCorpus
from generator.grounding.cli import Caption, Ground
from generator.grounding.consistency import consistency, paired_segments, recall
from generator.grounding.search import BACKGROUND, ground, similarity_map
from generator.grounding.space import AlignedSpace
from generator.grounding.texts import KnownTexts
from generator.models.segmo.config import TOKEN_S
from generator.models.segmo.objectives.batches import TokenBatches, TokenCorpus
from generator.text.encoder import TextEncoder
from ros_free_stack.errors import InvalidFile, InvalidOption, NoWeights
from ros_free_stack.files import load_motion, save_motion
from ros_free_stack.messages import HumanMotion, Segment
from tests.generator.tiny_dataset import ACTIONS, tiny_joints, write_tiny_dataset
from tests.generator.tiny_models import tiny_job

CHANGES = (
    "tokenizer.model.encoder_width=24",
    *(f"{stage}.training.iterations=150" for stage in ("tokenizer", "grounding")),
    *(f"{stage}.training.warm_up=5" for stage in ("tokenizer", "grounding")),
    "grounding.training.ema=0.9",
    "grounding.training.weight_decay=0.0",
)
WAVE, WALK = "a person waves with the left hand", "a person walks forward"


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> AuthoredCorpus:
    return AuthoredCorpus.open(write_tiny_dataset(tmp_path_factory.mktemp("grounding") / "data", clips=40))


@pytest.fixture(scope="module")
def folder(dataset: AuthoredCorpus, tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("weights")
    for stage in ("tokenizer", "grounding"):
        torch.manual_seed(0)
        tiny_job(stage, dataset, out, *CHANGES).run()
    return out


@pytest.fixture(scope="module")
def motion(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Waves with the left hand for 2 s, then walks for 2 s."""
    path = tmp_path_factory.mktemp("motion") / "motion.npz"
    joints = tiny_joints([WAVE, WALK], 40, np.random.default_rng(5))
    joints[..., 2] -= joints[..., 2].min()
    save_motion(path, HumanMotion(joints, 20.0, segments=(Segment(WAVE, 0, 2), Segment(WALK, 2, 4))))
    return path


def test_ground_finds_each_text_where_it_happens(
    folder: Path, motion: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = Ground(
        motion=motion, prompt=f"{WAVE}, then walks forward", out=tmp_path / "map.png", weights=folder, json=True
    )
    assert command.run() == 0
    wave, walk = json.loads(capsys.readouterr().out)["segments"]
    assert (wave["text"], walk["text"]) == (WAVE, WALK)
    assert wave["start_s"] < 2 < walk["end_s"]
    assert wave["start_s"] + wave["end_s"] < walk["start_s"] + walk["end_s"]
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


def test_ground_command_takes_the_most_similar_window_as_the_paper_does(
    folder: Path, motion: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command = Ground(motion=motion, prompt=f"{WAVE}, then walks forward", weights=folder, json=True)
    assert replace(command, method="most-similar", window=0.8).run() == 0
    wave, walk = json.loads(capsys.readouterr().out)["segments"]
    assert [round(found["end_s"] - found["start_s"], 6) for found in (wave, walk)] == [0.8, 0.8]
    assert wave["end_s"] <= 2.4 and walk["start_s"] >= 1.6
    space = AlignedSpace.load(folder / "segmo")
    hidden = space.hidden(space.motion_tokens(load_motion(motion)))
    similarity = similarity_map(space, hidden, space.texts(TextEncoder(), [WAVE, WALK]), 4)
    for found, own in zip((wave, walk), similarity, strict=True):
        assert found["similarity"] == pytest.approx(own.max(), abs=1e-5)
        assert found["start_s"] == pytest.approx(0.2 * own.argmax())


def test_caption_names_each_segment(folder: Path, motion: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert Caption(motion=motion, top=2, weights=folder, json=True).run() == 0
    wave, walk = json.loads(capsys.readouterr().out)["segments"]
    assert (wave["start_s"], wave["end_s"], walk["start_s"]) == (0, 2, 2)
    assert [len(segment["texts"]) for segment in (wave, walk)] == [2, 2]
    assert walk["texts"][0]["text"] == WALK
    assert Caption(motion=motion, segments=3, weights=folder, json=True).run() == 0
    cut = json.loads(capsys.readouterr().out)["segments"]
    assert len(cut) == 3
    assert cut[-1]["end_s"] == pytest.approx(19 * TOKEN_S)


def test_windows_are_segments(folder: Path) -> None:
    space = AlignedSpace.load(folder / "segmo")
    hidden = space.hidden(torch.arange(10).expand(space.model.config.parts, -1))
    windows = space.windows(hidden, 4)
    assert windows.shape == (7, 32)
    torch.testing.assert_close(windows[0], space.segments(hidden, [4, 6])[0])
    torch.testing.assert_close(windows[6], space.segments(hidden, [6, 4])[1])
    texts = functional.normalize(torch.randn(2, 32), dim=1)
    (alone,) = ground(space, hidden, texts[:1])
    similarities = {n: similarity_map(space, hidden, texts, n)[0] for n in range(4, 11)}
    best = max(float(row.max() - BACKGROUND) * n**0.5 for n, row in similarities.items())
    length = round((alone.end_s - alone.start_s) / TOKEN_S)
    assert (alone.similarity - BACKGROUND) * length**0.5 == pytest.approx(best)
    assert alone.similarity == pytest.approx(similarities[length][round(alone.start_s / TOKEN_S)])


def test_texts_are_found_in_order(folder: Path) -> None:
    """The windows are the best ones of all that follow each other, as trying all of them finds."""
    space = AlignedSpace.load(folder / "segmo")
    hidden = space.hidden(torch.arange(11).expand(space.model.config.parts, -1))
    texts = functional.normalize(torch.randn(2, 32, generator=torch.Generator().manual_seed(1)), dim=1)
    windows = [(a, b) for a in range(8) for b in range(a + 4, 12)]
    evidence = {
        (row, a, b): float(similarity_map(space, hidden, texts, b - a)[row, a] - BACKGROUND) * (b - a) ** 0.5
        for row in (0, 1)
        for a, b in windows
    }
    best = max(evidence[0, a, b] + evidence[1, c, d] for a, b in windows for c, d in windows if b <= c)
    first, second = ground(space, hidden, texts)
    assert first.end_s <= second.start_s
    total = sum((f.similarity - BACKGROUND) * ((f.end_s - f.start_s) / TOKEN_S) ** 0.5 for f in (first, second))
    assert total == pytest.approx(best)
    assert len(ground(space, hidden[:3], texts)) == 2
    with pytest.raises(InvalidOption, match="do not fit"):
        ground(space, hidden[:1], texts)


def test_known_texts_survive_the_disk(folder: Path, dataset: AuthoredCorpus, tmp_path: Path) -> None:
    known = KnownTexts.load(folder / "segmo" / "grounding")
    assert set(known.texts) == set(ACTIONS)
    assert known.nearest(known.embeddings, 1) == [[(text, pytest.approx(1, abs=1e-2))] for text in known.texts]
    with pytest.raises(InvalidFile, match="train grounding"):
        KnownTexts.load(tmp_path)
    (tmp_path / "texts.safetensors").write_bytes(b"nothing")
    with pytest.raises(InvalidFile, match="not the known texts"):
        KnownTexts.load(tmp_path)


def test_what_is_wrong_is_named(folder: Path, motion: Path, tmp_path: Path) -> None:
    with pytest.raises(NoWeights, match="no trained tokenizer"):
        AlignedSpace.load(tmp_path)
    with pytest.raises(InvalidOption, match=r"--window: must be 0\.2 to 3\.8 s here, found 9"):
        Ground(motion=motion, prompt=WAVE, window=9, weights=folder).run()
    with pytest.raises(InvalidOption, match="--top: must be at least 1, found 0"):
        Caption(motion=motion, top=0, weights=folder).run()
    with pytest.raises(InvalidOption, match="1 to 5 segments, found 0"):
        Caption(motion=motion, segments=0, weights=folder).run()
    long = tmp_path / "long.npz"
    save_motion(long, HumanMotion(np.ones((300, 22, 3)), 20.0))
    with pytest.raises(InvalidOption, match="17 to 197 frames at 20 fps, found 300"):
        Caption(motion=long, weights=folder).run()


def test_consistency_is_mean_cosine_and_its_variation() -> None:
    text = torch.tensor([[1.0, 0.0], [0.0, 1.0]])
    motion = torch.tensor([[1.0, 0.0], [0.6, 0.8]])
    found = consistency(text, motion)
    assert found.mean == pytest.approx(0.9)
    assert found.variation == pytest.approx(0.1 / 0.9, rel=1e-5)


def test_paired_segments_are_near_after_training(folder: Path, dataset: AuthoredCorpus) -> None:
    corpus = TokenCorpus.build(dataset, folder / "segmo" / "tokenizer", "cpu")
    batches = TokenBatches(corpus, batch=4, layout="exact", segmentation="exact", seed=0).batches(corpus.train)
    text, motion = paired_segments(AlignedSpace.load(folder / "segmo").model, batches)
    assert len(text) == len(motion) == sum(len(clip.segments) for clip in dataset.split("train"))
    shuffled = text[torch.randperm(len(text), generator=torch.Generator().manual_seed(0))]
    assert consistency(text, motion).mean > consistency(shuffled, motion).mean + 0.2


def test_recall_counts_own_targets_in_pools_without_doubles() -> None:
    targets = torch.eye(6)
    group = np.arange(6)
    assert recall(targets, targets, group, rank=1, pool=4, seed=0) == 1
    assert recall(targets.roll(1, 0), targets, group, rank=1, pool=6, seed=0) == 0
    assert recall(targets.roll(1, 0), targets, np.zeros(6), rank=1, pool=6, seed=0) == 1
