"""DeepMimic's motions (Peng et al., SIGGRAPH 2018): JSON text, one row of 44 numbers a frame.

A row is the frame's duration, the root's position and orientation, then the joints in the order of `JOINTS`: a
quaternion each, one angle about z for knees and elbows. Quaternions are wxyz, lengths in m, y up, x forward, z to the
right. The humanoid is the one published with the motions (`data/characters/humanoid3d.txt`): its joints' offsets, the
front edge of its foot boxes as toes, and the foot of the sphere of its head.
"""

import json
from pathlib import Path
from typing import Any, Final

import numpy as np
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.skeleton_map import Weights, select, weights
from ros_free_stack.formats.source import Source, SourceOptions, check_finite
from ros_free_stack.messages import Floats

_LIMBS: Final = (("hip", 4), ("knee", 1), ("ankle", 4), ("shoulder", 4), ("elbow", 1))
JOINTS: Final = (
    ("chest", 4),
    ("neck", 4),
    *((f"{side}_{name}", width) for side in ("right", "left") for name, width in _LIMBS),
)
"""Moving joints and how many numbers each has in a row."""

WIDTH: Final = 8 + sum(width for _, width in JOINTS)

_OFFSETS: Final[dict[str, tuple[str, tuple[float, float, float]]]] = {
    "chest": ("root", (0.0, 0.236151, 0.0)),
    "neck": ("chest", (0.0, 0.223894, 0.0)),
    "head": ("neck", (0.0, 0.0725, 0.0)),
} | {
    f"{side}_{name}": (parent.format(side=side), (x, y, sign * z))
    for side, sign in (("right", 1.0), ("left", -1.0))
    for name, parent, x, y, z in (
        ("hip", "root", 0.0, 0.0, 0.084887),
        ("knee", "{side}_hip", 0.0, -0.421546, 0.0),
        ("ankle", "{side}_knee", 0.0, -0.409870, 0.0),
        ("foot", "{side}_ankle", 0.1335, -0.05, 0.0),
        ("shoulder", "chest", -0.02405, 0.24350, 0.18311),
        ("elbow", "{side}_shoulder", 0.0, -0.274788, 0.0),
        ("wrist", "{side}_elbow", 0.0, -0.258947, 0.0),
    )
}
"""Parent of each joint and its place there, in m; parents come first."""

_WEIGHTS: Final[Weights] = weights(
    pelvis={"root": 0.7, "chest": 0.3},
    spine1={"root": 0.2, "chest": 0.8},
    spine2={"chest": 0.9, "neck": 0.1},
    spine3={"chest": 0.8, "neck": 0.2},
    neck="neck",
    head="head",
    collar={"chest": 0.44, "neck": 0.11, "{lower}_shoulder": 0.45},
    **{name: f"{{lower}}_{name}" for name in ("hip", "knee", "ankle", "foot", "shoulder", "elbow", "wrist")},
)
"""The root lies between the hips, below where SMPL has its pelvis."""


def read(path: Path, options: SourceOptions) -> Source:
    """The human motion in a DeepMimic file; frames of unequal duration are resampled to their median rate.

    Raises:
        InvalidFile: the file is no such motion; the message names the frame.
    """
    rows = _rows(path)
    durations = rows[:-1, 0] if len(rows) > 1 else rows[:, 0]
    if not (durations > 0).all():
        frame = int(np.argmin(durations > 0))
        raise InvalidFile(path, f"frame {frame} lasts {durations[frame]:g} s, expected more than 0")
    step = float(np.median(durations))
    points = _forward_kinematics(path, rows)
    joints = select(tuple(points), np.stack(list(points.values()), axis=1), _WEIGHTS)
    notes: tuple[str, ...] = ()
    if np.ptp(durations) > 1e-3 * step:
        times = np.concatenate([[0.0], np.cumsum(durations)])
        wanted = np.arange(0.0, times[-1] + 1e-9, step)
        at = np.interp(wanted, times, np.arange(len(rows)))
        before = np.minimum(at.astype(np.intp), len(rows) - 2)
        part = (at - before)[:, None, None]
        joints = (1 - part) * joints[before] + part * joints[before + 1]
        notes = (f"frames of unequal duration: resampled to {1 / step:.4g} fps, linearly",)
    joints = joints[..., (0, 2, 1)] * (1, -1, 1)
    habits = Habits(title="DeepMimic", up="z", units="m")
    return person_source(path, joints, options, habits, fps=round(1 / step, 3), notes=notes)


def _rows(path: Path) -> Floats:
    try:
        data: Any = json.loads(path.read_text(encoding="utf-8"))
        frames: Any = data["Frames"]
        count = len(frames)
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError) as error:
        raise InvalidFile(path, f"not a DeepMimic motion, a JSON object with 'Frames' (truncated? {error})") from None
    if not count:
        raise InvalidFile(path, "no frames")
    for i, frame in enumerate(frames):
        if not isinstance(frame, list) or len(frame) != WIDTH:  # pyright: ignore[reportUnknownArgumentType]
            found = len(frame) if isinstance(frame, list) else type(frame).__name__  # pyright: ignore[reportUnknownArgumentType]
            raise InvalidFile(path, f"frame {i}: expected {WIDTH} numbers, found {found}")
    try:
        rows = np.array(frames, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidFile(path, f"a frame holds something other than numbers ({error})") from None
    check_finite(path, "Frames", rows)
    return rows


def _forward_kinematics(path: Path, rows: Floats) -> dict[str, Floats]:
    """Joint names to (T, 3) positions in the file's frame."""
    turns = {"root": _quaternions(path, "root", rows[:, 4:8])}
    local: dict[str, Rotation] = {}
    column = 8
    for name, width in JOINTS:
        values = rows[:, column : column + width]
        column += width
        local[name] = _quaternions(path, name, values) if width == 4 else Rotation.from_rotvec(values * (0.0, 0.0, 1.0))
    points = {"root": rows[:, 1:4]}
    for name, (parent, offset) in _OFFSETS.items():
        points[name] = points[parent] + turns[parent].apply(offset)
        turns[name] = turns[parent] * local[name] if name in local else turns[parent]
    return points


def _quaternions(path: Path, name: str, values: Floats) -> Rotation:
    norms = np.linalg.norm(values, axis=1)
    if np.abs(norms - 1).max() > 0.01:
        frame = int(np.argmax(np.abs(norms - 1)))
        raise InvalidFile(path, f"frame {frame}: the quaternion of {name} has length {norms[frame]:.3g}, expected 1")
    return Rotation.from_quat(values, scalar_first=True)
