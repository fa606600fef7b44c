"""The corpus on disk: the same bytes whatever the number of workers, whole or not at all, split by order."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from generator.corpus import build
from generator.corpus.build import build_dataset, clip_split, describe, make_mirrored_pair, pair_split
from generator.corpus.mirror import mirror_joints, mirror_words
from generator.corpus.words import VOCABULARY
from generator.datasets.authored import AuthoredCorpus
from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats.features import decode


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("corpus") / "data"
    build_dataset(out, clips=12, seed=3, cmu=None, workers=1)
    return out


def test_workers_do_not_change_the_bytes(folder: Path, tmp_path: Path) -> None:
    other = tmp_path / "data"
    build_dataset(other, clips=12, seed=3, cmu=None, workers=2)
    for name in ("features.npy", "clips.jsonl", "manifest.json"):
        assert (other / name).read_bytes() == (folder / name).read_bytes()


def test_each_clip_is_where_the_index_says(folder: Path) -> None:
    data = AuthoredCorpus.open(folder)
    assert data.manifest["clips"] == len(data.clips) == 12
    for index in (0, 7):
        made = make_mirrored_pair(3, index // 2)[index % 2]
        assert np.array_equal(data.features(data.clips[index]), made.rows.astype(np.float32))
        assert data.clips[index].captions == made.clip.captions
    assert describe(data.manifest).startswith("12 clips")


def test_every_second_clip_is_the_reflection_of_the_one_before(folder: Path) -> None:
    data = AuthoredCorpus.open(folder)
    for clip, mirrored in zip(data.clips[::2], data.clips[1::2], strict=True):
        joints = mirror_joints(decode(data.features(clip)))
        np.testing.assert_allclose(decode(data.features(mirrored)), joints, atol=1e-9)
        assert mirrored.split == clip.split
        assert [mirror_words(caption.text) for caption in clip.captions] == [c.text for c in mirrored.captions]
        for segment, other in zip(clip.segments, mirrored.segments, strict=True):
            assert mirror_words(segment.text) == other.text
            sides = [str(params.get("side")) for _, params in segment.actions]
            opposite = {"left": "right", "right": "left"}
            assert [str(params.get("side")) for _, params in other.actions] == [opposite.get(s, s) for s in sides]


def test_about_an_eighth_of_the_ordered_pairs_is_held_out() -> None:
    splits = [pair_split(a, b) for a in VOCABULARY for b in VOCABULARY if a != b]
    assert 0.06 < splits.count("test") / len(splits) < 0.10
    assert 0.03 < splits.count("val") / len(splits) < 0.05


def test_no_training_clip_shows_a_held_out_order(folder: Path) -> None:
    held = next((a, b) for a in VOCABULARY for b in VOCABULARY if pair_split(a, b) == "test")
    assert clip_split(("wave", *held), 0.9) == "test"
    assert clip_split(("wave",), 0.0) == "test"
    assert clip_split(("wave",), 0.9) == "train"
    for clip in AuthoredCorpus.open(folder).split("train"):
        names = ["+".join(name for name, _ in segment.actions) for segment in clip.segments]
        assert all(pair_split(a, b) == "train" for a, b in pairwise(names))


def test_bad_options_are_refused(tmp_path: Path, folder: Path) -> None:
    with pytest.raises(InvalidOption, match="--clips"):
        build_dataset(tmp_path / "x", clips=0, seed=0, cmu=None, workers=1)
    with pytest.raises(InvalidOption, match="--workers"):
        build_dataset(tmp_path / "x", clips=1, seed=0, cmu=None, workers=0)
    with pytest.raises(InvalidFile, match="exists"):
        build_dataset(folder, clips=1, seed=0, cmu=None, workers=1)
    with pytest.raises(InvalidFile, match="index"):
        build_dataset(tmp_path / "x", clips=1, seed=0, cmu=tmp_path, workers=1)


def test_a_build_that_fails_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise OSError("no space left on device")

    monkeypatch.setattr(build, "make_mirrored_pair", fail)
    with pytest.raises(OSError, match="no space"):
        build_dataset(tmp_path / "data", clips=2, seed=0, cmu=None, workers=1)
    assert list(tmp_path.iterdir()) == []
