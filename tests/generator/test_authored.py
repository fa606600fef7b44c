"""Reading a corpus, its statistics, and the errors of a broken folder."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from generator.corpus.build import build_dataset
from generator.corpus.cli import DataShow
from generator.datasets.authored import AuthoredCorpus, clip_from_json, clip_to_json
from ros_free_stack.errors import InvalidFile, UnknownName


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("corpus") / "data"
    build_dataset(out, clips=8, seed=1, cmu=None, workers=1)
    return out


def test_statistics_are_those_of_the_training_clips_and_are_kept(folder: Path) -> None:
    data = AuthoredCorpus.open(folder)
    rows = np.concatenate([data.features(clip) for clip in data.split("train")]).astype(np.float64)
    assert np.allclose(data.mean, rows.mean(0), atol=1e-4)
    assert np.allclose(data.std, rows.std(0), atol=1e-4)
    kept = (folder / "statistics.npz").read_bytes()
    assert np.array_equal(AuthoredCorpus.open(folder).mean, data.mean)
    assert (folder / "statistics.npz").read_bytes() == kept


def test_a_clip_survives_its_line(folder: Path) -> None:
    for clip in AuthoredCorpus.open(folder).clips:
        assert clip_from_json(clip_to_json(clip)) == clip


def test_features_are_float32_rows_of_the_clip(folder: Path) -> None:
    data = AuthoredCorpus.open(folder)
    clip = data.clips[-1]
    features = data.features(clip)
    assert features.shape == (clip.length, 263)
    assert features.dtype == np.float32
    assert clip.segments[-1].end == clip.length


def test_unknown_names(folder: Path) -> None:
    data = AuthoredCorpus.open(folder)
    with pytest.raises(UnknownName, match="train"):
        data.split("training")
    with pytest.raises(UnknownName, match="000000"):
        data.clip("x")


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("manifest.json", None, "data build"),
        ("manifest.json", '{"version": 99}', "version 99"),
        ("manifest.json", "[]", "manifest"),
        ("clips.jsonl", "{}\n", "not a clip"),
        ("clips.jsonl", "", "names 0 rows"),
        ("features.npy", "x", "array"),
    ],
)
def test_broken_folders_are_named(folder: Path, tmp_path: Path, name: str, content: str | None, message: str) -> None:
    copy = tmp_path / "data"
    shutil.copytree(folder, copy)
    (copy / name).unlink()
    if content is not None:
        (copy / name).write_text(content)
    with pytest.raises(InvalidFile, match=message):
        AuthoredCorpus.open(copy)


def test_show_draws_a_clip_and_prints_its_words(
    folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    picture = tmp_path / "clip.png"
    assert DataShow(dataset=folder, clip="000002", out=picture, json=True).run() == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    shown = json.loads(capsys.readouterr().out)
    assert shown["id"] == "000002"
    assert shown["captions"][0]["text"]
