"""Whose skeleton a file holds: by the user's mapping, by the names of known rigs, or by what any rig's names say."""

from dataclasses import replace
from pathlib import Path

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.families import ASF_FAMILIES, Family, find_family
from ros_free_stack.formats.joint_roles import Blend, Tree, find_roles
from ros_free_stack.formats.mapping import nearest_family, read_mapping, unknown_skeleton, with_ends
from ros_free_stack.skeleton import JOINT_NAMES

DEEPEST = 20
"""So many joints of scenery may lie above a person."""

Known = tuple[Family, tuple[str, ...]]
"""A skeleton, and in words what has to be said of it."""


def skeleton_of(path: Path, tree: Tree, *, mapping: Path | None, clip: str | None) -> tuple[Known, tuple[int, ...]]:
    """The skeleton of a person in a tree of joints, and which joints of the tree are that person's.

    Raises:
        InvalidFile: the skeleton is unknown (the message shows how to write a mapping).
        InvalidOption: there are several people and none was named.
        UnknownName: there is no person of that name, or the mapping names a joint that is not there.
    """
    people = _people(tree)
    if not people:
        people = [joint for joint, parent in enumerate(tree.parents) if parent < 0]
    labels = _labels(tree, people)
    if clip is not None and clip not in labels:
        raise UnknownName(f"skeleton in {path}", clip, labels)
    if clip is None and len(people) > 1:
        raise InvalidOption("--clip", f"name one of the {len(people)} skeletons of {path}: {', '.join(labels)}")
    top = people[labels.index(clip)] if clip is not None else people[0]
    whole = mapping is not None and len(people) == 1
    joints = tuple(range(len(tree.names))) if whole else _below(tree, top)
    part = _part(tree, joints)
    if mapping is not None:
        return read_mapping(mapping, part.names), joints
    known = _recognise(part)
    others = [
        tree.names[joint] for joint, parent in enumerate(tree.parents) if parent < 0 and joint not in tree.above(top)
    ]
    if known is not None and others:
        known = known[0], (f"the skeleton below {tree.names[top]} is read; left out: {', '.join(others)}", *known[1])
    if known is None:
        raise unknown_skeleton(path, [name for name in part.names if not name.endswith("_end")], find_roles(part))
    _check_names(path, part, known[0])
    return known, joints


def asf_skeleton(path: Path, names: tuple[str, ...], mapping: Path | None) -> Known:
    """The skeleton of a file whose joints are named by the bones that end there."""
    if mapping is not None:
        return read_mapping(mapping, names)
    family = find_family(names, ASF_FAMILIES)
    known = (family, ()) if family is not None else nearest_family(names, ASF_FAMILIES)
    if known is None:
        (asf,) = ASF_FAMILIES
        raise unknown_skeleton(
            path, names, {joint: dict(b) for joint, b in asf.weights.items() if set(b) <= set(names)}
        )
    return known


def _recognise(tree: Tree) -> Known | None:
    family = find_family(tree.names)
    if family is not None:
        own = {name for name in tree.names if not name.endswith("_end")} == set(JOINT_NAMES)
        return (family if own else replace(family, placed=False)), ()
    known = nearest_family(tree.names)
    if known is not None:
        return known
    roles = find_roles(tree)
    whole = with_ends(roles, tree.names)
    if whole is None:
        return None
    table, notes = whole
    return Family("joints told by their names", table), (_told(roles), *notes)


def _told(roles: dict[str, Blend]) -> str:
    pairs = ", ".join(f"{joint} {' and '.join(roles[joint])}" for joint in JOINT_NAMES if joint in roles)
    return f"unknown rig, joints told by their names: {pairs} (--mapping overrules)"


def _people(tree: Tree) -> list[int]:
    """Roots of the smallest parts of a tree that are a person's skeleton."""
    children: dict[int, list[int]] = {}
    for joint, parent in enumerate(tree.parents):
        children.setdefault(parent, []).append(joint)

    found: list[int] = []
    open_joints = [(joint, 0) for joint in children[-1]]
    while open_joints:
        joint, depth = open_joints.pop(0)
        below = children.get(joint, []) if depth < DEEPEST else []
        people = [child for child in below if _recognise(_part(tree, _below(tree, child))) is not None]
        if people:
            open_joints = [(child, depth + 1) for child in people] + open_joints
        elif depth or _recognise(_part(tree, _below(tree, joint))) is not None:
            found.append(joint)
    return found


def _labels(tree: Tree, people: list[int]) -> list[str]:
    """A name for each person: the root's, with a number where another one has the same."""
    names = [tree.names[joint] for joint in people]
    return [name if names.count(name) == 1 else f"{name} {names[: i + 1].count(name)}" for i, name in enumerate(names)]


def _below(tree: Tree, top: int) -> tuple[int, ...]:
    """A joint and all below it."""
    below = {top}
    for joint in range(top + 1, len(tree.parents)):
        if tree.parents[joint] in below:
            below.add(joint)
    return tuple(sorted(below))


def _part(tree: Tree, joints: tuple[int, ...]) -> Tree:
    place = {joint: i for i, joint in enumerate(joints)}
    return Tree(
        names=tuple(tree.names[joint] for joint in joints),
        parents=tuple(place.get(tree.parents[joint], -1) for joint in joints),
        lengths=tuple(tree.lengths[joint] for joint in joints),
    )


def _check_names(path: Path, tree: Tree, family: Family) -> None:
    """InvalidFile where a joint that is needed has a name that others have too."""
    for joint, blend in family.weights.items():
        for name in blend:
            if tree.names.count(name) > 1:
                raise InvalidFile(path, f"{tree.names.count(name)} joints are named {name}, one is needed for {joint}")
