"""Acclaim skeletons (ASF) and motions (AMC), the native format of the CMU motion capture database.

A bone turns about its own axes: its rotation in the frame of its parent is C M C^-1 with C the axes given in
the skeleton and M the motion, both x, y, z Euler angles about fixed axes. Lengths times the unit of the
skeleton are inches.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.source import LARGEST
from ros_free_stack.formats.text import read_text

Floats = NDArray[np.float64]

INCH = 0.0254
_ROOT_CHANNELS = ("tx", "ty", "tz", "rx", "ry", "rz")


@dataclass(frozen=True)
class Bone:
    """One bone: its offset from start to end (m, skeleton frame), its own axes and the channels it moves in."""

    name: str
    parent: str
    offset: Floats
    axes: Rotation
    channels: tuple[str, ...]


@dataclass(frozen=True)
class AsfSkeleton:
    """Bones in an order in which parents come first; the root is the first, with six channels."""

    bones: tuple[Bone, ...]
    metres: float

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(bone.name for bone in self.bones)


def read_asf(path: Path) -> AsfSkeleton:
    """Read a skeleton.

    Raises:
        InvalidFile: the file is missing, truncated or malformed; the message names the line where it can.
    """
    sections = _sections(path)
    for name in ("units", "root", "bonedata", "hierarchy"):
        if name not in sections:
            raise InvalidFile(path, f"no section ':{name}' (truncated?)")
    metres = _unit(path, sections["units"])
    orientation = _root_orientation(path, sections["root"])
    parents = _hierarchy(path, sections["hierarchy"])
    bones = {"root": Bone("root", "", np.zeros(3), orientation, _ROOT_CHANNELS)}
    for bone in _bones(path, sections["bonedata"], metres, parents):
        bones[bone.name] = bone
    missing = [name for name in parents if name not in bones]
    if missing:
        raise InvalidFile(path, f"no bone data of {missing[0]!r} (truncated?)")
    return AsfSkeleton(tuple(bones[name] for name in ("root", *parents)), metres)


def read_amc(path: Path, skeleton: AsfSkeleton) -> dict[str, Floats]:
    """Read a motion: for each moving bone its (T, channels) values, angles in rad and root position in m.

    Frames are numbered one after the other from any first number (CMU's start late where the markers were not
    all seen yet).

    Raises:
        InvalidFile: the file is missing, truncated or malformed, or belongs to another skeleton.
    """
    text = read_text(path)
    start = re.search(r"^[ \t]*\d+\s*$", text, re.MULTILINE)
    if start is None:
        raise InvalidFile(path, "no frames (truncated?)")
    header, body = text[: start.start()], text[start.start() :]
    if ":RADIANS" in header.upper():
        raise InvalidFile(path, "angles are not in degrees")
    first_line = header.count("\n") + 1
    names = re.findall(r"^[A-Za-z_]\w*", body, re.MULTILINE)
    bones = names[: names.index("root", 1)] if names.count("root") > 1 else names
    channels = {bone.name: bone.channels for bone in skeleton.bones}
    stray = next((name for name in bones if not channels.get(name)), None)
    if stray is not None:
        raise InvalidFile(path, f"bone {stray!r} does not move in the skeleton")
    widths = [len(channels[name]) for name in bones]
    frames = len(names) // len(bones) if bones else 0
    try:
        values = np.array(re.sub(r"^[A-Za-z_]\w*", "", body, flags=re.MULTILINE).split(), dtype=np.float64)
        table = values.reshape(frames, 1 + sum(widths))
        sound = names == bones * frames and bool((np.diff(table[:, 0]) == 1).all())
    except ValueError:
        sound, table = False, np.empty((0, 0))
    if not sound or not (np.abs(table) <= LARGEST).all():
        raise _fault(path, body, first_line, dict(zip(bones, widths, strict=True)))
    motion = dict(zip(bones, np.split(table[:, 1:], np.cumsum(widths)[:-1], axis=1), strict=True))
    return {
        name: np.where([channel[0] == "t" for channel in channels[name]], skeleton.metres, np.pi / 180) * values
        for name, values in motion.items()
    }


def positions(skeleton: AsfSkeleton, motion: dict[str, Floats]) -> Floats:
    """(T, B, 3) ends of all bones in m, y up; `skeleton.names` says which is which, and "root" is the root."""
    frames = len(motion["root"])
    turns: dict[str, Floats] = {}
    ends = {"root": motion["root"][:, :3]}
    for bone in skeleton.bones:
        local = np.broadcast_to(np.eye(3), (frames, 3, 3))
        if bone.name in motion:
            angles = np.zeros((frames, 3))
            for channel, column in zip(bone.channels, motion[bone.name].T, strict=True):
                if channel[0] == "r":
                    angles[:, "xyz".index(channel[1])] = column
            axes = bone.axes.as_matrix()
            local = axes @ Rotation.from_euler("xyz", angles).as_matrix() @ axes.T
        if not bone.parent:
            turns[bone.name] = local
            continue
        turns[bone.name] = turns[bone.parent] @ local
        ends[bone.name] = ends[bone.parent] + turns[bone.name] @ bone.offset
    return np.stack([ends[name] for name in skeleton.names], axis=1)


Lines = list[tuple[int, list[str]]]


def _number(path: Path, line: int, word: str) -> float:
    if not _finite([word]):
        raise InvalidFile(path, f"line {line}: expected a number, found {word!r}")
    return float(word)


def _euler(degrees: Sequence[float]) -> Rotation:
    return Rotation.from_euler("xyz", degrees, degrees=True)


def _sections(path: Path) -> dict[str, Lines]:
    sections: dict[str, Lines] = {}
    lines: Lines = []
    for number, line in enumerate(read_text(path).splitlines(), start=1):
        words = line.split("#")[0].split()
        if words and words[0].startswith(":"):
            lines = sections.setdefault(words[0][1:].lower(), [])
        elif words:
            lines.append((number, words))
    return sections


def _unit(path: Path, lines: Lines) -> float:
    """Metres a unit of length."""
    metres = INCH
    for number, words in lines:
        if words[0] == "angle" and words[1:] != ["deg"]:
            raise InvalidFile(path, f"line {number}: angles are not in degrees")
        if words[0] == "length":
            unit = _number(path, number, " ".join(words[1:]))
            if unit <= 0:
                raise InvalidFile(path, f"line {number}: length unit {unit}, expected a positive number")
            metres = INCH / unit
    return metres


def _root_orientation(path: Path, lines: Lines) -> Rotation:
    orientation = _euler([0, 0, 0])
    for number, words in lines:
        if words[0] == "order" and tuple(word.lower() for word in words[1:]) != _ROOT_CHANNELS:
            raise InvalidFile(path, f"line {number}: root order, expected {' '.join(_ROOT_CHANNELS).upper()}")
        if words[0] == "orientation":
            if len(words) != 4:
                raise InvalidFile(path, f"line {number}: expected three angles")
            orientation = _euler([_number(path, number, word) for word in words[1:]])
    return orientation


def _hierarchy(path: Path, lines: Lines) -> dict[str, str]:
    """Parent of each bone, in an order in which parents come first."""
    parents: dict[str, str] = {}
    for number, words in lines:
        if words[0] in ("begin", "end"):
            continue
        if words[0] != "root" and words[0] not in parents:
            raise InvalidFile(path, f"line {number}: {words[0]!r} has no parent yet")
        parents |= dict.fromkeys(words[1:], words[0])
    return parents


def _bones(path: Path, lines: Lines, metres: float, parents: dict[str, str]) -> list[Bone]:
    bones: list[Bone] = []
    entry: dict[str, list[str]] = {}
    for number, words in lines:
        if words[0] == "begin":
            entry = {}
        elif words[0] != "end":
            entry.setdefault(words[0], words[1:])
        else:
            bones.append(_bone(path, number, entry, metres, parents))
    return bones


def _bone(path: Path, line: int, entry: dict[str, list[str]], metres: float, parents: dict[str, str]) -> Bone:
    for key, count in (("name", 1), ("direction", 3), ("length", 1), ("axis", 4)):
        if len(entry.get(key, [])) != count:
            raise InvalidFile(path, f"line {line}: the bone that ends here has no valid {key!r}")
    name = entry["name"][0]
    if name not in parents:
        raise InvalidFile(path, f"line {line}: bone {name!r} is not in the hierarchy")
    if entry["axis"][3].upper() != "XYZ":
        raise InvalidFile(path, f"line {line}: axis order {entry['axis'][3]}, expected XYZ")
    direction = np.array([_number(path, line, word) for word in entry["direction"]])
    length = _number(path, line, entry["length"][0]) * metres
    axes = _euler([_number(path, line, word) for word in entry["axis"][:3]])
    channels = tuple(word.lower() for word in entry.get("dof", []))
    if not set(channels) <= {"rx", "ry", "rz"}:
        raise InvalidFile(path, f"line {line}: degrees of freedom {' '.join(channels)}, expected rx, ry, rz")
    return Bone(name, parents[name], direction * length, axes, channels)


def _fault(path: Path, body: str, first_line: int, widths: dict[str, int]) -> InvalidFile:
    """The error that names the first line of an AMC body that does not follow from the ones before it."""
    expected = ["", *widths]
    frame, place, number = int(body.split(maxsplit=1)[0]) - 1, 0, first_line
    for number, line in enumerate(body.splitlines(), start=first_line):
        words = line.split()
        if not words:
            continue
        if place == 0:
            frame += 1
            wanted = f"frame number {frame}"
            sound = words == [str(frame)]
        else:
            name = expected[place]
            wanted = f"{name!r} and {widths[name]} finite numbers"
            sound = words[0] == name and len(words) == widths[name] + 1 and _finite(words[1:])
        if not sound:
            return InvalidFile(path, f"line {number}: expected {wanted}, found {line.strip()[:60]!r}")
        place = (place + 1) % len(expected)
    return InvalidFile(path, f"line {number}: the file ends inside frame {frame} (truncated?)")


def _finite(words: list[str]) -> bool:
    try:
        return all(abs(float(word)) <= LARGEST for word in words)
    except ValueError:
        return False
