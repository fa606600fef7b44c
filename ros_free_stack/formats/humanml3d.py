"""HumanML3D as published (Guo et al., CVPR 2022), and the folder layout that it shares with KIT-ML.

FOLDER/new_joint_vecs/ID.npy    (T, 263) features of `ros_free_stack.formats.features`
FOLDER/new_joints/ID.npy        (T, 22, 3) joints, y up, z forward
FOLDER/texts/ID.txt             one caption a line: caption#word/TAG word/TAG ...#start_s#end_s
FOLDER/{train,val,test}.txt     one ID a line; IDs that begin with M are mirrored clips
FOLDER/{Mean,Std}.npy           (263,) statistics of the features
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.formats.features import HUMANML3D, Skeleton, decode
from ros_free_stack.formats.frames import from_y_up
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.formats.stature import TALL_M, stature
from ros_free_stack.skeleton import FPS

Floats = NDArray[np.float64]

SPLITS = ("train", "val", "test")


@dataclass(frozen=True)
class TaggedCaption:
    """One caption: its text, its words with their parts of speech, and the time span it is about.

    `end_s` is None where the caption is about the whole clip.
    """

    text: str
    tokens: tuple[tuple[str, str], ...]
    start_s: float
    end_s: float | None


@dataclass(frozen=True)
class PublishedDataset:
    """A data set folder in the published layout."""

    folder: Path
    skeleton: Skeleton

    def split(self, name: str) -> tuple[str, ...]:
        """IDs of the clips of a split: train, val or test."""
        if name not in SPLITS:
            raise UnknownName("split", name, SPLITS)
        return tuple(_lines(self.folder / f"{name}.txt"))

    def captions(self, clip: str) -> tuple[TaggedCaption, ...]:
        """Captions of a clip; InvalidFile names the line that is not one."""
        path = self.folder / "texts" / f"{clip}.txt"
        captions = tuple(_caption(path, number, line) for number, line in enumerate(_lines(path), start=1))
        if not captions:
            raise InvalidFile(path, "no captions")
        return captions

    def features(self, clip: str) -> Floats:
        """(T, F) features of a clip."""
        return _array(self.folder / "new_joint_vecs" / f"{clip}.npy", (None, self.skeleton.width))

    def joints(self, clip: str) -> Floats:
        """(T, J, 3) joints of a clip in the file's unit and rate, turned to z up and x forward."""
        return from_y_up(_array(self.folder / "new_joints" / f"{clip}.npy", (None, len(self.skeleton.joints), 3)))

    def statistics(self) -> tuple[Floats, Floats]:
        """Mean and standard deviation of the features, (F,) each."""
        shape = (self.skeleton.width,)
        return _array(self.folder / "Mean.npy", shape), _array(self.folder / "Std.npy", shape)


def open_humanml3d(folder: Path) -> PublishedDataset:
    """The data set in a folder: 22 joints in m, 263 features, 20 fps.

    Raises:
        InvalidFile: the folder lacks a part of the layout.
    """
    return open_published(folder, HUMANML3D)


def open_published(folder: Path, skeleton: Skeleton) -> PublishedDataset:
    """A folder in the published layout, checked for its parts."""
    for part in ("new_joint_vecs", "texts", "train.txt"):
        if not (folder / part).exists():
            raise InvalidFile(folder / part, "missing; expected new_joint_vecs/, texts/, train.txt and more")
    return PublishedDataset(folder, skeleton)


def read_features(path: Path, options: SourceOptions) -> Source:
    """The human motion in a `.npy` of (T, 263) features that are not standardised, 20 fps."""
    joints = decode(_array(path, (None, HUMANML3D.width)))
    if not TALL_M[0] <= (tall := stature(joints)) <= TALL_M[1]:
        raise InvalidFile(path, f"the person is {tall:.3g} m tall; are the features standardised?")
    habits = Habits(title="HumanML3D feature", up="z", units="m", fps=FPS, stood=True)
    return person_source(path, joints, options, habits, fps=None)


def _lines(path: Path) -> list[str]:
    try:
        return [line.strip() for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise InvalidFile(path, f"is not UTF-8 text ({error.reason} at byte {error.start})") from None


def _caption(path: Path, number: int, line: str) -> TaggedCaption:
    try:
        text, tokens, start, end = line.split("#")
        times = [0.0 if np.isnan(float(time)) else float(time) for time in (start, end)]
    except ValueError:
        raise InvalidFile(path, f"line {number}: expected caption#tokens#start#end, found {line[:60]!r}") from None
    if not 0 <= times[0] <= times[1]:
        raise InvalidFile(path, f"line {number}: time span {start} to {end}")
    pairs = (token.rpartition("/") for token in tokens.split())
    return TaggedCaption(
        text=text,
        tokens=tuple((word, tag) for word, _, tag in pairs),
        start_s=times[0],
        end_s=times[1] if times[1] > 0 else None,
    )


def _array(path: Path, shape: tuple[int | None, ...]) -> Floats:
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    try:
        values: NDArray[Any] = np.load(path, allow_pickle=False)
    except (ValueError, OSError, EOFError) as error:
        raise InvalidFile(path, f"not a readable .npy ({error})") from None
    expected = ", ".join("T" if size is None else str(size) for size in shape)
    fits = values.ndim == len(shape) and all(
        size is None or size == found for size, found in zip(shape, values.shape, strict=True)
    )
    if not fits or not np.issubdtype(values.dtype, np.floating) or not len(values):
        raise InvalidFile(path, f"expected floats of shape ({expected}), found {values.dtype} {values.shape}")
    if not np.isfinite(values).all():
        raise InvalidFile(path, f"a value that is not finite at row {int(np.argwhere(~np.isfinite(values))[0, 0])}")
    return values.astype(np.float64)
