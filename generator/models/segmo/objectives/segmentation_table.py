"""Segmentation of all clips of a data set; what has to be searched for is searched once and kept in its folder."""

import hashlib
from typing import Final

import numpy as np

from generator.config import MAX_SEGMENTS, SegmentationKind
from generator.datasets.cache import cache_path
from generator.datasets.dataset import Clip, MotionDataset
from generator.models.segmo import segmentation
from generator.models.segmo.config import TOKEN_FRAMES
from generator.timing import segment_lengths, uniform_lengths
from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidOption
from ros_free_stack.files import atomic_path

VERSION: Final = 2
"""Of the methods; another one lets every data set be searched anew."""


def segmentation_table(dataset: MotionDataset, kind: SegmentationKind) -> np.ndarray:
    """(N, 5, 5) int64 tokens of each segment of all clips: [i, A - 1] of clip i cut into A segments.

    Rows are zero beyond their segments, and where none of the clip's captions has so many.

    Raises:
        InvalidOption: "exact" boundaries of a data set whose segments nobody labelled.
    """
    if kind == "exact" and not all(clip.segments for clip in dataset.clips):
        raise InvalidOption(
            "segmentation / layout",
            f"exact boundaries are not labelled in {dataset.path}; take uniform, for example with "
            "--preset segmo-published",
        )
    if kind in ("exact", "uniform"):
        return _table(dataset, kind)
    path = cache_path(dataset.path, f"segmentation-{kind}-{_digest(dataset)}.npy")
    if not path.is_file():
        with atomic_path(path) as temporary:
            np.save(temporary, _table(dataset, kind).astype(np.uint8))
    return np.load(path).astype(np.int64)


def first_captions(dataset: MotionDataset, table: np.ndarray) -> np.ndarray:
    """(N, 5) rows of a table for the first caption of each clip."""
    counts = np.array([len(clip.captions[0].segments) for clip in dataset.clips])
    return table[np.arange(len(counts)), counts - 1]


def _table(dataset: MotionDataset, kind: SegmentationKind) -> np.ndarray:
    table = np.zeros((len(dataset.clips), MAX_SEGMENTS, MAX_SEGMENTS), dtype=np.int64)
    searched = kind in segmentation.METHODS
    clips = progress(dataset.clips, f"segmenting by {kind}", total=len(table)) if searched else dataset.clips
    for place, clip in zip(table, clips, strict=True):
        for count in {len(caption.segments) for caption in clip.captions}:
            place[count - 1, :count] = _lengths(dataset, clip, count, kind)
    return table


def _lengths(dataset: MotionDataset, clip: Clip, count: int, kind: SegmentationKind) -> np.ndarray:
    """(A,) tokens of each of so many segments of a clip."""
    tokens = clip.length // TOKEN_FRAMES
    if kind == "exact":
        return segment_lengths([(segment.start, segment.end) for segment in clip.segments], tokens, TOKEN_FRAMES)
    if kind == "uniform" or count == 1:
        return uniform_lengths(count, tokens)
    standardised = (dataset.features(clip) - dataset.mean) / np.maximum(dataset.std, 1e-3)
    return segmentation.METHODS[kind](segmentation.pose_signal(standardised), count)


def _digest(dataset: MotionDataset) -> str:
    """Of what a segmentation depends on: the methods, the clips and, by their statistics, the features."""
    described = [
        (clip.id, clip.start, clip.length, sorted({len(caption.segments) for caption in clip.captions}))
        for clip in dataset.clips
    ]
    content = repr((VERSION, described)).encode() + dataset.mean.tobytes() + dataset.std.tobytes()
    return hashlib.sha256(content).hexdigest()[:16]
