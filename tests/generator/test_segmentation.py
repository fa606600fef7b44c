"""Cutting motions into segments: known change points, contiguity, the cache, the measures of a cut."""

from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.config import SegmentationKind
from generator.datasets.authored import AuthoredCorpus
from generator.models.segmo import segmentation
from generator.models.segmo.config import TOKEN_FRAMES
from generator.models.segmo.objectives.segmentation_table import first_captions, segmentation_table
from generator.models.segmo.segmentation import METHODS, boundary_errors, boundary_iou, clusters, pose_signal
from tests.generator.tiny_dataset import write_tiny_dataset


def steps(*lengths: int, seed: int = 0) -> np.ndarray:
    """A signal that jumps to another level at each segment."""
    rng = np.random.default_rng(seed)
    levels = [np.tile(rng.normal(scale=3, size=6), (length, 1)) for length in lengths]
    return np.concatenate(levels) + 0.1 * rng.normal(size=(sum(lengths), 6))


@pytest.mark.parametrize("method", METHODS.values())
@pytest.mark.parametrize("lengths", [[7, 13], [12, 5, 9], [3, 9, 4, 11], [8, 8, 8, 8, 8]])
def test_clear_steps_are_found(method, lengths: list[int]) -> None:
    assert method(steps(*lengths), len(lengths)).tolist() == lengths


@settings(max_examples=40, deadline=None)
@given(data=st.data(), count=st.integers(2, 5))
def test_any_signal_is_cut_into_as_many_segments_as_asked(data: st.DataObject, count: int) -> None:
    tokens = data.draw(st.integers(count, 49))
    signal = np.random.default_rng(data.draw(st.integers(0, 99))).normal(size=(tokens, 4)).cumsum(0)
    if data.draw(st.booleans()):
        signal = signal.round() * 0  # a motion that stands still
    for method in METHODS.values():
        found = method(signal, count)
        assert len(found) == count
        assert found.min() >= 1
        assert found.sum() == tokens


def test_contiguous_segments_agree_with_most_labels() -> None:
    rng = np.random.default_rng(0)
    for _ in range(20):
        label = rng.integers(3, size=9)
        found = np.cumsum(segmentation._contiguous(label, np.array([2, 0, 1])))

        def agreeing(first: int, second: int, label: np.ndarray = label) -> int:
            return int((label[:first] == 2).sum() + (label[first:second] == 0).sum() + (label[second:] == 1).sum())

        best = max(agreeing(a, b) for a, b in product(range(1, 9), repeat=2) if a < b)
        assert agreeing(found[0], found[1]) == best


def test_a_cluster_that_returns_is_made_contiguous() -> None:
    signal = np.array([0.0] * 6 + [5.0] * 6 + [0.0] * 2)[:, None]
    assert clusters(signal, 2).tolist() == [6, 8]


def test_signal_is_the_mean_of_four_frames() -> None:
    frames = np.random.default_rng(0).normal(size=(18, 263)).astype(np.float32)
    signal = pose_signal(frames)
    assert signal.shape == (4, 67)
    np.testing.assert_allclose(signal[1], frames[4:8, :67].mean(0), rtol=1e-5)


@pytest.mark.parametrize("kind", ["uniform", "exact", "change-point", "clustering"])
def test_table_covers_every_clip(tmp_path: Path, kind: SegmentationKind) -> None:
    dataset = AuthoredCorpus.open(write_tiny_dataset(tmp_path / "tiny"))
    table = segmentation_table(dataset, kind)
    for clip, row in zip(dataset.clips, first_captions(dataset, table), strict=True):
        assert (row > 0).sum() == len(clip.segments)
        assert row.sum() == clip.length // TOKEN_FRAMES
    assert np.array_equal(segmentation_table(dataset, kind), table)


def test_searched_segmentations_are_searched_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    dataset = AuthoredCorpus.open(write_tiny_dataset(tmp_path / "tiny"))
    table = segmentation_table(dataset, "clustering")
    monkeypatch.setattr(segmentation, "METHODS", {})  # would fail if it were searched again
    assert np.array_equal(segmentation_table(dataset, "clustering"), table)
    other = AuthoredCorpus.open(write_tiny_dataset(tmp_path / "other", seed=1))
    with pytest.raises(KeyError):
        segmentation_table(other, "clustering")


def test_measures_of_a_cut() -> None:
    found, true = np.array([[4, 6, 0], [5, 3, 2]]), np.array([[6, 4, 0], [5, 2, 3]])
    np.testing.assert_allclose(boundary_iou(found, true), [[4 / 6, 4 / 6, 0], [1, 2 / 3, 2 / 3]])
    assert boundary_errors(found, true).tolist() == [2, 0, 1]
    assert boundary_iou(true, true)[true > 0].min() == 1
