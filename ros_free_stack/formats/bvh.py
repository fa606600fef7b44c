"""Biovision hierarchies (BVH).

Rotations apply from left to right in the order of the channels; position channels stand in place of the offset, as
the programs that write such files (MotionBuilder, Blender) mean them.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import write_text

Floats = NDArray[np.float64]

_CHANNELS = {f"{axis}{kind}" for axis in "XYZ" for kind in ("position", "rotation")}


@dataclass(frozen=True)
class Joint:
    """A joint or an end site (named after its parent, with "_end"); the offset is in the file's unit."""

    name: str
    parent: int
    offset: Floats
    channels: tuple[str, ...]


@dataclass(frozen=True)
class Bvh:
    """A BVH file: joints, parents first, and (T, channels) values in the file's unit and in degrees."""

    joints: tuple[Joint, ...]
    values: Floats
    fps: float

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(joint.name for joint in self.joints)


def read_bvh(path: Path) -> Bvh:
    """Read a file.

    Raises:
        InvalidFile: the file is missing, truncated or malformed; the message names the line.
    """
    try:
        lines = path.read_text(encoding="latin-1").splitlines()
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    motion = next((i for i, line in enumerate(lines) if line.strip() == "MOTION"), None)
    if motion is None:
        raise InvalidFile(path, "no line 'MOTION' (truncated?)")
    joints = _hierarchy(path, lines[:motion])
    count = round(_header(path, lines, motion + 1, "Frames:"))
    frame_time = _header(path, lines, motion + 2, "Frame Time:")
    if count < 1 or frame_time <= 0:
        raise InvalidFile(path, f"line {motion + 2}: {count} frames of {frame_time} s")
    width = sum(len(joint.channels) for joint in joints)
    first = motion + 3
    try:
        values = np.array(" ".join(lines[first:]).split(), dtype=np.float64).reshape(count, width)
    except ValueError:
        raise _fault(path, lines, first, count, width) from None
    if not np.isfinite(values).all():
        raise _fault(path, lines, first, count, width)
    return Bvh(tuple(joints), values, 1 / frame_time)


def positions(bvh: Bvh) -> Floats:
    """(T, J, 3) positions of all joints and end sites, in the file's frame and unit."""
    frames, column = len(bvh.values), 0
    turns: list[Floats] = []
    points = np.zeros((frames, len(bvh.joints), 3))
    for i, joint in enumerate(bvh.joints):
        values = bvh.values[:, column : column + len(joint.channels)]
        column += len(joint.channels)
        offset = np.tile(joint.offset, (frames, 1))
        turning = [k for k, channel in enumerate(joint.channels) if channel.endswith("rotation")]
        for k, channel in enumerate(joint.channels):
            if k not in turning:
                offset[:, "XYZ".index(channel[0])] = values[:, k]
        turn = np.broadcast_to(np.eye(3), (frames, 3, 3))
        if turning:
            order = "".join(joint.channels[k][0] for k in turning)
            turn = Rotation.from_euler(order, values[:, turning], degrees=True).as_matrix()
        if joint.parent < 0:
            points[:, i] = offset
            turns.append(turn)
            continue
        base = turns[joint.parent]
        points[:, i] = points[:, joint.parent] + (base @ offset[..., None])[..., 0]
        turns.append(base @ turn)
    return points


def write_bvh(path: Path, bvh: Bvh) -> None:
    """Write a file, whole or not at all; the joints must be in depth-first order."""
    lines = ["HIERARCHY"]
    open_joints: list[int] = []
    for i, joint in enumerate(bvh.joints):
        while open_joints and open_joints[-1] != joint.parent:
            open_joints.pop()
            lines.append("\t" * len(open_joints) + "}")
        indent = "\t" * len(open_joints)
        title = f"{'JOINT' if open_joints else 'ROOT'} {joint.name}" if joint.channels else "End Site"
        lines += [indent + title, indent + "{", f"{indent}\tOFFSET {_numbers(joint.offset)}"]
        if joint.channels:
            lines.append(f"{indent}\tCHANNELS {len(joint.channels)} {' '.join(joint.channels)}")
        open_joints.append(i)
    lines += ["\t" * k + "}" for k in reversed(range(len(open_joints)))]
    lines += ["MOTION", f"Frames: {len(bvh.values)}", f"Frame Time: {1 / bvh.fps:.9f}"]
    write_text(path, "\n".join([*lines, *map(_numbers, bvh.values)]) + "\n")


def _numbers(values: Floats) -> str:
    return " ".join(f"{value:.6f}" for value in values)


def _header(path: Path, lines: list[str], i: int, key: str) -> float:
    line = lines[i].strip() if i < len(lines) else ""
    try:
        value = float(line.removeprefix(key)) if line.startswith(key) else np.nan
        if not np.isfinite(value):
            raise ValueError
    except ValueError:
        raise InvalidFile(path, f"line {i + 1}: expected '{key} NUMBER', found {line[:60]!r}") from None
    return value


def _hierarchy(path: Path, lines: list[str]) -> list[Joint]:
    joints: list[Joint] = []
    stack: list[int] = []
    names: list[str] = []
    for number, line in enumerate(lines, start=1):
        words = line.split()
        if not words or words[0] in ("HIERARCHY", "{"):
            continue
        if words[0] in ("ROOT", "JOINT") and len(words) > 1:
            names.append(words[1])
        elif words[0] == "End" and stack:
            names.append(f"{joints[stack[-1]].name}_end")
        elif words[0] == "OFFSET" and names and len(words) == 4:
            offset = np.array([_number(path, number, word) for word in words[1:]])
            joints.append(Joint(names.pop(), stack[-1] if stack else -1, offset, ()))
            stack.append(len(joints) - 1)
        elif words[0] == "CHANNELS" and stack and _are_channels(words[1:]):
            last = joints[stack[-1]]
            joints[stack[-1]] = Joint(last.name, last.parent, last.offset, tuple(words[2:]))
        elif words[0] == "}" and stack:
            stack.pop()
        else:
            raise InvalidFile(path, f"line {number}: unexpected {line.strip()[:60]!r}")
    if stack or not joints:
        raise InvalidFile(path, f"line {len(lines)}: the hierarchy is not closed (truncated?)")
    return joints


def _are_channels(words: list[str]) -> bool:
    """Whether these are a count and as many channels, none of them twice."""
    return bool(words) and words[0] == str(len(set(words[1:]) & _CHANNELS)) == str(len(words) - 1)


def _number(path: Path, line: int, word: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise InvalidFile(path, f"line {line}: expected a finite number, found {word!r}")
    return value


def _fault(path: Path, lines: list[str], first: int, count: int, width: int) -> InvalidFile:
    """The error that names the first frame that is not `width` finite numbers."""
    rows = 0
    for number, line in enumerate(lines[first:], start=first + 1):
        words = line.split()
        if not words:
            continue
        rows += 1
        if len(words) != width:
            return InvalidFile(path, f"line {number}: expected {width} numbers, found {len(words)}")
        for word in words:
            _number(path, number, word)
    return InvalidFile(path, f"line {len(lines)}: expected {count} frames, found {rows}")
