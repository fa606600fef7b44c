"""Tables of numbers as text: csv with commas, semicolons, tabs or blanks, with a line of names or without."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.source import LARGEST
from ros_free_stack.formats.text import read_text
from ros_free_stack.messages import Floats


@dataclass(frozen=True)
class Table:
    """(T, C) numbers, and the C names of the columns; none where the file has no line of names."""

    rows: Floats
    names: tuple[str, ...]


def read_table(path: Path) -> Table:
    """The table in a file; lines that begin with `#` are remarks, but for a first one that names the columns.

    Raises:
        InvalidFile: a row is cut short, or holds something other than finite numbers; the message names the line.
    """
    text = read_text(path)
    if "\x00" in text:
        raise InvalidFile(path, "is not text")
    lines = [(number, line) for number, line in enumerate(text.split("\n"), start=1) if line.strip()]
    if not lines:
        raise InvalidFile(path, "no frames")
    separator = next((mark for mark in ",;\t" if mark in lines[0][1].lstrip("#")), None)
    names: tuple[str, ...] = ()
    remarks = [line for line in lines if line[1].lstrip().startswith("#")]
    body = [line for line in lines if line not in remarks]
    if remarks and body and len(_cells(remarks[-1][1].lstrip("# "), separator)) == len(_cells(body[0][1], separator)):
        names = _cells(remarks[-1][1].lstrip("# "), separator)
    elif body and not any(map(_is_number, _cells(body[0][1], separator))):
        names, body = _cells(body[0][1], separator), body[1:]
    if not body:
        raise InvalidFile(path, "no frames")
    width = len(names) or len(_cells(body[0][1], separator))
    rows = np.empty((len(body), width))
    for row, (number, line) in zip(rows, body, strict=True):
        cells = _cells(line, separator)
        if len(cells) != width:
            raise InvalidFile(path, f"line {number}: expected {width} numbers, found {len(cells)} (truncated?)")
        try:
            row[:] = [float(cell) for cell in cells]
        except ValueError as error:
            raise InvalidFile(path, f"line {number}: {error}; expected numbers below one line of names") from None
        if not (np.abs(row) <= LARGEST).all():
            raise InvalidFile(path, f"line {number}: a value that is not finite, or larger than {LARGEST:g}")
    return Table(rows, names)


def times_rate(path: Path, times_s: Floats) -> float:
    """The frame rate of (T,) times in s; InvalidFile where they do not rise evenly."""
    if len(times_s) < 2:
        raise InvalidFile(path, "one row tells no frame rate")
    steps = np.diff(times_s)
    step = float(np.median(steps))
    uneven = np.abs(steps - step) > 0.5 * abs(step)
    if not (steps > 0).all() or uneven.any():
        row = int(np.argmax((steps <= 0) | uneven))
        raise InvalidFile(path, f"times do not rise evenly: {times_s[row]:g} is followed by {times_s[row + 1]:g}")
    return (len(times_s) - 1) / float(times_s[-1] - times_s[0])


def _cells(line: str, separator: str | None) -> tuple[str, ...]:
    cells = line.strip().split(separator)
    return tuple(cell.strip().strip('"') for cell in (cells[:-1] if cells and not cells[-1].strip() else cells))


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True
