"""The part of a motion that a user asks for, by its times."""

from pathlib import Path

import numpy as np

from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.source import SourceOptions


def frames_between(path: Path, frames: int, fps: float, options: SourceOptions) -> slice:
    """The frames from `start` to `end`, both included, in s from the file's first frame.

    Raises:
        InvalidOption: there are none; the message says how long the file is.
    """
    length = (frames - 1) / fps
    start, end = options.start or 0.0, length if options.end is None else options.end
    for option, value in (("--start", start), ("--end", end)):
        if not (np.isfinite(value) and value >= 0):
            raise InvalidOption(option, f"expected seconds from the first frame on, found {value:g}")
    if start > length:
        raise InvalidOption("--start", f"{path} ends at {length:.2f} s, found {start:g}")
    first, last = round(start * fps), min(round(end * fps), frames - 1)
    if last < first:
        raise InvalidOption("--end", f"expected a time after --start ({start:g} s), found {end:g}")
    return slice(first, last + 1)
