"""What every reader takes and gives."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidMessage
from ros_free_stack.messages import Floats, HumanMotion, RobotTrajectory

Units = Literal["m", "cm", "mm", "inch", "cmu"]
UpAxis = Literal["y", "z"]
QuaternionOrder = Literal["xyzw", "wxyz"]


@dataclass(frozen=True, kw_only=True)
class SourceOptions:
    """What a user says of a file that the file does not say itself; None where nothing was said."""

    robot: str | None = None
    source_fps: float | None = None
    quaternion: QuaternionOrder | None = None
    units: Units | None = None
    up: UpAxis | None = None
    mapping: Path | None = None
    skeleton: Path | None = None
    clip: str | None = None


@dataclass(frozen=True)
class Source:
    """What a file holds, and in words what the reader had to assume."""

    content: HumanMotion | RobotTrajectory
    notes: tuple[str, ...] = ()


def human_source(path: Path, joints: Floats, fps: float, notes: tuple[str, ...] = ()) -> Source:
    """A Source of (T, 22, 3) joints in m, z up; InvalidFile where they are no motion."""
    try:
        return Source(HumanMotion(joints=joints, fps=fps, source=path.name), notes)
    except InvalidMessage as error:
        raise InvalidFile(path, f"not a valid human motion: {error}") from None


def check_finite(path: Path, name: str, values: Floats) -> None:
    """InvalidFile with the first frame of (T, ...) values that is not finite."""
    bad = ~np.isfinite(values).reshape(len(values), -1).all(axis=1)
    if bad.any():
        raise InvalidFile(path, f"{name}: a value that is not finite at frame {int(np.flatnonzero(bad)[0])}")
