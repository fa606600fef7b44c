"""A user's own mapping: a small YAML file that says which joint of a file plays which of HumanML3D's 22.

    pelvis: Hips
    spine2: {Spine: 0.5, Spine1: 0.5}     # between two joints
    left_collar:                          # empty: the file has none

Joints of the trunk that the file lacks are interpolated; hips, knees, ankles, feet, shoulders, elbows and wrists must
be there, since nothing else says where limbs are.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, cast

import yaml

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.formats.families import FAMILIES, Family
from ros_free_stack.formats.text import read_text
from ros_free_stack.skeleton import JOINT_NAMES

_TRUNK: Final = {"pelvis": 0.0, "spine1": 0.22, "spine2": 0.48, "spine3": 0.60, "neck": 1.0}
"""Where SMPL's joints lie on the way from pelvis to neck."""

_REPLACEABLE: Final = (*list(_TRUNK)[1:], "head", "left_collar", "right_collar")

_BEFORE: Final = {
    "head": "neck",
    "left_wrist": "left_elbow",
    "right_wrist": "right_elbow",
    "left_foot": "left_ankle",
    "right_foot": "right_ankle",
}
"""The joint before each end of the body."""

UNKNOWN: Final = "FILL_IN"
"""Stands in a proposed mapping for a joint that no name suggests."""

Blend = dict[str, float]


def read_mapping(path: Path, names: Sequence[str]) -> tuple[Family, tuple[str, ...]]:
    """A mapping file as a skeleton, and in words what had to be interpolated.

    Args:
        path: the YAML file.
        names: the joints that the motion file has.

    Raises:
        InvalidFile: the file is unreadable, or lacks a joint that cannot be interpolated.
        UnknownName: it names a joint that is not one of the 22, or one that the motion file lacks.
    """
    try:
        data: object = yaml.safe_load(read_text(path))
    except yaml.YAMLError as error:
        raise InvalidFile(path, f"not a YAML mapping ({' '.join(str(error).split())})") from None
    if not isinstance(data, dict):
        raise InvalidFile(path, "expected lines such as 'pelvis: Hips', one for each joint")
    table: dict[str, Blend] = {}
    for joint, source in cast(dict[Any, Any], data).items():
        if joint not in JOINT_NAMES:
            raise UnknownName(f"joint in {path}", str(joint), JOINT_NAMES)
        if source is not None:
            table[joint] = _blend(path, joint, source, names)
    missing = [joint for joint in JOINT_NAMES if joint not in table]
    needed = [joint for joint in missing if joint not in _REPLACEABLE]
    if needed:
        raise InvalidFile(path, f"says nothing of {', '.join(needed)}, which cannot be interpolated")
    return Family(f"mapping {path.name}", complete(table)), _interpolated(missing)


def complete(table: Mapping[str, Blend]) -> dict[str, Blend]:
    """A mapping with every joint: what is missing lies between its neighbours as it does in SMPL.

    Along the trunk it keeps SMPL's proportions; a neck that is missing is put between the shoulders, a collar at 0.45
    of the way from upper spine to shoulder, a head half as far above the neck as the neck is above the upper spine.
    """
    full = dict(table)
    if "neck" not in full:
        full["neck"] = _mix((full["left_shoulder"], 0.5), (full["right_shoulder"], 0.5))
    for joint, place in _TRUNK.items():
        if joint not in full:
            below = max((name for name in _TRUNK if name in full and _TRUNK[name] < place), key=_TRUNK.__getitem__)
            above = min((name for name in _TRUNK if name in full and _TRUNK[name] > place), key=_TRUNK.__getitem__)
            part = (place - _TRUNK[below]) / (_TRUNK[above] - _TRUNK[below])
            full[joint] = _mix((full[below], 1 - part), (full[above], part))
    if "head" not in full:
        full["head"] = _mix((full["neck"], 1.5), (full["spine3"], -0.5))
    for side in ("left", "right"):
        if f"{side}_collar" not in full:
            full[f"{side}_collar"] = _mix((full["spine3"], 0.55), (full[f"{side}_shoulder"], 0.45))
    return full


def nearest_family(names: Sequence[str]) -> tuple[Family, tuple[str, ...]] | None:
    """The known skeleton that a file has but for some joints, and in words what stands in for them.

    The end site of forearm, foot or neck stands in for a missing hand, toe or head; what else is missing must be of the
    trunk. Of several skeletons the one counts that lacks least.
    """
    found: list[tuple[int, Family, tuple[str, ...]]] = []
    for family in FAMILIES:
        table = {joint: dict(blend) for joint, blend in family.weights.items() if set(blend) <= set(names)}
        lacking = len(JOINT_NAMES) - len(table)
        ends = {joint: f"{name}_end" for joint, before in _BEFORE.items() for name in family.weights[before]}
        ends = {joint: end for joint, end in ends.items() if joint not in table and end in names}
        table |= {joint: {end: 1.0} for joint, end in ends.items()}
        missing = [joint for joint in JOINT_NAMES if joint not in table]
        if set(missing) <= set(_REPLACEABLE) and set(family.marks) <= set(names):
            notes = tuple(f"{joint}: {end} stands in" for joint, end in ends.items()) + _interpolated(missing)
            found.append((lacking, replace(family, weights=complete(table)), notes))
    _, family, notes = min(found, key=lambda item: item[0], default=(0, None, ()))
    return None if family is None else (family, notes)


def template(names: Iterable[str]) -> str:
    """A mapping to start from: each of the 22 joints with the joint of the file whose name suggests it."""
    names = tuple(names)
    lines = [f"{joint}: {_guess(joint, names)}" for joint in JOINT_NAMES]
    return "\n".join([*lines, f"# joints of the file: {', '.join(names)}"])


def unknown_skeleton(path: Path, names: Sequence[str]) -> InvalidFile:
    """The error that shows how to write a mapping."""
    known = ", ".join(family.name for family in FAMILIES)
    return InvalidFile(
        path,
        f"its joints are those of no known skeleton ({known}); correct these lines, save them as mapping.yaml and "
        f"add --mapping mapping.yaml:\n{template(names)}",
    )


def _blend(path: Path, joint: str, source: object, names: Sequence[str]) -> Blend:
    items = cast(dict[Any, Any], source) if isinstance(source, dict) else {str(source): 1.0}
    blend: Blend = {}
    for name, weight in items.items():
        if str(name) not in names:
            raise UnknownName(f"joint (for {joint} in {path})", str(name), names)
        try:
            blend[str(name)] = float(weight)
        except (TypeError, ValueError):
            raise InvalidFile(path, f"{joint}: the weight of {name} is {weight!r}, expected a number") from None
    if abs(sum(blend.values()) - 1) > 1e-6:
        raise InvalidFile(path, f"{joint}: the weights sum to {sum(blend.values()):g}, expected 1")
    return blend


def _interpolated(missing: Sequence[str]) -> tuple[str, ...]:
    return (f"not in the file, interpolated: {', '.join(missing)}",) if missing else ()


def _mix(*parts: tuple[Blend, float]) -> Blend:
    mixed: Blend = {}
    for blend, share in parts:
        for name, weight in blend.items():
            mixed[name] = mixed.get(name, 0.0) + share * weight
    return mixed


def _guess(joint: str, names: Sequence[str]) -> str:
    """The file's joint that a known skeleton would use, by its name without case, marks and side."""
    side, _, part = joint.partition("_") if "_" in joint else ("", "", joint)
    known = {_plain(part)}
    for family in FAMILIES:
        blend = family.weights[joint]
        known.update(_plain(_sided(name)[1]) for name in (blend if len(blend) == 1 else ()))
    sided = {name: _plain(_sided(name)[1]) for name in names if _sided(name)[0] == side[:1]}
    found = sorted((name for name in sided if sided[name] in known), key=lambda name: sided[name] != _plain(part))
    return next(iter(found), "" if joint in _REPLACEABLE else UNKNOWN)


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


def _sided(name: str) -> tuple[str, str]:
    """The side of a joint name ("l", "r" or "") and the name without it: LeftArm, l_arm, lArm, arm.L."""
    first = re.match(r"(?:(left|right)|([lr])(?=[A-Z_. -]))[_. -]*(.+)$", name[:1].lower() + name[1:])
    if first:
        return (first.group(1) or first.group(2))[0], first.group(3)
    last = re.match(r"(.+?)[_. -](left|right|l|r)$", name.lower())
    return (last.group(2)[0], last.group(1)) if last else ("", name)
