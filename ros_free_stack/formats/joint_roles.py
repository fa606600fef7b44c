"""Which joint of an unknown rig plays which of HumanML3D's 22: by its name and its place in the tree.

Names alone mislead (a foot is an ankle in one rig and a toe in another, a shoulder a collar, a leg a thigh), so that
each role also has to lie in the right order from the trunk outward. Where two joints could play a role, neither does.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from ros_free_stack.formats.joint_words import Name, understand

Blend = dict[str, float]

_LEG: Final = ("hip", "knee", "ankle", "foot")
_ARM: Final = ("collar", "shoulder", "elbow", "wrist")


@dataclass(frozen=True)
class Tree:
    """Joints of a rig: names, parents (-1 for the root; parents come first) and the lengths of their offsets."""

    names: tuple[str, ...]
    parents: tuple[int, ...]
    lengths: tuple[float, ...]

    @property
    def flat(self) -> bool:
        """Whether all joints but end sites hang on the root, so that the tree says nothing."""
        return all(
            parent <= 0 for name, parent in zip(self.names, self.parents, strict=True) if not name.endswith("_end")
        )

    def above(self, joint: int) -> list[int]:
        """The joint and all above it, up to the root."""
        chain = [joint]
        while self.parents[chain[-1]] >= 0:
            chain.append(self.parents[chain[-1]])
        return chain


def find_roles(tree: Tree) -> dict[str, Blend]:
    """The joints that play each role, as weights that sum to 1; roles that no joint surely plays are left out."""
    said = understand(tree.names)
    roles: dict[str, int] = {}
    parts = {name.part for name in said if name.side}
    for side in ("left", "right"):
        found = {part: _pick(tree, said, side, part) for part in parts}
        roles |= {f"{side}_{name}": joint for name, joint in _ordered(tree, _LEG, _leg(tree, found)).items()}
        roles |= {f"{side}_{name}": joint for name, joint in _ordered(tree, _ARM, _arm(tree, found)).items()}
    pelvis = _pelvis(tree, said, [roles[name] for name in ("left_hip", "right_hip") if name in roles])
    if pelvis is not None:
        roles["pelvis"] = pelvis
        roles |= _upper(tree, said, pelvis, [roles[name] for name in roles if name.endswith("_shoulder")])
    blends: dict[str, Blend] = {role: {tree.names[joint]: 1.0} for role, joint in roles.items() if joint >= 0}
    if pelvis is not None:
        blends |= _spine(tree, said, roles, pelvis)
    used = [name for blend in blends.values() for name in blend]
    once = {name for name in used if tree.names.count(name) == 1 and used.count(name) == 1}
    return {role: blend for role, blend in blends.items() if set(blend) <= once or len(blend) > 1}


def _pick(tree: Tree, said: list[Name], side: str, part: str) -> int:
    """The joint of that side and part: the one above all others of them; -1 where that is none."""
    among = [i for i, name in enumerate(said) if (name.side, name.part) == (side, part)]
    among = [i for i in among if said[i].number is None] or among
    return among[0] if among and all(among[0] in tree.above(joint) for joint in among) else -1


def _leg(tree: Tree, found: dict[str, int]) -> dict[str, int]:
    """Joints of the roles; -1 for none. Which words the file uses for either side, `found` has as keys.

    A leg is a thigh beside a shin, and a shin beside a thigh; a foot is a toe beside an ankle.
    """
    leg_is_thigh = "thigh" not in found and "shin" in found
    foot_is_toe = "ankle" in found
    roles = {
        "hip": found.get("leg" if leg_is_thigh else "thigh", -1),
        "knee": found.get("shin" if "shin" in found else "leg", -1),
        "ankle": found.get("ankle" if foot_is_toe else "foot", -1),
        "foot": found.get("toe", found.get("foot", -1) if foot_is_toe else -1),
    }
    toe, foot = found.get("toe", -1), found.get("foot", -1)
    if foot_is_toe and toe >= 0 and foot >= 0 and foot in tree.above(toe) and roles["ankle"] in tree.above(foot):
        roles["foot"] = foot
    return roles


def _arm(tree: Tree, found: dict[str, int]) -> dict[str, int]:
    """As for legs: a shoulder is a collar beside an upper arm, and the upper arm itself without one."""
    collar, elbow = found.get("collar", -1), found.get("forearm", -1)
    upper = found.get("arm", found.get("shoulder", -1))
    if "arm" in found:
        collar = found.get("collar", found.get("shoulder", -1))
    elif elbow >= 0 and upper >= 0 and upper in tree.above(elbow) and tree.above(elbow).index(upper) > 1:
        upper = -1  # a joint between the two may be the one that is meant
    return {"collar": collar, "shoulder": upper, "elbow": elbow, "wrist": found.get("wrist", found.get("hand", -1))}


def _ordered(tree: Tree, order: Sequence[str], roles: dict[str, int]) -> dict[str, int]:
    """Roles whose joints follow one another outward; one that does not is left out."""
    kept: dict[str, int] = {}
    last: int | None = None
    for role in order:
        joint = roles[role]
        if joint >= 0 and (last is None or (joint != last and (tree.flat or last in tree.above(joint)))):
            kept[role], last = joint, joint
    return kept


def _pelvis(tree: Tree, said: list[Name], hips: list[int]) -> int | None:
    """The joint named so that lies lowest above both hips; without one, the joint that both hang on."""
    if len(hips) < 2:
        return None
    second = tree.above(hips[1])
    shared = [joint for joint in tree.above(hips[0])[1:] if joint in second]
    named = [joint for joint in shared if said[joint].part == "pelvis"]
    return next(iter([*named, *shared]), None)


def _upper(tree: Tree, said: list[Name], pelvis: int, shoulders: list[int]) -> dict[str, int]:
    """Neck and head above the pelvis."""
    found: dict[str, int] = {}
    for part in ("neck", "head"):
        among = [i for i, name in enumerate(said) if (name.side, name.part) == ("", part) and pelvis in tree.above(i)]
        among = (
            [i for i in among if not any(i in tree.above(shoulder) for shoulder in shoulders)] if shoulders else among
        )
        if among and all(among[0] in tree.above(joint) for joint in among):
            found[part] = among[0]
    if "head" in found and "neck" in found and not tree.flat and found["neck"] not in tree.above(found["head"]):
        del found["neck"]
    return found


def _spine(tree: Tree, said: list[Name], roles: dict[str, int], pelvis: int) -> dict[str, Blend]:
    """The joints between pelvis and neck (or where the arms branch off), shared out among spine1 to spine3."""
    top = next((roles[name] for name in ("neck", "left_collar", "left_shoulder", "head") if name in roles), None)
    if top is None or pelvis not in tree.above(top):
        return {}
    way = tree.above(top)
    between = [joint for joint in way[1 : way.index(pelvis)][::-1] if joint not in roles.values()]
    if tree.flat:
        between = [i for i, name in enumerate(said) if (name.side, name.part) == ("", "spine")]
        between.sort(key=lambda joint: said[joint].number or 0)
    longest = max((tree.lengths[joint] for joint in between), default=0.0)
    between = [joint for joint in between if tree.lengths[joint] > 0.02 * longest]
    names = [tree.names[joint] for joint in between]
    if len(names) == 1:
        return {"spine2": {names[0]: 1.0}}
    if len(names) == 2:
        return {"spine1": {names[0]: 1.0}, "spine3": {names[1]: 1.0}}
    if len(names) >= 3:
        middle = names[(len(names) - 1) // 2], names[len(names) // 2]
        blend = {name: 1 / len(set(middle)) for name in middle}
        return {"spine1": {names[0]: 1.0}, "spine2": blend, "spine3": {names[-1]: 1.0}}
    return {}
