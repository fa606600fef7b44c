"""The SMPL family's skeleton: rest joints from a file that the user has, and forward kinematics of the first 22 joints.

SMPL, SMPL-H and SMPL-X share those joints and their tree (HumanML3D took them over). Their model files are licensed and
not part of this project. Two kinds of file serve:

* a model `.npz` as published, with `J_regressor` (J, V), `v_template` (V, 3) and `shapedirs` (V, 3, B): rest joints
  follow the shape numbers of the motion (Loper et al., SIGGRAPH Asia 2015, equation 10);
* a `.json` of 22 names to rest positions in m, y up, in the T-pose: one body, whatever the shape numbers.
"""

import json
import zipfile
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats.stature import stature
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import JOINT_COUNT, JOINT_NAMES, PARENTS

REST_TALL_M = (0.4, 3.0)
"""Statures of bodies at rest, from a small child to a giant, m."""

_PARTS = ("J_regressor", "v_template", "shapedirs")


def rest_joints(motion: Path, skeleton: Path | None, betas: Floats) -> Floats:
    """(22, 3) joints of the rest pose in m, y up.

    Args:
        motion: the motion file, for the error.
        skeleton: the user's file; None raises an error that says what to supply.
        betas: (B,) shape numbers of the motion.

    Raises:
        InvalidOption: no skeleton was named.
        InvalidFile: the skeleton is unreadable or lacks a part.
    """
    if skeleton is None:
        raise InvalidOption(
            "--skeleton",
            f"{motion} holds rotations but no bone lengths: name an SMPL, SMPL-H or SMPL-X model .npz "
            "(with J_regressor, v_template, shapedirs) or a .json of the 22 rest joints in m; docs/formats.md has one",
        )
    joints = _from_json(skeleton) if skeleton.suffix == ".json" else _from_model(skeleton, betas)
    if not np.isfinite(joints).all():
        raise InvalidFile(skeleton, "rest joints that are not finite")
    tall = stature(joints[None])
    if not REST_TALL_M[0] <= tall <= REST_TALL_M[1]:
        raise InvalidFile(skeleton, f"rest joints of a person {tall:.3g} m tall: are they in m?")
    return joints


def posed_joints(rest: Floats, rotations: Floats, translation: Floats) -> Floats:
    """(T, 22, 3) joints in the frame of the translation.

    Args:
        rest: (22, 3) rest joints.
        rotations: (T, 22, 3) rotation vectors, each relative to the parent.
        translation: (T, 3); the root lies at its rest position plus this.
    """
    local = Rotation.from_rotvec(rotations.reshape(-1, 3)).as_matrix().reshape(-1, JOINT_COUNT, 3, 3)
    turns, points = np.empty_like(local), np.empty((len(local), JOINT_COUNT, 3))
    turns[:, 0], points[:, 0] = local[:, 0], rest[0] + translation
    for joint in range(1, JOINT_COUNT):
        parent = PARENTS[joint]
        turns[:, joint] = turns[:, parent] @ local[:, joint]
        points[:, joint] = points[:, parent] + turns[:, parent] @ (rest[joint] - rest[parent])
    return points


def _from_json(path: Path) -> Floats:
    try:
        data: Any = json.loads(path.read_text(encoding="utf-8"))
        joints = np.array([data[name] for name in JOINT_NAMES], dtype=np.float64)
    except OSError as error:
        raise InvalidFile(path, f"cannot be read: {error.strerror}") from None
    except KeyError as error:
        raise InvalidFile(path, f"no rest joint {error}; expected {', '.join(JOINT_NAMES)}") from None
    except (ValueError, TypeError) as error:
        raise InvalidFile(path, f"not a JSON object of joint names to [x, y, z] ({error})") from None
    if joints.shape != (JOINT_COUNT, 3):
        raise InvalidFile(path, f"expected three numbers a joint, found {joints.shape[1:]}")
    return joints


def _from_model(path: Path, betas: Floats) -> Floats:
    """Only plain arrays are read; model files also hold pickled objects, which stay untouched."""
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    try:
        with np.load(path, allow_pickle=False) as archive:
            missing = [part for part in _PARTS if part not in archive.files]
            if missing:
                raise InvalidFile(path, f"has no {', '.join(missing)}; expected an SMPL model")
            regressor, template, shapes = (np.asarray(archive[part], dtype=np.float64) for part in _PARTS)
    except (ValueError, OSError, EOFError, KeyError, TypeError, zipfile.BadZipFile, zlib.error) as error:
        raise InvalidFile(path, f"not an SMPL model of plain arrays ({error})") from None
    count = min(len(betas), shapes.shape[-1]) if shapes.ndim == 3 else -1
    if count < 0 or template.shape != shapes.shape[:2] or regressor.shape[1:] != template.shape[:1]:
        sizes = (array.shape for array in (regressor, template, shapes))
        found = ", ".join(f"{part} {size}" for part, size in zip(_PARTS, sizes, strict=True))
        raise InvalidFile(path, f"parts that do not fit together: {found}")
    if len(regressor) < JOINT_COUNT:
        raise InvalidFile(path, f"{len(regressor)} joints, expected at least {JOINT_COUNT}")
    vertices = template + shapes[..., :count] @ betas[:count]
    return regressor[:JOINT_COUNT] @ vertices
