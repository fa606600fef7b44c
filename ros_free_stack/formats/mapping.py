"""A user's own mapping: a small YAML file that says which joint of a file plays which of HumanML3D's 22.

    pelvis: Hips
    spine2: {Spine: 0.5, Spine1: 0.5}     # between two joints
    left_collar:                          # empty: the file has none

Joints of the trunk that the file lacks are interpolated; hips, knees, ankles, feet, shoulders, elbows and wrists must
be there, since nothing else says where limbs are.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from pathlib import Path
from typing import Any, Final, cast

import yaml

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.formats.families import ASF_FAMILIES, FAMILIES, Family, bare, prefixes
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

SHOWN: Final = 200
"""Names of joints that the template lists."""

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
    for first, second in combinations(table, 2):
        if table[first] == table[second]:
            same = ", ".join(table[first])
            raise InvalidFile(path, f"{first} and {second} are both {same}: each joint plays one role")
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


def with_ends(table: dict[str, Blend], names: Sequence[str]) -> tuple[dict[str, Blend], tuple[str, ...]] | None:
    """A table that lacks some joints, made whole, and in words what stands in; None where a limb's joint is missing.

    The end site of forearm, foot or neck stands in for a missing hand, toe or head; what else is missing must be of the
    trunk.
    """
    notes: tuple[str, ...] = ()
    whole = dict(table)
    for joint, before in _BEFORE.items():
        (name,) = whole.get(before, {}) if len(whole.get(before, {})) == 1 else ("",)
        if joint not in whole and f"{name}_end" in names:
            whole[joint] = {f"{name}_end": 1.0}
            notes += (f"{joint}: {name}_end stands in",)
    missing = [joint for joint in JOINT_NAMES if joint not in whole]
    if not set(missing) <= set(_REPLACEABLE):
        return None
    return complete(whole), notes + _interpolated(missing)


def nearest_family(
    names: Sequence[str], families: Sequence[Family] = FAMILIES
) -> tuple[Family, tuple[str, ...]] | None:
    """The known skeleton that a file has but for some joints, and in words what stands in for them.

    Of several skeletons the one counts that lacks least.
    """
    found: list[tuple[int, Family, tuple[str, ...]]] = []
    for plain in families:
        for family in (plain.with_prefix(prefix) for prefix in prefixes(plain, names)):
            if not set(family.marks) <= set(names):
                continue
            table = {joint: dict(blend) for joint, blend in family.weights.items() if set(blend) <= set(names)}
            whole = with_ends(table, names)
            if whole is not None:
                found.append((len(JOINT_NAMES) - len(table), replace(family, weights=whole[0]), whole[1]))
    _, family, notes = min(found, key=lambda item: item[0], default=(0, None, ()))
    return None if family is None else (family, notes)


def template(names: Sequence[str], roles: Mapping[str, Blend]) -> str:
    """A mapping to start from: each of the 22 joints with the joints of the file that surely play it."""
    rows: list[str] = []
    for joint in JOINT_NAMES:
        blend = roles.get(joint)
        if blend is None:
            rows.append(f"{joint}: {'' if joint in _REPLACEABLE else UNKNOWN}".rstrip())
        else:
            single = len(blend) == 1
            row = {joint: next(iter(blend)) if single else dict(blend)}
            style = False if single else None
            rows.append(yaml.safe_dump(row, allow_unicode=True, width=10**6, default_flow_style=style).strip())
    more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
    return "\n".join([*rows, f"# joints of the file: {', '.join(names[:SHOWN])}{more}"])


def unknown_skeleton(path: Path, names: Sequence[str], roles: Mapping[str, Blend]) -> InvalidFile:
    """The error that shows how to write a mapping."""
    known = ", ".join(family.name for family in (*FAMILIES, *ASF_FAMILIES))
    return InvalidFile(
        path,
        f"its joints are those of no known skeleton ({known}); correct these lines, save them as mapping.yaml and "
        f"add --mapping mapping.yaml:\n{template(names, roles)}",
    )


def _blend(path: Path, joint: str, source: object, names: Sequence[str]) -> Blend:
    items = cast(dict[Any, Any], source) if isinstance(source, dict) else {str(source): 1.0}
    blend: Blend = {}
    short = dict(zip(bare(names), names, strict=True))
    for written, weight in items.items():
        name = str(written) if str(written) in names else short.get(str(written), "")
        if not name:
            raise UnknownName(f"joint (for {joint} in {path})", str(written), names)
        if list(names).count(name) > 1:
            raise InvalidFile(path, f"{joint}: several joints of the file are named {name}")
        try:
            blend[name] = float(weight)
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
