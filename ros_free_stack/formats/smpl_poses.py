"""Poses of the SMPL family under the names that data sets and programs give them.

Rotations: poses, pose_aa, smpl_poses and others (T, 66 or more), also as (T, J, 3) or rotation matrices (T, J, 3, 3);
or those of the root (root_orient, global_orient) and of the body (pose_body, body_pose) apart. Places: trans, transl,
trans_orig, smpl_trans and others (T, 3) m. Shape: betas or beta (B,), also once a frame. smpl_scaling (AIST++) divides
places. A leading axis of one batch is dropped.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, cast

import numpy as np
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.smpl import posed_joints, rest_joints
from ros_free_stack.formats.source import Source, SourceOptions, check_finite
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import JOINT_COUNT

_WHOLE: Final = ("poses", "pose_aa", "smpl_poses", "fullpose", "full_pose", "pose_world", "smpl_pose", "pose", "thetas")
_ROOT: Final = ("root_orient", "global_orient", "smpl_global_orient")
_BODY: Final = ("pose_body", "body_pose", "smpl_body_pose")
_PLACE: Final = ("trans", "transl", "trans_orig", "smpl_trans", "trans_world", "translation", "root_trans")
_SHAPE: Final = ("betas", "beta", "smpl_betas", "shape")
RATES: Final = ("fps", "mocap_framerate", "mocap_frame_rate", "mocap_fps", "framerate", "frame_rate", "frequency")
"""Names under which files state their frames a second."""

Entries = Mapping[str, Any]


@dataclass(frozen=True)
class SmplClip:
    """Rotation vectors (T, 22, 3), places of the root (T, 3) m, shape numbers (B,), the stated rate if there is one."""

    rotations: Floats
    places: Floats
    betas: Floats
    fps: float | None
    notes: tuple[str, ...] = ()


def has_poses(entries: Entries) -> bool:
    """Whether these entries are a person's poses."""
    names = set(entries)
    return bool(names & set(_WHOLE)) or bool(names & set(_ROOT) and names & set(_BODY))


def read_clip(path: Path, entries: Entries) -> SmplClip:
    """The poses in a file's entries.

    Raises:
        InvalidFile: they lack a part, or parts do not fit together.
    """
    poses = _rotations(path, entries)
    name = _first(entries, _PLACE)
    notes: tuple[str, ...] = ()
    if name is None:
        places = np.zeros((len(poses), 3))
        notes = ("the file says nothing of where the person is: the pelvis stays in place",)
    else:
        places = _batch_dropped(numbers(path, entries, name), 2)
        if places.shape != (len(poses), 3):
            raise InvalidFile(path, f"{name}: expected ({len(poses)}, 3), a row for each pose, found {places.shape}")
        check_finite(path, name, places)
    if "smpl_scaling" in entries:
        scale = numbers(path, entries, "smpl_scaling").ravel()
        if len(scale) != 1 or not scale[0] > 0:
            raise InvalidFile(path, f"smpl_scaling: expected one positive number, found {scale[:5]}")
        places = places / scale[0]
    check_finite(path, "poses", poses)
    shape = _first(entries, _SHAPE)
    betas = np.empty(0) if shape is None else numbers(path, entries, shape)
    betas = betas.reshape(-1, betas.shape[-1]).mean(axis=0) if betas.ndim > 1 and betas.size else betas.ravel()
    return SmplClip(poses, places, betas, stated_rate(path, entries), notes)


def smpl_source(path: Path, entries: Entries, options: SourceOptions, habits: Habits) -> Source:
    """The human motion in a file's entries; `--skeleton` gives the lengths of the bones."""
    clip = read_clip(path, entries)
    joints = posed_joints(rest_joints(path, options.skeleton, clip.betas), clip.rotations, clip.places)
    return person_source(path, joints, options, habits, fps=clip.fps, notes=clip.notes)


def stated_rate(path: Path, entries: Entries) -> float | None:
    """The frame rate that entries state, under whatever name, if they do."""
    name = _first(entries, RATES)
    if name is None:
        return None
    values = numbers(path, entries, name).ravel()
    if len(values) != 1:
        raise InvalidFile(path, f"{name} is {entries[name]!r}, expected a number")
    return float(values[0])


def numbers(path: Path, entries: Entries, name: str) -> Floats:
    """An entry as an array of numbers, or InvalidFile."""
    try:
        return np.asarray(entries[name], dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InvalidFile(path, f"{name} is no array of numbers ({error})") from None


def _rotations(path: Path, entries: Entries) -> Floats:
    """(T, 22, 3) rotation vectors."""
    whole = _first(entries, _WHOLE)
    root, body = _first(entries, _ROOT), _first(entries, _BODY)
    if root is not None and body is not None:
        first, rest = (_vectors(path, name, numbers(path, entries, name)) for name in (root, body))
        if len(first) != len(rest) or first.shape[1] != 1:
            raise InvalidFile(path, f"expected {root} (T, 3) and {body} (T, 63), found {first.shape}, {rest.shape}")
        return _enough(path, f"{root} and {body}", np.concatenate([first, rest], axis=1))
    if whole is None:
        raise InvalidFile(path, "has neither poses nor root_orient with pose_body")
    return _enough(path, whole, _vectors(path, whole, numbers(path, entries, whole)))


def _enough(path: Path, name: str, vectors: Floats) -> Floats:
    if vectors.shape[1] < JOINT_COUNT or not len(vectors):
        found = f"({len(vectors)}, {3 * vectors.shape[1]})"
        raise InvalidFile(path, f"{name}: expected (T, {3 * JOINT_COUNT} or more) rotation vectors, found {found}")
    return vectors[:, :JOINT_COUNT]


def _vectors(path: Path, name: str, values: Floats) -> Floats:
    """(T, J, 3) rotation vectors of (T, 3 J), (T, J, 3) or rotation matrices (T, J, 3, 3)."""
    if not values.size:
        raise InvalidFile(path, f"{name}: no frames, found {values.shape}")
    while values.ndim > 2 and values.shape[0] == 1 and values.shape[-2:] != (1, 3):
        values = values[0]
    if values.ndim == 4 and values.shape[2:] == (3, 3):
        check_finite(path, name, values)
        return Rotation.from_matrix(values.reshape(-1, 3, 3)).as_rotvec().reshape(*values.shape[:2], 3)
    if values.ndim == 3 and values.shape[2] == 3:
        return values
    if values.ndim == 2 and values.shape[1] % 3 == 0:
        return values.reshape(len(values), -1, 3)
    raise InvalidFile(path, f"{name}: expected (T, {3 * JOINT_COUNT} or more) rotation vectors, found {values.shape}")


def _batch_dropped(values: Floats, dimensions: int) -> Floats:
    while values.ndim > dimensions and 1 in values.shape[:2]:
        values = values[0] if values.shape[0] == 1 else values[:, 0]
    return values


def _first(entries: Entries, names: tuple[str, ...]) -> str | None:
    return next((name for name in names if name in entries and cast(object, entries[name]) is not None), None)
