"""What every reader takes and gives."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.messages import Floats, HumanMotion, RobotTrajectory

Units = Literal["m", "cm", "mm", "inch", "cmu"]
UpAxis = Literal["y", "z", "x", "y-down"]
QuaternionOrder = Literal["xyzw", "wxyz"]
Angles = Literal["rad", "deg"]


@dataclass(frozen=True, kw_only=True)
class SourceOptions:
    """What a user says of a file that the file does not say itself; None where nothing was said."""

    robot: str | None = None
    source_fps: float | None = None
    quaternion: QuaternionOrder | None = None
    angles: Angles | None = None
    floor: bool | None = None
    units: Units | None = None
    height: float | None = None
    up: UpAxis | None = None
    mapping: Path | None = None
    skeleton: Path | None = None
    clip: str | None = None
    start: float | None = None
    end: float | None = None


@dataclass(frozen=True)
class Source:
    """What a file holds, and in words what the reader had to assume."""

    content: HumanMotion | RobotTrajectory
    notes: tuple[str, ...] = ()


LARGEST: Final = 1e9
"""No length or angle of a motion is larger, in whatever unit; squares of larger numbers leave what floats can hold."""


def check_finite(path: Path, name: str, values: Floats) -> None:
    """InvalidFile with the first frame of (T, ...) values that is not finite or beyond all measure."""
    for bad, what in ((~np.isfinite(values), "not finite"), (np.abs(values) > LARGEST, f"larger than {LARGEST:g}")):
        frames = bad.reshape(len(values), -1).any(axis=1)
        if frames.any():
            raise InvalidFile(path, f"{name}: a value that is {what} at frame {int(np.flatnonzero(frames)[0])}")
