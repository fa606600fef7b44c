"""The CMU motion capture database: a folder of `SUBJECT/SUBJECT_TAKE.amc` (with `SUBJECT.asf`) or `.bvh` files.

An `index.json` in the folder says what each take is and which HumanML3D clips were cut from it. The data was
obtained from the CMU Graphics Lab Motion Capture Database, created with funding from NSF EIA-0196217.
"""

import json
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.formats import asf_amc, bvh, bvh_reader, skeleton_map
from ros_free_stack.formats.frames import from_y_up, put_on_floor
from ros_free_stack.formats.stature import METRES
from ros_free_stack.skeleton import FPS

Floats = NDArray[np.float64]

STRIDE = 6
"""Every sixth frame of CMU's 120 a second, as HumanML3D takes them."""

CMU_LEAD = 7
"""Frames at the start of the archive's BVH files that were not captured: a T-pose, and a smoothed way from it."""

DAMAGED = frozenset({"09_10"})
"""Takes without a usable file: the conversion lost the height and the turning of the root."""

MAX_SPEED = 12.0
"""No joint of a person moves faster than this (m/s) in what these takes show; some dances of subject 05 have a
leg that does, for a few frames."""


@dataclass(frozen=True)
class Clip:
    """A HumanML3D clip cut from a take: its id, official split, time span and captions where they are known.

    Times count from the first frame of the capture; what `read_take` gives begins up to 0.13 s later.
    `mirrored_captions` describe the clip reflected left to right.
    """

    id: str
    split: str
    start_s: float
    end_s: float
    captions: tuple[str, ...]
    mirrored_captions: tuple[str, ...]


@dataclass(frozen=True)
class Take:
    """One recording: name ("SUBJECT_TAKE"), CMU's words for it, frame rate, and the clips cut from it."""

    name: str
    description: str
    subject: str
    fps: float
    clips: tuple[Clip, ...]


def index(folder: Path) -> tuple[Take, ...]:
    """The takes that `folder/index.json` lists, without the damaged ones.

    Raises:
        InvalidFile: the index is missing or not as expected.
    """
    path = folder / "index.json"
    try:
        takes = tuple(_take(entry) for entry in json.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, TypeError, KeyError) as error:
        raise InvalidFile(path, f"not an index of takes: {error!r}") from None
    return tuple(take for take in takes if take.name not in DAMAGED)


def read_take(folder: Path, take: str) -> Floats:
    """Joints of one take.

    Args:
        folder: the unpacked archive.
        take: its name, e.g. "09_01".

    Returns:
        (T, 22, 3) in m at 20 fps: z up, where the recording began facing z now facing x, on the floor z = 0.

    Raises:
        UnknownName: the folder has no such take.
        InvalidFile: a file is truncated or malformed, or the take is known to be damaged.
    """
    if take in DAMAGED:
        raise InvalidFile(folder / take, "damaged: the root's height and turning are lost")
    stem = folder / take.partition("_")[0] / take
    if stem.with_suffix(".amc").is_file():
        joints = _read_amc(stem.with_suffix(".amc"))
    elif stem.with_suffix(".bvh").is_file():
        joints = _read_bvh(stem.with_suffix(".bvh"))
    else:
        takes = (path.stem for kind in ("amc", "bvh") for path in folder.glob(f"*/*.{kind}"))
        raise UnknownName(f"take in {folder}", take, takes)
    return put_on_floor(from_y_up(joints))


def sound_spans(joints: Floats) -> tuple[tuple[int, int], ...]:
    """Stretches (start, end) of frames in which no joint jumps, the longest of which is usually the whole take."""
    speed = np.linalg.norm(np.diff(joints, axis=0), axis=-1).max(axis=1) * FPS
    cuts = [0, *(np.flatnonzero(speed > MAX_SPEED) + 1), len(joints)]
    return tuple((int(start), int(end)) for start, end in pairwise(cuts) if end - start > 1)


def _read_amc(path: Path) -> Floats:
    skeleton = asf_amc.read_asf(path.parent / f"{path.parent.name}.asf")
    motion = asf_amc.read_amc(path, skeleton)
    points = asf_amc.positions(skeleton, {bone: values[::STRIDE] for bone, values in motion.items()})
    return _select(path, skeleton.names, points, skeleton_map.ASF)


def _read_bvh(path: Path) -> Floats:
    data = bvh_reader.read_bvh(path)
    if round(data.fps) != round(STRIDE * FPS):
        raise InvalidFile(path, f"{data.fps:.1f} frames a second, CMU's recordings have {STRIDE * FPS:.0f}")
    if len(data.values) <= CMU_LEAD:
        raise InvalidFile(path, f"holds {len(data.values)} frames, the first {CMU_LEAD} of which are not captured")
    weights, metres = (
        (skeleton_map.DAZ, METRES["cm"]) if "hip" in data.names else (skeleton_map.SUBJECT_131, METRES["cmu"])
    )
    points = bvh.positions(replace(data, values=data.values[CMU_LEAD::STRIDE]))
    return _select(path, data.names, points * metres, weights)


def _select(path: Path, names: tuple[str, ...], points: Floats, weights: skeleton_map.Weights) -> Floats:
    try:
        return skeleton_map.select(names, points, weights)
    except skeleton_map.UnknownSkeleton as error:
        raise InvalidFile(path, str(error)) from None


def _take(entry: dict[str, Any]) -> Take:
    clips = tuple(
        Clip(
            id=clip["id"],
            split=clip["split"],
            start_s=float(clip["start_s"]),
            end_s=float(clip["end_s"]),
            captions=tuple(clip["captions"]),
            mirrored_captions=tuple(clip["captions_mirrored"]),
        )
        for clip in entry["clips"]
    )
    return Take(entry["take"], entry["description"], entry["subject"], float(entry["fps"]), clips)
