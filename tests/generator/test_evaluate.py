"""The command `evaluate` on a tiny corpus with models that were never trained, and the protocol behind it."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from generator.datasets.authored import AuthoredCorpus
from generator.evaluation.cli import Evaluate
from generator.evaluation.embedder import CorpusEmbedder
from generator.evaluation.evaluation import Generation
from generator.evaluation.pairs import corpus_pairs
from generator.evaluation.protocol import MotionSet, Score, score
from generator.evaluation.table import table
from generator.performer import Performer, PerformerSettings
from generator.postprocess.context import Context, whole_features
from generator.registry import SHARED
from ros_free_stack.errors import InvalidOption, NoWeights, UnknownName
from ros_free_stack.formats.features import decode
from tests.generator.tiny_dataset import write_tiny_dataset
from tests.generator.tiny_models import write_tiny_models


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_tiny_dataset(tmp_path_factory.mktemp("data") / "tiny", clips=48)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Weights of tiny models that were never trained."""
    return write_tiny_models(tmp_path_factory.mktemp("weights"), quantizers=2, width=16)


def command(data: Path, folder: Path, **options: object) -> Evaluate:
    chosen = Evaluate(weights=(folder,), dataset=data, evaluator=folder / SHARED / "evaluator", split="train", runs=3)
    return replace(chosen, **options)  # type: ignore[arg-type]


def test_the_command_measures_all_rows(
    data: Path, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "result.json"
    assert command(data, folder, multimodality=2, generations=2, clips=33, out=out).run() == 0
    printed = capsys.readouterr().out
    result = json.loads(out.read_text())
    assert list(result["rows"]) == ["real", "reconstruction", "first", "resampled"]
    assert result["clips"] == 33
    assert result["distinct_captions"] < 33
    real, reconstruction, first, resampled = result["rows"].values()
    assert real["fid"]["mean"] == pytest.approx(0, abs=1e-9)
    assert reconstruction["mpjpe_mm"]["mean"] > 0
    assert first["multimodality"]["mean"] > 0
    assert resampled["multimodality"]["mean"] > 0
    assert "multimodality" not in real
    assert 0 <= real["tc"]["mean"] <= 1
    for text in ("real", "MPJPE, mm", "MModality", f"wrote {out}", "33 clips"):
        assert text in printed


def test_the_same_seed_gives_the_same_numbers_and_json_is_all_that_is_printed(
    data: Path, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(seed: int) -> dict[str, object]:
        command(data, folder, rows="first", seed=seed, json=True).run()
        return json.loads(capsys.readouterr().out)

    first = run(3)
    assert first == run(3)
    assert first != run(4)


def test_several_folders_are_rows_named_after_them(
    data: Path, folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folders = [tmp_path / name for name in ("first", "second", "elsewhere/first")]
    for place in folders:
        place.parent.mkdir(exist_ok=True)
        place.symlink_to(folder)

    def rows(*chosen: Path) -> list[str]:
        assert command(data, folder, weights=chosen, rows="reconstruction", json=True).run() == 0
        return list(json.loads(capsys.readouterr().out)["rows"])

    assert rows(*folders[:2]) == ["reconstruction, first", "reconstruction, second"]
    assert rows(folders[0], folders[2]) == [f"reconstruction, {folders[0]}", f"reconstruction, {folders[2]}"]


def test_generated_motions_are_as_long_as_the_real_ones_and_differ_by_their_place(data: Path, folder: Path) -> None:
    pairs = corpus_pairs(AuthoredCorpus.open(data), "train", clips=None, seed=0)
    for resampled in (False, True):
        generation = Generation(Performer.load(folder), pairs, resampled=resampled)
        motions = generation.motions(range(len(pairs)), seed=0, title="")
        assert [len(features) for features in motions] == [pair.frames for pair in pairs]
        again = generation.motions([5, 5], seed=0, title="")
        assert len(again[0]) == pairs[5].frames
        assert not np.array_equal(again[0], again[1])


def test_resampled_motions_are_those_that_the_performer_makes(data: Path, folder: Path) -> None:
    """The same text, timing and noise: what is measured is what `generate` writes, read back from its joints."""
    pair = corpus_pairs(AuthoredCorpus.open(data), "train", clips=None, seed=0)[3]
    performer = Performer.load(folder)
    (measured,) = Generation(performer, [pair], resampled=True).motions([0], seed=7, title="")
    (features,) = performer.around(
        pair.text,
        pair.segments,
        [performer.shares(pair.segments, pair.frames)],
        Context.none(),
        PerformerSettings(),
        performer.noise(7),
    )
    written, _ = Context.none().stitched(features, foot_lock=True)
    np.testing.assert_allclose(decode(measured), decode(whole_features(written)), atol=1e-4)


def test_clips_and_captions_follow_the_seed(data: Path) -> None:
    dataset = AuthoredCorpus.open(data)
    first, second, other = (corpus_pairs(dataset, "train", clips=32, seed=seed) for seed in (0, 0, 1))
    assert [pair.text for pair in first] == [pair.text for pair in second]
    assert [pair.text for pair in first] != [pair.text for pair in other]
    assert all(pair.frames % 4 == 0 for pair in first)


def test_the_score_of_a_row_is_the_mean_and_interval_over_runs() -> None:
    found = Score.of([1.0, 2.0, 3.0, 4.0])
    assert found.mean == 2.5
    assert found.interval == pytest.approx(1.96 * np.sqrt(1.25) / 2)
    text = 10.0 * np.arange(64)[:, None] * np.ones(3)
    good = MotionSet(text + 0.1, {"tc": np.full(64, 0.5)})
    bad = MotionSet(text[::-1] + 0.1, {"tc": np.full(64, 0.1)})
    scores = score(text, good, [good, bad], runs=4, seed=0)
    assert scores["top1"].mean == pytest.approx(0.5, abs=0.05)
    assert scores["tc"].mean == pytest.approx(0.3)
    assert scores["tc"].interval == pytest.approx(1.96 * 0.2 / 2)
    assert score(text, good, [good], runs=2, seed=0)["top1"] == Score(1.0, 0.0)


def test_the_table_leaves_out_what_no_row_has() -> None:
    drawn = table({"real": {"top1": Score(0.5, 0.01)}, "generated": {}}, "clips")
    assert "0.500 ±0.010" in drawn
    assert "FID" not in drawn


def test_an_embedding_does_not_depend_on_the_order(data: Path, folder: Path) -> None:
    pairs = corpus_pairs(AuthoredCorpus.open(data), "train", clips=None, seed=0)
    embedder = CorpusEmbedder.load(folder / SHARED / "evaluator")
    there = embedder.motions([pair.features for pair in pairs])
    back = embedder.motions([pair.features for pair in pairs[::-1]])
    assert np.allclose(there, back[::-1], atol=1e-5)
    assert np.allclose(embedder.texts(pairs), embedder.texts(pairs[::-1])[::-1], atol=1e-5)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"clips": 8}, InvalidOption, "at least 32 clips are needed"),
        ({"split": "val"}, InvalidOption, "--split: has 12 clips"),
        ({"runs": 0}, InvalidOption, "--runs: must be at least 1, found 0"),
        ({"rows": "real,fake"}, UnknownName, "unknown row 'fake'; valid: first, real, reconstruction, resampled"),
        ({"dataset": None}, InvalidOption, "give one of them"),
        ({"multimodality": 999}, InvalidOption, "there are 36 texts, found 999"),
        (
            {"evaluator": Path("nowhere")},
            NoWeights,
            "no trained evaluator; train it with `python launch.py train evaluator --dataset",
        ),
    ],
)
def test_what_is_wrong_is_named(
    data: Path, folder: Path, options: dict[str, object], error: type[Exception], words: str
) -> None:
    with pytest.raises(error, match=words):
        command(data, folder, **options).run()
