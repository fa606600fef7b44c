"""Training of every stage on a tiny data set: it learns, resumes exactly, stops at a signal, names what is wrong."""

import csv
import json
import os
import signal
import threading
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import torch

from generator import weights
from generator.config import AlignmentKind
from generator.datasets.authored import AuthoredCorpus
from generator.datasets.dataset import Caption
from generator.datasets.text_cache import text_table
from generator.models.segmo.config import ConditioningKind, MaskLosses, TokenizerConfig, TransformerConfig
from generator.models.segmo.objectives.batches import BUCKET, TokenBatches, TokenCorpus, repetitions_of
from generator.models.segmo.objectives.mask import MaskObjective
from generator.models.segmo.objectives.tokenizer import from_job
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.text.meanwhile import clauses_at_once
from generator.timing import uniform_lengths
from generator.training import loop
from generator.training.loop import Run, train
from generator.training.stages import choose_device
from ros_free_stack.errors import InvalidFile, InvalidOption, NoWeights, UnknownName
from tests.generator.tiny_dataset import write_tiny_dataset
from tests.generator.tiny_models import STAGES, tiny_job

_SETTINGS = tiny_job("mask", None, Path())  # type: ignore[arg-type]
_TRANSFORMER, _TRAINING = _SETTINGS.model(TransformerConfig), _SETTINGS.training
_TOKENIZER = replace(_SETTINGS, stage="tokenizer").model(TokenizerConfig)


@pytest.fixture(scope="module", params=["off", "on"], autouse=True)
def bfloat16(request: pytest.FixtureRequest) -> Iterator[str]:
    """Everything here is trained in float32 and under bfloat16 autocast, whatever the processor is good at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(loop.BF16, request.param)
        yield request.param


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> AuthoredCorpus:
    return AuthoredCorpus.open(write_tiny_dataset(tmp_path_factory.mktemp("data") / "tiny"))


@pytest.fixture(scope="module")
def trained(dataset: AuthoredCorpus, bfloat16: str, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which all stages were trained, one after the other."""
    out = tmp_path_factory.mktemp(f"weights-bfloat16-{bfloat16}")
    for stage in STAGES:
        torch.manual_seed(0)
        assert tiny_job(stage, dataset, out).run()["finished"] == 1
    return out / "segmo"


def tokenizer_run(dataset: AuthoredCorpus, folder: Path, run: Run) -> dict[str, float]:
    torch.manual_seed(0)
    job = tiny_job("tokenizer", dataset, folder)
    return train(from_job(job), job.training, folder, run)


def curve(folder: Path) -> list[dict[str, str]]:
    with (folder / "curve.csv").open(newline="") as stream:
        return [{**row, "seconds": ""} for row in csv.DictReader(stream)]


@pytest.mark.parametrize("stage", STAGES)
def test_every_stage_leaves_weights_config_and_curve(dataset: AuthoredCorpus, trained: Path, stage: str) -> None:
    job = tiny_job(stage, dataset, trained.parent)
    folder = job.folder(stage)
    saved = weights.load(folder, stage)
    assert json.loads((folder / "config.json").read_text())["version"] == weights.FORMAT_VERSION
    assert job.preset.stage(stage)["model"].items() <= saved.config.items()
    assert saved.facts["training"] == json.loads(json.dumps(asdict(job.training)))
    rows = curve(folder)
    assert [row["iteration"] for row in rows] == [str(i) for i in range(1, 13)]
    assert rows[-1]["validation_loss"]
    assert (folder / "curve.png").read_bytes().startswith(b"\x89PNG")


def test_matrices_are_saved_in_half_precision_and_vectors_are_not(trained: Path) -> None:
    state = weights.load(trained / "tokenizer", "tokenizer").state
    assert state["quantizers.0.codebooks"].dtype == torch.float16
    assert state["mean"].dtype == torch.float32


def test_training_lowers_the_loss(dataset: AuthoredCorpus, tmp_path: Path) -> None:
    tokenizer_run(dataset, tmp_path, Run(60))
    losses = [float(row["loss"]) for row in curve(tmp_path)]
    assert np.mean(losses[-5:]) < 0.6 * np.mean(losses[:5])


def test_a_resumed_run_repeats_an_unbroken_one(
    dataset: AuthoredCorpus, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tokenizer_run(dataset, tmp_path / "whole", Run(10))
    steps = iter([False] * 6 + [True] * 10)
    with monkeypatch.context() as patch:
        patch.setattr(loop, "_stop_requested", lambda: _Stop(steps))
        assert tokenizer_run(dataset, tmp_path / "broken", Run(10))["finished"] == 0
    assert len(curve(tmp_path / "broken")) == 6
    assert tokenizer_run(dataset, tmp_path / "broken", Run(10, resume=True))["finished"] == 1
    assert curve(tmp_path / "broken") == curve(tmp_path / "whole")
    assert weights.digest(tmp_path / "broken") == weights.digest(tmp_path / "whole")


class _Stop:
    """In the place of the signal handler: asks to stop when the given answers say so."""

    def __init__(self, answers: "object") -> None:
        self._answers = answers

    def __enter__(self):
        return lambda: next(self._answers)  # type: ignore[call-overload]

    def __exit__(self, *_: object) -> None:
        return None


def test_a_signal_leaves_a_checkpoint(dataset: AuthoredCorpus, tmp_path: Path) -> None:
    timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGTERM))
    before = signal.getsignal(signal.SIGTERM)
    timer.start()
    result = tokenizer_run(dataset, tmp_path, Run(1_000_000))
    timer.join()
    assert result["finished"] == 0
    assert (tmp_path / "checkpoint.pt").is_file()
    assert signal.getsignal(signal.SIGTERM) == before


def test_minutes_end_a_run_too(dataset: AuthoredCorpus, tmp_path: Path) -> None:
    result = tokenizer_run(dataset, tmp_path, Run(1_000_000, minutes=0.005))
    assert result["finished"] == 1
    assert result["learning_rate"] < 0.2 * _TRAINING.learning_rate
    assert (tmp_path / weights.WEIGHTS).is_file()


def test_batches_depend_on_seed_and_iteration_alone(dataset: AuthoredCorpus, trained: Path) -> None:
    corpus = TokenCorpus.build(dataset, trained / "tokenizer", "cpu")
    first, second = (TokenBatches(corpus, batch=4, layout="exact", segmentation="uniform", seed=0) for _ in range(2))
    first.training(0)
    other = TokenBatches(corpus, batch=4, layout="exact", segmentation="uniform", seed=1)
    a, b, c = (batches.training(BUCKET + 3) for batches in (first, second, other))
    assert torch.equal(a.tokens, b.tokens)
    assert torch.equal(a.condition.segments, b.condition.segments)
    assert a.tokens.shape != c.tokens.shape or not torch.equal(a.tokens, c.tokens)


def test_batches_hold_the_clips_tokens_texts_and_boundaries(dataset: AuthoredCorpus, trained: Path) -> None:
    corpus = TokenCorpus.build(dataset, trained / "tokenizer", "cpu")
    clip, tokens = dataset.split("train")[1], corpus.train[1].tokens
    batch = TokenBatches(corpus, batch=4, layout="exact", segmentation="uniform", seed=0).collate(
        corpus.train[:2], [0, 0]
    )
    saved = weights.load(trained / "tokenizer", "tokenizer")
    tokenizer = MotionTokenizer(saved.config_as(TokenizerConfig)).eval()
    saved.fill(tokenizer)
    expected = tokenizer.encode(torch.from_numpy(dataset.features(clip))[None])[:, 0]
    assert torch.equal(torch.from_numpy(tokens).long(), expected)
    assert torch.equal(batch.tokens[:, 1, : tokens.shape[1]], expected)
    assert batch.condition.lengths[1].tolist()[: len(clip.segments)] == [7] * (len(clip.segments) - 1) + [6]
    for clause, found in zip(clauses_at_once(clip.segments[0].text), batch.condition.segments[1, 0], strict=True):
        known = corpus.clauses.embeddings[corpus.clauses.row[clause]] if clause else np.zeros(384)
        assert np.array_equal(found.numpy(), known.astype(np.float32))
    shares = uniform_lengths(len(clip.segments), tokens.shape[1])
    assert batch.motion_segments[1].tolist()[: len(clip.segments)] == shares.tolist()
    uniform = TokenBatches(corpus, batch=4, layout="uniform", segmentation="exact", seed=0).collate(
        corpus.train[:2], [0, 0]
    )
    assert torch.equal(uniform.condition.lengths, batch.motion_segments)
    assert torch.equal(uniform.motion_segments, batch.condition.lengths)


def test_true_numbers_are_told_where_the_text_names_none(dataset: AuthoredCorpus, trained: Path) -> None:
    clip = dataset.clips[0]
    segment = replace(clip.segments[0], actions=(("wave", {"count": 4}),))
    texts = ("a person waves", "a person waves twice", "a person waves while walking")
    clip = replace(clip, segments=(segment,), captions=tuple(Caption(text, (text,)) for text in texts))
    told, counted = repetitions_of(clip)
    assert [row[0].tolist() for row in told] == [[0, 0], [2, 0], [0, 0]]
    assert [row[0].tolist() for row in counted] == [[4, 0], [2, 0], [0, 0]]


@pytest.mark.parametrize("alignment", ["none", "segment", "batch", "global", "token"])
@pytest.mark.parametrize("conditioning", ["sentence", "segments", "layout"])
def test_every_conditioning_and_alignment_can_be_trained(
    dataset: AuthoredCorpus, trained: Path, alignment: AlignmentKind, conditioning: ConditioningKind
) -> None:
    corpus = TokenCorpus.build(dataset, trained / "tokenizer", "cpu")
    config = replace(_TRANSFORMER, conditioning=conditioning)
    losses = MaskLosses(alignment, segmentation="uniform")
    if conditioning == "sentence" and alignment not in ("none", "global"):
        with pytest.raises(InvalidOption, match="knows none or global, found"):
            MaskObjective(corpus, config, _TRAINING, losses, seed=0)
        return
    objective = MaskObjective(corpus, config, _TRAINING, losses, seed=0)
    losses = objective.loss(0)
    assert ("alignment" in losses) == (alignment != "none")
    losses["loss"].backward()
    without = {
        name for name, values in objective.model.named_parameters() if values.grad is None and "alignment" not in name
    }
    assert not without


def test_tuning_begins_with_trained_weights(dataset: AuthoredCorpus, tmp_path: Path) -> None:
    trained, tuned, other = tmp_path / "trained", tmp_path / "tuned", tmp_path / "other"
    own = "segmo/tokenizer"
    assert tiny_job("tokenizer", dataset, trained, iterations=60).run()["finished"]
    assert tiny_job("mask", dataset, trained, iterations=1).run()["finished"]
    assert tiny_job("tokenizer", dataset, tuned, iterations=1, tune=trained).run()["finished"]
    assert float(curve(tuned / own)[0]["loss"]) < 0.6 * float(curve(trained / own)[0]["loss"])
    assert tiny_job("mask", dataset, tuned, iterations=1, tune=trained).run()["finished"]
    for stage in ("tokenizer", "mask"):
        before, after = (weights.load(folder / "segmo" / stage, stage) for folder in (trained, tuned))
        assert after.facts["tuned_from"] == before.digest
    assert tiny_job("tokenizer", dataset, other, iterations=1, seed=1).run()["finished"]
    with pytest.raises(InvalidOption, match="was trained with another tokenizer"):
        tiny_job("mask", dataset, other, iterations=1, tune=trained).run()


def test_texts_are_embedded_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table = text_table(tmp_path, ["a person waves", "a person bows", "a person waves"])
    assert table.embeddings.shape == (2, 384)
    monkeypatch.setattr("generator.text.encoder.TextEncoder", None)  # would fail if it were asked again
    again = text_table(tmp_path, ["a person bows", "a person waves"])
    assert np.array_equal(table.embeddings, again.embeddings)
    assert again.rows(["a person waves"]).tolist() == [again.row["a person waves"]]


def test_what_is_wrong_is_named(dataset: AuthoredCorpus, trained: Path, tmp_path: Path) -> None:
    with pytest.raises(NoWeights, match="no trained tokenizer; train it with"):
        TokenCorpus.build(dataset, tmp_path / "nothing" / "tokenizer", "cpu")
    with pytest.raises(InvalidOption, match="--resume: there is no checkpoint at"):
        tokenizer_run(dataset, tmp_path / "empty", Run(1, resume=True))
    with pytest.raises(InvalidOption, match="must be positive"):
        tokenizer_run(dataset, tmp_path / "none", Run(0))
    with pytest.raises(UnknownName, match="unknown device 'tpu'; did you mean cpu"):
        choose_device("tpu")
    checkpoint = tmp_path / "other" / loop.CHECKPOINT
    checkpoint.parent.mkdir()
    checkpoint.write_bytes((trained / "mask" / loop.CHECKPOINT).read_bytes())
    with pytest.raises(InvalidFile, match="is no checkpoint of this model and size"):
        tokenizer_run(dataset, checkpoint.parent, Run(1, resume=True))


def test_damaged_weights_are_named(trained: Path, tmp_path: Path) -> None:
    folder = tmp_path / "tokenizer"
    folder.mkdir()
    for name in (weights.WEIGHTS, weights.CONFIG):
        (folder / name).write_bytes((trained / "tokenizer" / name).read_bytes())
    with pytest.raises(NoWeights, match="do not fit their configuration"):
        weights.load(folder, "tokenizer").fill(MotionTokenizer(replace(_TOKENIZER, width=16)))
    (folder / weights.WEIGHTS).write_bytes(b"short")
    with pytest.raises(InvalidFile, match="not readable weights"):
        weights.load(folder, "tokenizer")
    (folder / weights.CONFIG).write_text("{}")
    with pytest.raises(InvalidFile, match="not a model's configuration"):
        weights.load(folder, "tokenizer")


def test_autocast_is_what_was_forced(bfloat16: str) -> None:
    product = torch.ones(2, 2)
    with loop.autocast("cpu"):
        assert (product @ product).dtype == {"on": torch.bfloat16, "off": torch.float32}[bfloat16]


def test_autocast_forced_to_something_else_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(loop.BF16, "yes")
    with pytest.raises(InvalidOption, match="RFS_BF16: expected on or off, found 'yes'"):
        loop.autocast("cpu")
