"""Frame rates: what a file states, what a user says, and what cannot be."""

from pathlib import Path
from typing import Final

import numpy as np

from ros_free_stack.errors import InvalidOption

SLOWEST_FPS: Final = 5.0
FASTEST_FPS: Final = 1000.0
"""No recording of motion has fewer or more frames a second."""

ROUND_FPS: Final = 5e-4
"""Frame times are rounded in files: a rate this close to a whole number is that number."""


def check_rate(option: str, fps: float) -> None:
    """InvalidOption where a rate that a user gave is none."""
    if not (np.isfinite(fps) and SLOWEST_FPS <= fps <= FASTEST_FPS):
        raise InvalidOption(option, f"expected {SLOWEST_FPS:g} to {FASTEST_FPS:g} frames a second, found {fps:g}")


def frame_rate(path: Path, stated: float | None, given: float | None) -> float:
    """The frame rate of a file: the user's word, else what the file states, where that can be.

    Raises:
        InvalidOption: the file states none, or one that cannot be; the message says what may be meant.
    """
    if given is not None:
        check_rate("--source-fps", given)
        return given
    if stated is None:
        raise InvalidOption("--source-fps", f"name the frame rate of {path}: the file does not state it")
    if not (np.isfinite(stated) and SLOWEST_FPS <= stated <= FASTEST_FPS):
        raise InvalidOption("--source-fps", f"name the frame rate of {path}: {_doubt(stated)}")
    return float(round(stated)) if abs(stated - round(stated)) < ROUND_FPS * stated else stated


def _doubt(stated: float) -> str:
    """Why a rate cannot be, and what its number would be as a rate or as a time in ms."""
    if not (np.isfinite(stated) and stated > 0):
        return "it states none that is positive"
    meant = dict.fromkeys(f"{fps:.4g}" for fps in (1 / stated, 1000 * stated) if SLOWEST_FPS <= fps <= FASTEST_FPS)
    hint = f" (perhaps {' or '.join(meant)} is meant)" if meant else ""
    return f"it states {stated:.4g} frames a second, {1 / stated:.4g} s each{hint}"
