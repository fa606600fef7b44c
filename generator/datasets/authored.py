"""Reading the corpus: clips with their features, memory-mapped.

A folder holds `features.npy` (float16, (N, 263), all clips one after the other), `clips.jsonl` (one clip a line),
`manifest.json`, and, once it was asked for, `statistics.npz` (mean and standard deviation of the training clips).
"""

import json
import zipfile
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Final

import numpy as np

from generator.datasets.dataset import Caption, Clip, LabelledSegment, of_split
from generator.datasets.layout import HUMAN, Layout
from generator.datasets.statistics import measured
from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.files import atomic_path
from ros_free_stack.formats.features import CHANNELS

VERSION: Final = 1
MANIFEST: Final = "manifest.json"
_BLOCK = 65536


@dataclass(frozen=True)
class AuthoredCorpus:
    """A corpus on disk; see `AuthoredCorpus.open`."""

    path: Path
    clips: tuple[Clip, ...]
    rows: np.ndarray
    manifest: dict[str, Any]

    @classmethod
    def open(cls, path: Path) -> "AuthoredCorpus":
        """Open a folder written by `data build`.

        Raises:
            InvalidFile: something is missing, of another version, or does not fit together.
        """
        manifest = _read_manifest(path / MANIFEST)
        rows = _read_rows(path / "features.npy")
        clips = _read_clips(path / "clips.jsonl")
        named = sum(clip.length for clip in clips)
        if named != len(rows):
            raise InvalidFile(path, f"clips.jsonl names {named} rows, features.npy has {len(rows)}")
        return cls(path, clips, rows, manifest)

    @property
    def layout(self) -> Layout:
        """That of HumanML3D."""
        return HUMAN

    def features(self, clip: Clip) -> np.ndarray:
        """(length, 263) float32 features of a clip, not standardised."""
        return self.rows[clip.start : clip.start + clip.length].astype(np.float32)

    def split(self, name: str) -> tuple[Clip, ...]:
        """The clips of "train", "val" or "test"."""
        return of_split(self.clips, name)

    def clip(self, name: str) -> Clip:
        """The clip of that id, or UnknownName."""
        found = next((clip for clip in self.clips if clip.id == name), None)
        if found is None:
            raise UnknownName("clip", name, (self.clips[0].id, "...", self.clips[-1].id))
        return found

    @property
    def mean(self) -> np.ndarray:
        """(263,) float32 mean of each feature over the training clips."""
        return self._statistics[0]

    @property
    def std(self) -> np.ndarray:
        """(263,) float32 standard deviation of each feature over the training clips."""
        return self._statistics[1]

    @cached_property
    def _statistics(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and standard deviation, kept in the folder where it can be written to."""
        path = self.path / "statistics.npz"
        try:
            with np.load(path, allow_pickle=False) as kept:
                return kept["mean"], kept["std"]
        except (OSError, ValueError, KeyError, zipfile.BadZipFile):
            mean, std = self._measure()
        if self._writable:
            with atomic_path(path) as temporary, temporary.open("wb") as stream:
                np.savez(stream, mean=mean, std=std)
        return mean, std

    @property
    def _writable(self) -> bool:
        import os

        return os.access(self.path, os.W_OK)

    def _measure(self) -> tuple[np.ndarray, np.ndarray]:
        training = self.split("train")
        if not training:
            raise InvalidFile(self.path, "has no training clips")
        return measured(lambda: (self.features(clip) for clip in training))


def clip_to_json(clip: Clip) -> str:
    """One line of `clips.jsonl`."""
    data = {**vars(clip)}
    data["segments"] = [vars(segment) for segment in clip.segments]
    data["captions"] = [{"text": caption.text, "segments": caption.segments} for caption in clip.captions]
    return json.dumps(data, separators=(",", ":"))


def clip_from_json(line: str) -> Clip:
    """The inverse of `clip_to_json`; KeyError, TypeError or ValueError where the line is not a clip."""
    data = json.loads(line)
    data["segments"] = tuple(
        LabelledSegment(**{**segment, "actions": tuple((name, params) for name, params in segment["actions"])})
        for segment in data["segments"]
    )
    data["captions"] = tuple(Caption(caption["text"], tuple(caption["segments"])) for caption in data["captions"])
    return Clip(**data)


def _read_manifest(path: Path) -> dict[str, Any]:
    try:
        manifest = json.loads(path.read_text(encoding="utf-8"))
        version = manifest["version"]
    except OSError:
        raise InvalidFile(path, "no such file; `launch.py data build --out FOLDER` makes a data set") from None
    except (ValueError, KeyError, TypeError):
        raise InvalidFile(path, "not the manifest of a data set") from None
    if version != VERSION:
        raise InvalidFile(path, f"data set version {version}, this program reads {VERSION}; build it again")
    return manifest


def _read_rows(path: Path) -> np.ndarray:
    try:
        rows = np.load(path, mmap_mode="r", allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise InvalidFile(path, f"not a readable array: {error}") from None
    if rows.ndim != 2 or rows.shape[1] != len(CHANNELS):
        raise InvalidFile(path, f"expected shape (N, {len(CHANNELS)}), found {rows.shape}")
    return rows


def _read_clips(path: Path) -> tuple[Clip, ...]:
    try:
        with path.open(encoding="utf-8") as lines:
            return tuple(clip_from_json(line) for line in lines)
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError) as error:
        raise InvalidFile(path, f"a line is not a clip: {error!r}") from None
