"""HumanML3D and KIT-ML folders as a data set: whole motions and the excerpts that single captions are about.

By T2M's rules: motions are left out that are shorter than 40 (KIT-ML: 24) frames or have 200 and more; a caption that
is about a time span makes a clip of its own. Nobody labelled segments: each caption is split by its text alone.
"""

import hashlib
import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np

from generator.datasets.cache import cache_path
from generator.datasets.dataset import SPLITS, Caption, Clip, of_split
from generator.datasets.layout import LAYOUTS, Layout
from generator.datasets.statistics import measured
from ros_free_stack.console import progress, say
from ros_free_stack.errors import InvalidFile, InvalidPrompt
from ros_free_stack.files import write_json
from ros_free_stack.formats.humanml3d import PublishedDataset, TaggedCaption, open_published

TOO_LONG: Final = 200
"""Motions of this many frames or more are left out."""
SEGMENTS_VERSION: Final = 1
"""Of the splitter's rules; another one lets every data set be split anew."""

Splits = Callable[[str], tuple[str, ...]]
"""A sentence to its segment texts."""


@dataclass(frozen=True)
class PublishedMotions:
    """A published data set; make one with `PublishedMotions.open`."""

    data: PublishedDataset
    layout: Layout
    clips: tuple[Clip, ...]

    @classmethod
    def open(cls, folder: Path, *, split: str | None = None, segments: bool = True) -> "PublishedMotions":
        """Open a folder with `new_joint_vecs/`, `texts/`, `train.txt` and, as far as they are there, the other lists.

        Args:
            split: read only this one.
            segments: split the captions, which takes minutes the first time; otherwise each is its one segment.

        Raises:
            InvalidFile: a part is missing or malformed.
        """
        layout = _layout(folder)
        data = open_published(folder, layout.skeleton)
        found = [clip for name in ((split,) if split else SPLITS) for clip in _clips(data, layout, name, split)]
        if not found:
            raise InvalidFile(folder, f"has no motion of {layout.least_frames} to {TOO_LONG - 1} frames with captions")
        texts = {caption.text for clip in found for caption in clip.captions}
        known = _segments(folder, sorted(texts)) if segments else {text: (text,) for text in texts}
        return cls(data, layout, tuple(_with_segments(clip, known) for clip in found))

    @property
    def path(self) -> Path:
        """Its folder."""
        return self.data.folder

    def features(self, clip: Clip) -> np.ndarray:
        """(length, F) float32 features of a clip, not standardised."""
        name = clip.id.partition("@")[0]
        found = _read(self.data, name)[clip.start : clip.start + clip.length].astype(np.float32)
        if not np.isfinite(found).all():
            raise InvalidFile(self.path / "new_joint_vecs" / f"{name}.npy", "holds values that are not finite")
        return found

    def split(self, name: str) -> tuple[Clip, ...]:
        """The clips of "train", "val" or "test"."""
        return of_split(self.clips, name)

    @property
    def mean(self) -> np.ndarray:
        """(F,) float32 mean of each feature: the published one, or that of the training clips."""
        return self._statistics[0]

    @property
    def std(self) -> np.ndarray:
        """(F,) float32 standard deviation of each feature, likewise."""
        return self._statistics[1]

    @cached_property
    def _statistics(self) -> tuple[np.ndarray, np.ndarray]:
        if (self.path / "Mean.npy").is_file():
            mean, std = self.data.statistics()
            return mean.astype(np.float32), std.astype(np.float32)
        training = self.split("train")
        if not training:
            raise InvalidFile(self.path, "has no training clips")
        return measured(lambda: (self.features(clip) for clip in training))


def _layout(folder: Path) -> Layout:
    """The layout that the folder's features have."""
    for path in sorted((folder / "new_joint_vecs").glob("*.npy")):
        try:
            width = np.load(path, mmap_mode="r", allow_pickle=False).shape[-1]
        except (OSError, ValueError, EOFError, IndexError) as error:
            raise InvalidFile(path, f"not a readable .npy ({error})") from None
        if width not in LAYOUTS:
            valid = " or ".join(f"{known} ({item.name})" for known, item in LAYOUTS.items())
            raise InvalidFile(path, f"has {width} features a frame, expected {valid}")
        return LAYOUTS[width]
    raise InvalidFile(folder / "new_joint_vecs", "holds no .npy")


def _clips(data: PublishedDataset, layout: Layout, split: str, wanted: str | None) -> Iterator[Clip]:
    """Clips of a split, without segments; of a split whose list is missing none, unless it is wanted."""
    if wanted is None and not (data.folder / f"{split}.txt").is_file():
        return
    for name in data.split(split):
        if not (data.folder / "new_joint_vecs" / f"{name}.npy").is_file():
            continue  # the published lists name a few clips that the published features lack
        frames = len(_read(data, name))
        if not layout.least_frames <= frames < TOO_LONG:
            continue
        whole: list[TaggedCaption] = []
        for number, caption in enumerate(data.captions(name)):
            if caption.start_s == 0 and caption.end_s is None:
                whole.append(caption)
                continue
            first = int(caption.start_s * layout.fps)
            last = frames if caption.end_s is None else min(frames, int(caption.end_s * layout.fps))
            if layout.least_frames <= last - first < TOO_LONG:
                yield _clip(f"{name}@{number}", split, first, last - first, layout, [caption])
        if whole:
            yield _clip(name, split, 0, frames, layout, whole)


def _clip(name: str, split: str, start: int, length: int, layout: Layout, captions: list[TaggedCaption]) -> Clip:
    told = tuple(Caption(caption.text, (), caption.tokens) for caption in captions)
    return Clip(name, split, start, length, layout.name, 1.0, (), told)


def _with_segments(clip: Clip, known: dict[str, tuple[str, ...]]) -> Clip:
    captions = tuple(Caption(caption.text, known[caption.text], caption.tokens) for caption in clip.captions)
    return Clip(clip.id, clip.split, clip.start, clip.length, clip.source, clip.weight, (), captions)


def _read(data: PublishedDataset, name: str) -> np.ndarray:
    """(T, F) features of a motion, memory-mapped: nothing is read but what is used."""
    path = data.folder / "new_joint_vecs" / f"{name}.npy"
    try:
        values = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise InvalidFile(path, f"not a readable .npy ({error})") from None
    width = data.skeleton.width
    if values.ndim != 2 or values.shape[1] != width or not np.issubdtype(values.dtype, np.floating):
        raise InvalidFile(path, f"expected floats of shape (T, {width}), found {values.dtype} {values.shape}")
    return values


def _segments(folder: Path, texts: list[str]) -> dict[str, tuple[str, ...]]:
    """Segment texts of each sentence, or read from the folder where the very same sentences were split before."""
    digest = hashlib.sha256(json.dumps([SEGMENTS_VERSION, texts]).encode()).hexdigest()[:16]
    path = cache_path(folder, f"segments-{digest}.json")
    if path.is_file():
        try:
            kept = json.loads(path.read_text(encoding="utf-8"))
            return {text: tuple(kept[text]) for text in texts}
        except (ValueError, KeyError, TypeError):
            say(f"{path}: damaged; the captions are split again")
    split = sentence_splitter()
    found = {text: split(text) for text in progress(texts, "splitting captions", total=len(texts))}
    write_json(path, {text: list(segments) for text, segments in found.items()})
    return found


def sentence_splitter() -> Splits:
    """A sentence to its segments; one that the splitter refuses is its own and only segment."""
    from generator.text.splitter import Splitter

    splitter = Splitter()

    def split(text: str) -> tuple[str, ...]:
        try:
            return splitter.split(text)
        except InvalidPrompt:
            return (text,)

    return split
