"""Robot trajectories as named arrays in `.npz` and `.pkl`, as training code and data sets write them.

Either qpos (T, 7 + J) in MuJoCo's order (holosoma, loco-mujoco); or joint_pos with body_pos_w and body_quat_w of every
body (mjlab, BeyondMimic); or a root's place and quaternion apart from the joints. Joints are taken by name where the
file names them (joint_names), else in the order of the robot's model, which the command says; where the file's bodies
show that the joints come breadth first, as Isaac has them, they are taken so.
"""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.archives import load_npz
from ros_free_stack.formats.robot_names import joint_columns
from ros_free_stack.formats.robot_order import breadth_first
from ros_free_stack.formats.robot_source import UNIT_NORM, RobotArrays, named_robot, robot_source
from ros_free_stack.formats.safe_pickle import read_pickle
from ros_free_stack.formats.smpl_poses import numbers, stated_rate
from ros_free_stack.formats.source import QuaternionOrder, Source, SourceOptions
from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription

Entries = Mapping[str, Any]

_PLACES: Final = (
    *("root_pos", "root_trans", "root_translation", "base_pos", "root_position", "base_position", "root_pos_w"),
    *("root_trans_offset", "global_root_pos", "pelvis_pos", "body_pos", "trans"),
)
_TURNS: Final = (
    *("root_rot", "root_quat", "root_rotation", "base_quat", "base_rot", "root_quat_w", "root_orientation", "root_orn"),
    *("global_root_rot", "pelvis_quat", "root_rot_wxyz", "root_rot_xyzw", "root_quat_wxyz", "root_quat_xyzw"),
)
_JOINTS: Final = (
    *("joint_pos", "dof_pos", "dof", "joint_positions", "dof_positions", "joint_angles", "joint_qpos", "qj", "joints"),
)
_NAMES: Final = ("joint_names", "dof_names", "jnt_names", "joints_list", "joint_order")
_STEPS: Final = ("dt", "timestep", "time_step", "control_dt")


def read(path: Path, options: SourceOptions) -> Source:
    """The robot trajectory in an archive of arrays.

    Raises:
        InvalidFile: a part is missing or does not fit the robot.
        InvalidOption: no robot was named, or the order of quaternions has to be.
    """
    if path.suffix.lower() != ".pkl":
        return arrays_source(path, load_npz(path), options)
    data = read_pickle(path)
    if not isinstance(data, dict):
        raise InvalidFile(path, "no dictionary of arrays")
    return arrays_source(path, cast(Entries, data), options)


def has_robot(entries: Entries) -> bool:
    """Whether these entries may be a robot's trajectory."""
    names = set(entries)
    split = names & set(_PLACES) and names & set(_TURNS) and names & set(_JOINTS)
    return "qpos" in names or bool(split) or {"joint_pos", "body_pos_w", "body_quat_w"} <= names


def arrays_source(path: Path, entries: Entries, options: SourceOptions) -> Source:
    """The robot trajectory in entries that `has_robot`."""
    robot = named_robot(path, options)
    fps = stated_rate(path, entries)
    step = next((name for name in _STEPS if name in entries), None)
    if fps is None and step is not None:
        seconds = numbers(path, entries, step).ravel()
        fps = 1 / float(seconds[0]) if len(seconds) == 1 and seconds[0] > 0 else None
    if "qpos" in entries:
        root_pos, root_quat, joints, order = *_of_qpos(path, entries), options.quaternion or "wxyz"
    elif {"joint_pos", "body_pos_w", "body_quat_w"} <= set(entries):
        root_pos, root_quat, joints, order = *_of_bodies(path, entries), options.quaternion or "wxyz"
    else:
        root_pos, root_quat, joints, order = _of_parts(path, entries, options)
    chosen = _chosen(path, entries, len(joints), options)
    root_pos, root_quat, joints = (values[chosen] for values in (root_pos, root_quat, joints))
    joint_pos, notes = _by_name(path, robot, entries, root_pos, root_quat, joints, order, chosen)
    arrays = RobotArrays(root_pos=root_pos, root_quat=root_quat, order=order, joint_pos=joint_pos, fps=fps, notes=notes)
    return robot_source(path, options, arrays)


def _of_qpos(path: Path, entries: Entries) -> tuple[Floats, Floats, Floats]:
    qpos = _flat(numbers(path, entries, "qpos"), 2)
    if qpos.ndim != 2 or qpos.shape[1] < 8:
        raise InvalidFile(path, f"qpos: expected (T, 7 + joints), found {qpos.shape}")
    return qpos[:, :3], qpos[:, 3:7], qpos[:, 7:]


def _of_bodies(path: Path, entries: Entries) -> tuple[Floats, Floats, Floats]:
    places, turns = (_flat(numbers(path, entries, name), 3) for name in ("body_pos_w", "body_quat_w"))
    if places.ndim != 3 or turns.ndim != 3 or not places.shape[1] or places.shape[:2] != turns.shape[:2]:
        raise InvalidFile(
            path, f"expected body_pos_w (T, B, 3) and body_quat_w (T, B, 4), found {places.shape}, {turns.shape}"
        )
    return places[:, 0], turns[:, 0], _flat(numbers(path, entries, "joint_pos"), 2)


def _of_parts(path: Path, entries: Entries, options: SourceOptions) -> tuple[Floats, Floats, Floats, QuaternionOrder]:
    place, turn, joint = (
        next((name for name in names if name in entries), None) for names in (_PLACES, _TURNS, _JOINTS)
    )
    if place is None or turn is None or joint is None:
        raise InvalidFile(path, f"holds {', '.join(map(str, entries))}; expected qpos, or a root and joint_pos")
    order: QuaternionOrder | None = options.quaternion
    named: QuaternionOrder | None = "wxyz" if turn.endswith("wxyz") else "xyzw" if turn.endswith("xyzw") else None
    if order is None and named is None:
        raise InvalidOption("--quaternion", f"name the order of {turn} in {path}: xyzw (Isaac, scipy) or wxyz (MuJoCo)")
    return (
        _flat(numbers(path, entries, place), 2),
        _flat(numbers(path, entries, turn), 2),
        _flat(numbers(path, entries, joint), 2),
        order or named or "wxyz",
    )


def _chosen(path: Path, entries: Entries, frames: int, options: SourceOptions) -> slice:
    """The frames of one of several clips, as loco-mujoco's `split_points` part them."""
    if "split_points" not in entries:
        if options.clip is not None:
            raise InvalidOption("--clip", f"{path} holds one clip")
        return slice(0, frames)
    points = [int(point) for point in numbers(path, entries, "split_points").ravel()]
    clips = [slice(a, b) for a, b in pairwise(points) if 0 <= a < b <= frames]
    if len(clips) > 1 and options.clip is None:
        problem = f"name one of the {len(clips)} clips of {path} by its number: 0 to {len(clips) - 1}"
        raise InvalidOption("--clip", problem)
    names = [str(number) for number in range(len(clips))]
    if options.clip is not None and options.clip not in names:
        raise UnknownName(f"clip in {path}", options.clip, names[:20])
    return clips[int(options.clip or 0)] if clips else slice(0, frames)


def _by_name(
    path: Path,
    robot: RobotDescription,
    entries: Entries,
    root_pos: Floats,
    root_quat: Floats,
    joints: Floats,
    order: QuaternionOrder,
    chosen: slice,
) -> tuple[Floats, tuple[str, ...]]:
    """(T, J) joints in the robot's order, and how that was told."""
    key = next((name for name in _NAMES if name in entries), None)
    if key is not None:
        names = [_text(name) for name in np.asarray(entries[key]).ravel().tolist()]
        width = joints.shape[1] if joints.ndim == 2 else 0
        if len(names) == width + 1:  # loco-mujoco names the free joint of the root too
            names = names[1:]
        if len(names) != width:
            raise InvalidFile(path, f"{key} names {len(names)} joints, there are {width}")
        places, left = joint_columns(path, names, robot)
        return joints[:, places], (f"joints left out: {', '.join(left[:8])}",) if left else ()
    if joints.ndim == 2 and joints.shape[1] == len(robot.joints) + 7 and _are_unit(joints[:, -4:]):
        note = "the last 7 columns of qpos are an object's pose: left out; joints are taken in the model's order"
        return joints[:, :-7], (note,)
    if "body_pos_w" in entries and joints.ndim == 2 and joints.shape[1] == len(robot.joints):
        bodies = _flat(numbers(path, entries, "body_pos_w"), 3)[chosen]
        turns = root_quat[:, (3, 0, 1, 2)] if order == "xyzw" else root_quat
        places = breadth_first(robot, root_pos, turns, joints, bodies)
        if places is not None:
            return joints[:, places], ("the bodies show that joints come breadth first, as Isaac has them",)
    return joints, ("the file names no joints: they are taken in the order of the robot's model",)


def _are_unit(quaternions: Floats) -> bool:
    return bool((np.abs(np.linalg.norm(quaternions, axis=1) - 1) < UNIT_NORM).all())


def _flat(values: Floats, dimensions: int) -> Floats:
    """Without a leading axis of one clip, and (T, J, 1) as (T, J)."""
    if values.ndim == dimensions + 1 and values.shape[0] == 1:
        return values[0]
    if values.ndim == dimensions + 1 and values.shape[-1] == 1:
        return values[..., 0]
    return values


def _text(name: object) -> str:
    return name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name)
