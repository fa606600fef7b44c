"""The text of BVH files, as programs write it rather than as its description has it.

Words count, not lines: keywords and channels in any case, names with spaces, braces on the line of their joint, blank
lines anywhere, numbers with a decimal comma. Of frames there are as many as there are rows: exporters miscount them.
"""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.bvh import Bvh, Floats, Joint
from ros_free_stack.formats.source import LARGEST
from ros_free_stack.formats.text import read_text

_CHANNELS: Final = {f"{axis}{kind}".lower(): f"{axis}{kind}" for axis in "XYZ" for kind in ("position", "rotation")}

MOST_JOINTS: Final = 5000
"""No rig has as many; what follows takes the square of their number."""

_HEADER: Final = {"Frames:": r"frames ?:? ?(\S+)", "Frame Time:": r"frame ?time ?:? ?(\S+)"}

Rows = list[tuple[int, list[str]]]
"""Numbers of lines and their words."""


def read_bvh(path: Path) -> Bvh:
    """Read a file; its `notes` say what it contradicts itself in.

    Raises:
        InvalidFile: the file is missing, truncated or malformed; the message names the line.
    """
    lines = read_text(path).split("\n")
    motion = next((i for i, line in enumerate(lines) if line.strip().lower() == "motion"), None)
    if motion is None:
        raise InvalidFile(path, "no line 'MOTION' (truncated?)")
    joints = _hierarchy(path, lines[:motion])
    if len(joints) > MOST_JOINTS:
        raise InvalidFile(path, f"holds {len(joints)} joints and end sites, expected at most {MOST_JOINTS}")
    rows: Rows = [(i + 1, line.split()) for i, line in enumerate(lines) if i > motion and line.strip()]
    count, frame_time = (_header(path, lines, rows, i, key) for i, key in enumerate(_HEADER))
    width = sum(len(joint.channels) for joint in joints)
    values, notes = _frames(path, rows[2:], round(count), width)
    return Bvh(tuple(joints), values, 1 / frame_time if frame_time > 0 else 0.0, notes)


def _header(path: Path, lines: list[str], rows: Rows, i: int, key: str) -> float:
    line, words = rows[i] if i < len(rows) else (len(lines), [])
    found = re.fullmatch(_HEADER[key], " ".join(words), re.IGNORECASE)
    if found is None or not _is_number(found.group(1)):
        raise InvalidFile(path, f"line {line}: expected '{key} NUMBER', found {' '.join(words)[:60]!r}")
    return _number(path, line, found.group(1))


def _frames(path: Path, rows: Rows, count: int, width: int) -> tuple[Floats, tuple[str, ...]]:
    """(T, width) numbers of the rows and what there is to say of them; `count` is what the header says."""
    notes: tuple[str, ...] = ()
    if len(rows) > count > 0 and not _is_number(rows[count][1][0]):
        notes += (f"line {rows[count][0]}: text after the frames is left out",)
        rows = rows[:count]
    words = [row for _, row in rows]
    if any(len(row) != width for row in words):
        flat = [word for row in words for word in row]
        if width and len(flat) == count * width:  # frames that go over several lines
            words = [flat[k : k + width] for k in range(0, len(flat), width)]
        else:
            raise _fault(path, rows, width)
    if not words or not width:
        raise InvalidFile(path, f"holds {len(words)} frames of {width} channels")
    try:
        values = np.array(words, dtype=np.float64)
    except ValueError:
        if not all(_is_number(word) for row in words for word in row):
            raise _fault(path, rows, width) from None
        values = np.array([[_with_point(word) for word in row] for row in words], dtype=np.float64)
    if not (np.abs(values) <= LARGEST).all():
        raise _fault(path, rows, width)
    if len(values) != count:
        notes += (f"the header counts {count} frames, the file holds {len(values)}: all of these are read",)
    return values, notes


def _fault(path: Path, rows: Rows, width: int) -> InvalidFile:
    """The error that names the first row that is not `width` finite numbers."""
    for line, words in rows:
        for word in words:
            _number(path, line, word)
        if len(words) != width:
            return InvalidFile(path, f"line {line}: expected {width} numbers, found {len(words)} (truncated?)")
    return InvalidFile(path, f"holds {len(rows)} frames of {width} channels")


def _hierarchy(path: Path, lines: list[str]) -> list[Joint]:
    words = _words(lines)
    joints: list[Joint] = []
    stack: list[int] = []
    for line, word in words:
        key = word.lower()
        if key == "hierarchy" and not joints:
            continue
        if key in ("root", "joint", "end"):
            name = _title(path, line, words)
            if key == "end" and stack:
                name = f"{joints[stack[-1]].name}_end"
            elif key == "end" or not name or (key == "joint" and not stack):
                raise InvalidFile(path, f"line {line}: unexpected {f'{word} {name}'.strip()[:60]!r}")
            stack.append(len(joints))
            joints.append(Joint(name, stack[-2] if len(stack) > 1 else -1, np.zeros(3), ()))
        elif key == "offset" and stack:
            offset = np.array([_number(path, line, _next(path, line, words)) for _ in range(3)])
            joints[stack[-1]] = _changed(joints[stack[-1]], offset=offset)
        elif key == "channels" and stack:
            joints[stack[-1]] = _changed(joints[stack[-1]], channels=_channels(path, line, words))
        elif key == "}" and stack:
            stack.pop()
        else:
            raise InvalidFile(path, f"line {line}: unexpected {word[:60]!r}")
    if stack or not joints:
        raise InvalidFile(path, f"line {len(lines)}: the hierarchy is not closed (truncated?)")
    return joints


def _words(lines: list[str]) -> Iterator[tuple[int, str]]:
    """Words of the hierarchy with the numbers of their lines; a brace is a word."""
    for number, line in enumerate(lines, start=1):
        for word in line.replace("{", " { ").replace("}", " } ").split():
            yield number, word


def _title(path: Path, line: int, words: Iterator[tuple[int, str]]) -> str:
    """The words up to the opening brace: all of them stand on the joint's line."""
    title: list[str] = []
    for number, word in words:
        if word == "{":
            return " ".join(title)
        if number != line:
            raise InvalidFile(path, f"line {number}: expected '{{', found {word[:60]!r}")
        title.append(word)
    raise InvalidFile(path, f"line {line}: the hierarchy is not closed (truncated?)")


def _channels(path: Path, line: int, words: Iterator[tuple[int, str]]) -> tuple[str, ...]:
    count = _next(path, line, words)
    named = [_next(path, line, words) for _ in range(int(count) if count.isdecimal() and len(count) == 1 else 0)]
    known = {_CHANNELS[name.lower()] for name in named if name.lower() in _CHANNELS}
    if len(known) != len(named) or count != str(len(named)):
        found = " ".join([count, *named])
        valid = ", ".join(_CHANNELS.values())
        raise InvalidFile(path, f"line {line}: expected a count and as many of {valid}, found {found[:80]!r}")
    return tuple(_CHANNELS[name.lower()] for name in named)


def _next(path: Path, line: int, words: Iterator[tuple[int, str]]) -> str:
    _, word = next(words, (line, ""))
    if not word or word in "{}":
        raise InvalidFile(path, f"line {line}: ends too early, at {word!r}")
    return word


def _changed(joint: Joint, *, offset: Floats | None = None, channels: tuple[str, ...] | None = None) -> Joint:
    return Joint(
        joint.name,
        joint.parent,
        joint.offset if offset is None else offset,
        joint.channels if channels is None else channels,
    )


def _with_point(word: str) -> str:
    """A number with its decimal comma, if it is one, as a point."""
    return word.replace(",", ".") if "." not in word and word.count(",") == 1 else word


def _is_number(word: str) -> bool:
    try:
        return abs(float(_with_point(word))) <= LARGEST
    except ValueError:
        return False


def _number(path: Path, line: int, word: str) -> float:
    if not _is_number(word):
        raise InvalidFile(path, f"line {line}: expected a finite number, found {word!r}")
    return float(_with_point(word))
