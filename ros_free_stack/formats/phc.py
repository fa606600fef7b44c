"""Pickles of PHC (Luo et al., ICCV 2023) and its descendants: a dictionary of clip names to clips, written by joblib.

A robot's clip: root_trans_offset (T, 3) m, root_rot (T, 4) xyzw, dof (T, J) rad, fps. A human's: pose_aa (T, 72)
rotation vectors of SMPL in a z-up world, trans_orig (T, 3) m, beta (B,), fps; it needs a skeleton, as AMASS does.
"""

from pathlib import Path
from typing import Any, cast

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.gmr import array, rate
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.robot_source import robot_source
from ros_free_stack.formats.safe_pickle import read_pickle
from ros_free_stack.formats.smpl import posed_joints, rest_joints
from ros_free_stack.formats.source import Source, SourceOptions, check_finite
from ros_free_stack.skeleton import JOINT_COUNT


def read(path: Path, options: SourceOptions) -> Source:
    """One clip: a robot trajectory where it has joint angles of a robot, else human motion.

    Raises:
        UnsafePickle: the pickle names something that is not plain data.
        InvalidFile: it is damaged, or lacks a part.
        InvalidOption: there are several clips and none was named, or a human's without skeleton.
        UnknownName: there is no clip of that name.
    """
    entry = _clip(path, read_pickle(path), options.clip)
    fps = rate(path, entry) if "fps" in entry else None
    if "dof" in entry:
        return _robot(path, entry, fps, options)
    return _human(path, entry, fps, options)


def is_clip(data: object) -> bool:
    """Whether this is one of PHC's clips."""
    return isinstance(data, dict) and ("pose_aa" in data or {"dof", "root_trans_offset"} <= data.keys())


def _clip(path: Path, data: object, name: str | None) -> dict[str, Any]:
    clips: dict[str, Any] = {}
    if isinstance(data, dict):
        clips = {str(key): clip for key, clip in cast(dict[Any, Any], data).items() if is_clip(clip)}
    if not clips:
        raise InvalidFile(path, "no clips; expected a dictionary of names to clips with pose_aa, or dof and root_rot")
    if name is None:
        if len(clips) > 1:
            shown = ", ".join(list(clips)[:20]) + (", ..." if len(clips) > 20 else "")
            raise InvalidOption("--clip", f"name one of the {len(clips)} clips of {path}: {shown}")
        return next(iter(clips.values()))
    if name not in clips:
        raise UnknownName(f"clip in {path}", name, clips)
    return clips[name]


def _robot(path: Path, entry: dict[str, Any], fps: float | None, options: SourceOptions) -> Source:
    missing = [key for key in ("root_trans_offset", "root_rot") if key not in entry]
    if missing:
        raise InvalidFile(path, f"the robot's clip has no {', '.join(missing)}")
    joint_pos = array(path, entry, "dof")
    return robot_source(
        path,
        options,
        fps=fps,
        root_pos=array(path, entry, "root_trans_offset"),
        root_quat=array(path, entry, "root_rot"),
        order="xyzw",
        joint_pos=joint_pos[..., 0] if joint_pos.ndim == 3 else joint_pos,
    )


def _human(path: Path, entry: dict[str, Any], fps: float | None, options: SourceOptions) -> Source:
    if "trans_orig" not in entry:
        raise InvalidFile(path, "the human's clip has no trans_orig")
    poses, trans = array(path, entry, "pose_aa"), array(path, entry, "trans_orig")
    poses = poses.reshape(len(poses), -1) if poses.ndim > 1 else poses
    if poses.ndim != 2 or poses.shape[1] < 3 * JOINT_COUNT or trans.shape != (len(poses), 3) or not len(poses):
        raise InvalidFile(path, f"expected pose_aa (T, 72) and trans_orig (T, 3), found {poses.shape}, {trans.shape}")
    check_finite(path, "pose_aa", poses)
    check_finite(path, "trans_orig", trans)
    betas = array(path, entry, "beta").ravel() if "beta" in entry else np.empty(0)
    rest = rest_joints(path, options.skeleton, betas)
    rotations = poses[:, : 3 * JOINT_COUNT].reshape(-1, JOINT_COUNT, 3)
    habits = Habits(title="PHC", up="z", units="m")
    return person_source(path, posed_joints(rest, rotations, trans), options, habits, fps=fps)
