"""Segmentation of all clips of a data set; what has to be searched for is searched once and kept in its folder."""

import hashlib
from typing import Final

import numpy as np

from generator.config import MAX_SEGMENTS, SegmentationKind
from generator.data.dataset import Clip, MotionDataset
from generator.models.segmo import segmentation
from generator.models.segmo.config import TOKEN_FRAMES
from generator.timing import segment_lengths, uniform_lengths
from ros_free_stack.console import progress
from ros_free_stack.files import atomic_path

VERSION: Final = 1
"""Of the methods; another one lets every data set be searched anew."""


def segmentation_table(dataset: MotionDataset, kind: SegmentationKind) -> np.ndarray:
    """(N, 5) int64 tokens of each segment of all clips, 0 beyond a clip's segments."""
    if kind == "exact":
        return _table([
            segment_lengths([(segment.start, segment.end) for segment in clip.segments], _tokens(clip), TOKEN_FRAMES)
            for clip in dataset.clips
        ])  # fmt: skip
    if kind == "uniform":
        return _table([uniform_lengths(len(clip.segments), _tokens(clip)) for clip in dataset.clips])
    path = dataset.path / f"segmentation-{kind}-{_digest(dataset)}.npy"
    if not path.is_file():
        with atomic_path(path) as temporary:
            np.save(temporary, _search(dataset, kind).astype(np.uint8))
    return np.load(path).astype(np.int64)


def _search(dataset: MotionDataset, kind: SegmentationKind) -> np.ndarray:
    method = segmentation.METHODS[kind]
    rows = []
    for clip in progress(dataset.clips, f"segmenting by {kind}", total=len(dataset.clips)):
        count = len(clip.segments)
        if count == 1:
            rows.append(np.array([_tokens(clip)]))
            continue
        standardised = (dataset.features(clip) - dataset.mean) / np.maximum(dataset.std, 1e-3)
        rows.append(method(segmentation.pose_signal(standardised), count))
    return _table(rows)


def _table(rows: list[np.ndarray]) -> np.ndarray:
    table = np.zeros((len(rows), MAX_SEGMENTS), dtype=np.int64)
    for place, row in zip(table, rows, strict=True):
        place[: len(row)] = row
    return table


def _tokens(clip: Clip) -> int:
    return clip.length // TOKEN_FRAMES


def _digest(dataset: MotionDataset) -> str:
    """Of what a segmentation depends on: the methods, the clips and, by their statistics, the features."""
    described = [(clip.start, clip.length, len(clip.segments)) for clip in dataset.clips]
    content = repr((VERSION, described)).encode() + dataset.mean.tobytes() + dataset.std.tobytes()
    return hashlib.sha256(content).hexdigest()[:16]
