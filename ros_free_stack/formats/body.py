"""Whether 22 joints are a person's: limbs have a length, sides match, left is left."""

from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import INDEX

SHORTEST: Final = {"knee": 0.2, "ankle": 0.2, "foot": 0.03, "elbow": 0.08, "wrist": 0.08}
"""Least length of the bone that ends at a joint, over that of the leg; an average person has 3 to 5 times as much."""
LEAST_TRUNK: Final = 0.2
UNEQUAL: Final = 1.6
"""Most length of a limb's bone over that of the other side."""
STRETCH: Final = 0.3
"""Most change of a limb's bone over its own length in half of the frames: bones are bones."""

BACKWARDS: Final = -0.2
"""Mean product of the ways up, left and of the toes, 1 for a person who stands: contortions come near 0."""

_LIMBS: Final = (("hip", "knee", "ankle", "foot"), ("shoulder", "elbow", "wrist"))
_STRAIGHT: Final = 0.94
"""Cosine of 20 degrees."""


def check_body(path: Path, joints: Floats) -> None:
    """InvalidFile where (T, 22, 3) joints, in any unit, z up, cannot be a person's."""
    bones = {joint: _lengths(joints, first, joint) for joint, first in _bones()}
    sizes = {joint: float(np.median(lengths)) for joint, lengths in bones.items()}
    leg = (sum(sizes[f"{side}_{name}"] for side in ("left", "right") for name in ("knee", "ankle"))) / 2
    for joint, first in _bones():
        size = sizes[joint]
        if size <= SHORTEST[joint.partition("_")[2]] * leg:
            share = f"{100 * size / leg:.2g} % of the leg" if leg > 0 else "no length"
            problem = f"{first} and {joint} lie together ({share} apart): are they mapped to the right joints?"
            raise InvalidFile(path, problem)
    for joint, first in _bones():
        side, _, name = joint.partition("_")
        size, other = sizes[joint], sizes[f"{'right' if side == 'left' else 'left'}_{name}"]
        if size > UNEQUAL * other:
            problem = f"from {first} to {joint} it is {size / other:.2g} times as far as on the other side"
            raise InvalidFile(path, f"{problem}: are they mapped to the right joints?")
        if np.median(np.abs(bones[joint] - size)) > STRETCH * size:
            raise InvalidFile(
                path, f"the bone from {first} to {joint} changes its length: these are no joints of a person"
            )
    if float(np.median(_lengths(joints, "pelvis", "neck"))) < LEAST_TRUNK * leg:
        raise InvalidFile(path, "pelvis and neck lie together: are they mapped to the right joints?")
    _check_sides(path, joints)


def is_t_pose(joints: Floats) -> bool:
    """Whether (22, 3) joints show the pose of calibration: arms straight out to the sides, legs straight."""
    across = _unit(joints[INDEX["left_shoulder"]] - joints[INDEX["right_shoulder"]])
    up = _unit(joints[INDEX["neck"]] - joints[INDEX["pelvis"]])
    for side, sign in (("left", 1), ("right", -1)):
        for a, b in pairwise(("shoulder", "elbow", "wrist")):
            if sign * across @ _unit(joints[INDEX[f"{side}_{b}"]] - joints[INDEX[f"{side}_{a}"]]) < _STRAIGHT:
                return False
        for a, b in pairwise(("hip", "knee", "ankle")):
            if up @ _unit(joints[INDEX[f"{side}_{a}"]] - joints[INDEX[f"{side}_{b}"]]) < _STRAIGHT:
                return False
    return True


def _bones() -> list[tuple[str, str]]:
    """Joints of the limbs and the ones before them."""
    return [
        (f"{side}_{joint}", f"{side}_{first}")
        for side in ("left", "right")
        for limb in _LIMBS
        for first, joint in pairwise(limb)
    ]


def _check_sides(path: Path, joints: Floats) -> None:
    """InvalidFile where left and right are swapped: up, the way of the toes and left no longer make a right hand."""
    across = joints[:, INDEX["left_hip"]] - joints[:, INDEX["right_hip"]]
    up = joints[:, INDEX["neck"]] - joints[:, INDEX["pelvis"]]
    feet, ankles = ([INDEX[f"{side}_{part}"] for side in ("left", "right")] for part in ("foot", "ankle"))
    toes = (joints[:, feet] - joints[:, ankles]).sum(axis=1)
    sizes = np.prod([np.linalg.norm(way, axis=1) for way in (across, up, toes)], axis=0)
    if np.mean(np.sum(np.cross(up, toes) * across, axis=1) / np.maximum(sizes, 1e-12)) < BACKWARDS:
        raise InvalidFile(path, "the toes point backwards: left and right are swapped")


def _lengths(joints: Floats, first: str, second: str) -> Floats:
    """(T,) distances of two joints."""
    return np.linalg.norm(joints[:, INDEX[second]] - joints[:, INDEX[first]], axis=1)


def _unit(vector: Floats) -> Floats:
    return vector / max(float(np.linalg.norm(vector)), 1e-12)
