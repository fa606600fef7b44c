"""Human motion in and out of BVH files.

Reading: the skeleton is known by its joints' names, or by a mapping of the user's. BVH states neither its unit nor
which way is up: both are told by the person.

Writing: y up, centimetres, 22 joints, the first frame as rest pose. Where the lengths of bones vary so much that
turning rigid bones would miss a joint by more than 0.05 mm, every joint gets position channels too.
"""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.formats.bvh import Bvh, Joint, positions, with_offsets, write_bvh
from ros_free_stack.formats.bvh_reader import read_bvh
from ros_free_stack.formats.frames import to_y_up
from ros_free_stack.formats.joint_roles import Tree
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.rigs import skeleton_of
from ros_free_stack.formats.skeleton_map import select
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.formats.upright import standing_axis
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import JOINT_NAMES, PARENTS

RIGID_M: Final = 5e-5
END: Final = 0.5
"""An end site goes on in its bone's direction by this share of its length; programs draw the last bones by it."""

_TURNS: Final = ("Zrotation", "Yrotation", "Xrotation")
_MOVES: Final = ("Xposition", "Yposition", "Zposition")


def read(path: Path, options: SourceOptions) -> Source:
    """The human motion in a BVH file.

    Raises:
        InvalidFile: the file is damaged, or its skeleton is unknown (the message shows how to write a mapping).
        InvalidOption: unit or up axis cannot be told from the motion.
        UnknownName: the mapping names a joint that is not there.
    """
    data = with_offsets(read_bvh(path))
    tree = Tree(
        names=data.names,
        parents=tuple(joint.parent for joint in data.joints),
        lengths=tuple(float(np.linalg.norm(joint.offset)) for joint in data.joints),
    )
    (family, notes), joints = skeleton_of(path, tree, mapping=options.mapping, clip=options.clip)
    needed = {name for blend in family.weights.values() for name in blend}
    joints = [joint for joint in joints if data.names[joint] in needed]
    names = [data.names[joint] for joint in joints]

    def person(bvh: Bvh) -> Floats:
        return select(names, positions(bvh, joints), family.weights)

    rest = standing_axis(person(replace(data, values=np.zeros((1, data.values.shape[1])))))
    habits = Habits(
        title=family.name,
        up=family.up,
        rest="y" if rest == "y" else "z" if rest == "z" else None,
        stood=family.placed,
        told=True,
    )
    return person_source(path, person(data), options, habits, fps=data.fps, notes=data.notes + notes)


def write(path: Path, motion: HumanMotion) -> tuple[str, ...]:
    """Write a human motion as BVH; says in words whether joints had to get position channels."""
    joints = to_y_up(100 * np.asarray(motion.joints))
    turns = _bone_turns(joints)
    local = np.stack([_to_parent(turns, joint, turns[:, joint]) for joint in range(len(JOINT_NAMES))], axis=1)
    steps = np.stack([_step(joints, turns, joint) for joint in range(len(JOINT_NAMES))], axis=1)
    rigid = bool((np.abs(steps[:, 1:] - steps[:1, 1:]) < 100 * RIGID_M).all())
    angles = _angles(local)
    skeleton: list[Joint] = []
    columns: list[Floats] = []
    place: dict[int, int] = {-1: -1}
    for joint in _depth_first():
        moves = joint == 0 or not rigid
        offset = np.zeros(3) if joint == 0 else steps[0, joint]
        place[joint] = len(skeleton)
        skeleton.append(
            Joint(JOINT_NAMES[joint], place[PARENTS[joint]], offset, (*_MOVES, *_TURNS) if moves else _TURNS)
        )
        columns += [steps[:, joint]] * moves + [angles[:, joint]]
        if not _children(joint):
            skeleton.append(Joint(f"{JOINT_NAMES[joint]}_end", place[joint], END * offset, ()))
    write_bvh(path, Bvh(tuple(skeleton), np.concatenate(columns, axis=1), motion.fps))
    return () if rigid else ("bone lengths vary: every joint has position channels",)


def _children(joint: int) -> list[int]:
    return [child for child, parent in enumerate(PARENTS) if parent == joint]


def _depth_first(joint: int = 0) -> list[int]:
    return [joint, *(item for child in _children(joint) for item in _depth_first(child))]


def _bone_turns(joints: Floats) -> Floats:
    """(T, 22, 3, 3) world orientations of joints; the identity at the first frame.

    A joint with several children turns as fits them best (Kabsch); one with a single child turns from its parent's
    orientation by the shortest way; one without keeps its parent's.
    """
    turns = np.empty((*joints.shape, 3))
    for joint in _depth_first():
        children = _children(joint)
        before = turns[:, PARENTS[joint]] if joint else np.broadcast_to(np.eye(3), (len(joints), 3, 3))
        bones = joints[:, children] - joints[:, [joint]]
        if len(children) > 1:
            turns[:, joint] = _best_turn(bones[0], bones)
        elif children:
            turns[:, joint] = _shortest_turn(before @ bones[0, 0], bones[:, 0]) @ before
        else:
            turns[:, joint] = before
    return turns


def _best_turn(rest: Floats, bones: Floats) -> Floats:
    """(T, 3, 3) rotations that bring (K, 3) vectors nearest to (T, K, 3) ones."""
    left, _, right = np.linalg.svd(np.einsum("tki,kj->tij", bones, rest))
    left[..., -1] *= np.linalg.det(left @ right)[:, None]
    return left @ right


def _shortest_turn(start: Floats, end: Floats) -> Floats:
    """(T, 3, 3) smallest rotations from (T, 3) directions to others."""
    axis = np.cross(start, end)
    sine = np.linalg.norm(axis, axis=-1)
    angle = np.arctan2(sine, (start * end).sum(axis=-1))
    across = np.cross(start, np.eye(3)[np.argmin(np.abs(start), axis=-1)])  # for opposite directions
    axis = np.where(sine[:, None] > 1e-12 * (start**2).sum(-1, keepdims=True), axis, across)
    axis /= np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-12)
    return Rotation.from_rotvec(angle[:, None] * axis).as_matrix()


def _to_parent(turns: Floats, joint: int, values: Floats) -> Floats:
    return values if joint == 0 else turns[:, PARENTS[joint]].swapaxes(-1, -2) @ values


def _step(joints: Floats, turns: Floats, joint: int) -> Floats:
    """(T, 3) place of a joint seen from its parent, or in the world for the root."""
    if joint == 0:
        return joints[:, 0]
    return _to_parent(turns, joint, (joints[:, joint] - joints[:, PARENTS[joint]])[..., None])[..., 0]


def _angles(local: Floats) -> Floats:
    """(T, J, 3) degrees about z, y, x."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # at gimbal lock any of the equal angles will do
        flat = Rotation.from_matrix(local.reshape(-1, 3, 3)).as_euler("ZYX", degrees=True)
    return flat.reshape(*local.shape[:2], 3)
