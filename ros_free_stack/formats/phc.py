"""Pickles of clips: PHC (Luo et al., ICCV 2023) and its descendants, AIST++, WHAM and other models of people in video.

A dictionary of names to clips, or one clip. A robot's clip: root_trans_offset (T, 3) m, root_rot (T, 4) xyzw, dof
(T, J) rad, fps. A human's: poses of SMPL, under the names of `smpl_poses`, which need a skeleton, or joints' places.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.joint_arrays import has_joints, joints_source
from ros_free_stack.formats.person import Habits
from ros_free_stack.formats.robot_source import RobotArrays, robot_source
from ros_free_stack.formats.safe_pickle import read_pickle
from ros_free_stack.formats.smpl_poses import has_poses, numbers, smpl_source, stated_rate
from ros_free_stack.formats.source import Source, SourceOptions, UpAxis

Entries = Mapping[str, Any]


def read(path: Path, options: SourceOptions) -> Source:
    """One clip: a robot trajectory where it has joint angles of a robot, else human motion.

    Raises:
        UnsafePickle: the pickle names something that is not plain data.
        InvalidFile: it is damaged, or lacks a part.
        InvalidOption: there are several clips and none was named, or a human's without skeleton.
        UnknownName: there is no clip of that name.
    """
    entries = _clip(path, read_pickle(path), options)
    if "dof" in entries:
        return _robot(path, entries, options)
    if has_poses(entries):
        up: UpAxis | None = "y" if "smpl_poses" in entries else "z" if "trans_orig" in entries else None
        return smpl_source(path, entries, options, Habits(title="SMPL poses", up=up, units="m"))
    return joints_source(path, entries, options)


def is_clip(data: object) -> bool:
    """Whether this is a clip of a robot or of a person."""
    if not isinstance(data, Mapping):
        return False
    entries = cast(Entries, data)
    return {"dof", "root_trans_offset"} <= set(entries) or has_poses(entries) or has_joints(entries)


def clips_of(data: object) -> dict[str, Entries]:
    """The clips in what a pickle holds, by name."""
    if is_clip(data):
        return {"": cast(Entries, data)}
    if isinstance(data, list):
        data = dict(enumerate(cast(list[Any], data)))
    if not isinstance(data, Mapping):
        return {}
    return {str(key): clip for key, clip in cast(Mapping[Any, Any], data).items() if is_clip(clip)}


def _clip(path: Path, data: object, options: SourceOptions) -> Entries:
    clips = clips_of(data)
    if not clips:
        raise InvalidFile(path, "no clips; expected a dictionary of names to clips with pose_aa, or dof and root_rot")
    if list(clips) == [""]:  # the clip itself may hold several, which their reader tells apart
        return clips[""]
    if options.clip is None:
        if len(clips) > 1:
            shown = ", ".join(list(clips)[:20]) + (", ..." if len(clips) > 20 else "")
            raise InvalidOption("--clip", f"name one of the {len(clips)} clips of {path}: {shown}")
        return next(iter(clips.values()))
    if options.clip not in clips:
        raise UnknownName(f"clip in {path}", options.clip, clips)
    return clips[options.clip]


def _robot(path: Path, entries: Entries, options: SourceOptions) -> Source:
    missing = [key for key in ("root_trans_offset", "root_rot") if key not in entries]
    if missing:
        raise InvalidFile(path, f"the robot's clip has no {', '.join(missing)}")
    joint_pos = numbers(path, entries, "dof")
    arrays = RobotArrays(
        fps=stated_rate(path, entries),
        root_pos=numbers(path, entries, "root_trans_offset"),
        root_quat=numbers(path, entries, "root_rot"),
        order="xyzw",
        joint_pos=joint_pos[..., 0] if joint_pos.ndim == 3 else joint_pos,
    )
    return robot_source(path, options, arrays)
