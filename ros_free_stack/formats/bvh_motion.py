"""Human motion in and out of BVH files.

Reading: the skeleton is known by its joints' names, or by a mapping of the user's. BVH states neither its unit nor
which way is up. The unit is the one in which thigh and shin together measure 0.55 to 1.15 m, as every grown person's
do; among the five units in use no two fit one length. Up is y or z, whichever the mean way from ankles to head clearly
goes along; where that is not clear, as in files of that skeleton usually.

Writing: y up, centimetres, 22 joints, the first frame as rest pose. Where the lengths of bones vary so much that
turning rigid bones would miss a joint by more than 0.05 mm, every joint gets position channels too.
"""

import warnings
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.coherence import leg_length
from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats.asf_amc import INCH
from ros_free_stack.formats.bvh import Bvh, Joint, positions, with_offsets, write_bvh
from ros_free_stack.formats.bvh_reader import read_bvh
from ros_free_stack.formats.families import Family, bare, find_family
from ros_free_stack.formats.frames import LEG_M, from_y_up, stand, to_y_up
from ros_free_stack.formats.mapping import nearest_family, read_mapping, unknown_skeleton
from ros_free_stack.formats.skeleton_map import select
from ros_free_stack.formats.source import Source, SourceOptions, Units, UpAxis, human_source
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import INDEX, JOINT_NAMES, PARENTS

METRES: Final[dict[Units, float]] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": INCH, "cmu": INCH / 0.45}
"""Metres a unit; `cmu` is the length unit of CMU's skeletons."""

UPRIGHT: Final = 2.0
"""How much further from ankles to head it must be along the up axis than along the other one."""

ROUND_FPS: Final = 5e-4
"""Frame times are rounded in files: a rate this close to a whole number is that number."""

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
    names = bare(data.names)
    family, notes = known_skeleton(path, names, options.mapping)
    notes = data.notes + notes
    if len(data.values) <= family.lead:
        raise InvalidFile(path, f"holds {len(data.values)} frames, the first {family.lead} of which are not captured")
    if family.lead:
        notes += (f"the first {family.lead} frames are no capture and left out",)
    joints = select(names, positions(replace(data, values=data.values[family.lead :])), family.weights)
    units = options.units or _guess_units(path, joints)
    up = options.up or _guess_up(path, joints, family)
    notes += (f"skeleton: {family.name}; lengths in {units}, {up} up",)
    joints = METRES[units] * (from_y_up(joints) if up == "y" else joints)
    if not family.placed:
        _check_sides(path, joints)
        joints = stand(joints)
    fps = options.source_fps or data.fps
    fps = float(round(fps)) if abs(fps - round(fps)) < ROUND_FPS * fps else fps
    return human_source(path, joints, fps, notes)


def known_skeleton(path: Path, names: tuple[str, ...], mapping: Path | None) -> tuple[Family, tuple[str, ...]]:
    """The skeleton of a file by the user's mapping or by its joints' names, with what has to be said of it."""
    if mapping is not None:
        return read_mapping(mapping, names)
    family = find_family(names)
    if family is not None:
        return family, ()
    nearest = nearest_family(names)
    if nearest is None:
        raise unknown_skeleton(path, names)
    return nearest


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


def _guess_units(path: Path, joints: Floats) -> Units:
    length = leg_length(joints)
    for unit, metres in METRES.items():
        if LEG_M[0] <= metres * length <= LEG_M[1]:
            return unit
    raise InvalidOption(
        "--units",
        f"name the unit of {path} ({', '.join(METRES)}): its legs measure {length:.4g}, a person's in none of them",
    )


def _guess_up(path: Path, joints: Floats, family: Family) -> UpAxis:
    """The axis that the person stands along; that of the skeleton's own files where the person only lies."""
    ankles = joints[:, [INDEX["left_ankle"], INDEX["right_ankle"]]].mean(axis=1)
    _, y, z = np.abs((joints[:, INDEX["head"]] - ankles).mean(axis=0))
    if max(y, z) >= UPRIGHT * min(y, z):
        return "y" if y > z else "z"
    if family.up is None:
        raise InvalidOption("--up", f"name the up axis of {path} (y or z): it cannot be told from how the person lies")
    return family.up


def _check_sides(path: Path, joints: Floats) -> None:
    """InvalidFile where left and right are swapped: up, the way of the toes and left no longer make a right hand."""
    across = joints[:, INDEX["left_hip"]] - joints[:, INDEX["right_hip"]]
    up = joints[:, INDEX["neck"]] - joints[:, INDEX["pelvis"]]
    feet, ankles = ([INDEX[f"{side}_{part}"] for side in ("left", "right")] for part in ("foot", "ankle"))
    toes = (joints[:, feet] - joints[:, ankles]).sum(axis=1)
    if np.sum(np.cross(up, toes) * across) < 0:
        raise InvalidFile(path, "the toes point backwards: left and right are swapped")


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
