"""What every data set is: clips of features with captions in segments."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Protocol

import numpy as np

from generator.datasets.layout import Layout
from ros_free_stack.errors import UnknownName

SPLITS: Final = ("train", "val", "test")


@dataclass(frozen=True)
class Caption:
    """One sentence for a clip, with the texts of the clip's segments as this sentence words them.

    `tokens` are (word, part of speech) where the data set was published with them.
    """

    text: str
    segments: tuple[str, ...]
    tokens: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True)
class LabelledSegment:
    """One segment of a clip.

    Attributes:
        text: "a person " and the third person of what is done.
        start, end: frames; the segments of a clip tile it.
        arms, legs: what these parts do.
        actions: names and parameters of the one or two actions.
    """

    text: str
    start: int
    end: int
    arms: str
    legs: str
    actions: tuple[tuple[str, dict[str, Any]], ...]


@dataclass(frozen=True)
class Clip:
    """One motion with its texts.

    Attributes:
        id: its name in the data set.
        split: "train", "val" or "test".
        start, length: its rows in the features it lies in.
        source: "authored", "cmu", "mixed", or the name of a published data set.
        weight: how often to draw it in training, relative to the others.
        segments: what happens when, tiling the clip; empty where nobody labelled it.
        captions: sentences, each with its own wording of the segments, or with segments of its own where none are
            labelled.
    """

    id: str
    split: str
    start: int
    length: int
    source: str
    weight: float
    segments: tuple[LabelledSegment, ...]
    captions: tuple[Caption, ...]


class MotionDataset(Protocol):
    """Clips with features of one layout."""

    @property
    def path(self) -> Path:
        """Its folder."""
        ...

    @property
    def layout(self) -> Layout:
        """Feature width, frames a second, skeleton."""
        ...

    @property
    def clips(self) -> tuple[Clip, ...]:
        """All of them."""
        ...

    @property
    def mean(self) -> np.ndarray:
        """(F,) float32 mean of each feature over the training clips."""
        ...

    @property
    def std(self) -> np.ndarray:
        """(F,) float32 standard deviation of each feature over the training clips."""
        ...

    def features(self, clip: Clip) -> np.ndarray:
        """(length, F) float32 features of a clip, not standardised."""
        ...

    def split(self, name: str) -> tuple[Clip, ...]:
        """The clips of "train", "val" or "test"."""
        ...


def of_split(clips: tuple[Clip, ...], name: str) -> tuple[Clip, ...]:
    """The clips of a split, or UnknownName."""
    if name not in SPLITS:
        raise UnknownName("split", name, SPLITS)
    return tuple(clip for clip in clips if clip.split == name)
