"""Which bodies of a robot play which human joint: legs, arms, trunk and head, from geometry and symmetry.

Names count only where geometry leaves a choice: they differ wildly from maker to maker, and some mislead (an "elbow
pitch" may turn the upper arm about itself).
"""

import re
from dataclasses import dataclass, field

import numpy as np

from retarget.describe.tree import Pair, Tree
from ros_free_stack.messages import Floats

LEAST_REACH = 0.15
"""A pair of chains shorter than this, in sizes of the robot, is no pair of limbs (ears, antennas)."""
LEAST_JOINTS = 3
PARALLEL = 0.8
"""Cosine of the angle below which an axis counts as along a bone: it turns the bone about itself."""
CENTRED = 0.05
"""How far from a bone's line an axis may pass to be part of the joint at its upper end, in lengths of the limb."""
ONE_JOINT = 0.08
"""How far apart the axes of one ankle may be, in lengths of the limb."""
RIVAL = 0.8
"""A second pair of chains this long, against the first, may just as well be the arms."""

_LEG_WORDS = re.compile(r"leg|hip|thigh|knee|shank|calf|ankle|foot|toe", re.IGNORECASE)
_ARM_WORDS = re.compile(r"arm|shoulder|elbow|wrist|hand|finger", re.IGNORECASE)


@dataclass(frozen=True)
class Question:
    """What could not be decided: the key of the description to fill in, what is open, and what it might be."""

    key: str
    problem: str
    candidates: tuple[str, ...] = ()

    def __str__(self) -> str:
        choices = f" (candidates: {', '.join(self.candidates)})" if self.candidates else ""
        return f"{self.key}: {self.problem}{choices}"


@dataclass(frozen=True)
class Limb:
    """A leg or an arm.

    Attributes:
        bodies: its moving bodies, from the trunk outward.
        root: the body whose place is the hip or shoulder.
        middle: the body that the knee or elbow moves.
        end: the body that the ankle or wrist moves; None where the limb has no such joint.
    """

    bodies: tuple[int, ...]
    root: int
    middle: int
    end: int | None


@dataclass(frozen=True)
class Anatomy:
    """What was found: limbs as (left, right), the bodies that carry them, and open questions.

    Attributes:
        pelvis: the body that carries the legs, or the base.
        torso: the body that carries the arms, or the pelvis.
        legs, arms: left and right, or None.
        head: the outermost body of the neck, or None.
        questions: what could not be decided.
    """

    pelvis: int
    torso: int
    legs: tuple[Limb, Limb] | None
    arms: tuple[Limb, Limb] | None
    head: int | None
    questions: list[Question] = field(default_factory=list[Question])


def find_anatomy(tree: Tree) -> Anatomy:
    """Decide what can be decided; the rest are questions."""
    questions: list[Question] = []
    pairs = [pair for pair in tree.pairs() if _reach(tree, pair) > LEAST_REACH * tree.size and _freedom(tree, pair)]
    if not pairs:
        questions.append(
            Question(
                "attachments",
                "no two chains of at least three joints mirror each other across the plane y = 0 in the model's own "
                "pose; the robot must face x there, or the limbs must be attached by hand",
            )
        )
    leg_pair = _leg_pair(tree, pairs, questions)
    arm_pair = _arm_pair(tree, [pair for pair in pairs if pair is not leg_pair], questions)
    pelvis = leg_pair.hub if leg_pair else tree.base
    torso = arm_pair.hub if arm_pair else pelvis
    legs = _limbs(tree, leg_pair, "knee", questions) if leg_pair else None
    arms = _limbs(tree, arm_pair, "elbow", questions) if arm_pair else None
    return Anatomy(pelvis, torso, legs, arms, _head(tree, leg_pair, arm_pair), questions)


def _reach(tree: Tree, pair: Pair) -> float:
    """Length of a chain of joints and of the last body, m."""
    places = [tree.position[body] for body in pair.left] + [tree.centre[pair.left[-1]]]
    return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())


def _freedom(tree: Tree, pair: Pair) -> bool:
    return sum(len(tree.joints(body)) for body in pair.left) >= LEAST_JOINTS


def _words(tree: Tree, pair: Pair) -> str:
    joints = (tree.model.joint(joint).name for body in pair.left for joint in tree.joints(body))
    return " ".join([*(tree.name(body) for body in pair.left), *joints])


def _leg_pair(tree: Tree, pairs: list[Pair], questions: list[Question]) -> Pair | None:
    """The pair that hangs lowest: of two pairs the one that is attached lower, a single one by its base or names."""
    if not pairs:
        return None
    lowest = min(pairs, key=lambda pair: tree.position[pair.left[0], 2])
    end, start = tree.centre[lowest.left[-1], 2], tree.position[lowest.left[0], 2]
    if len(pairs) > 1:
        return lowest if end < start else None
    leg, arm = (bool(words.search(_words(tree, lowest))) for words in (_LEG_WORDS, _ARM_WORDS))
    if leg != arm:
        return lowest if leg else None
    if tree.free and end > start:
        questions.append(Question("soles", "the only pair of limbs does not hang down: a robot without feet"))
    return lowest if tree.free else None


def _arm_pair(tree: Tree, pairs: list[Pair], questions: list[Question]) -> Pair | None:
    if not pairs:
        return None
    first, *others = sorted(pairs, key=lambda pair: _reach(tree, pair), reverse=True)
    rivals = [pair for pair in others if _reach(tree, pair) > RIVAL * _reach(tree, first)]
    if not rivals:
        return first
    named = [pair for pair in (first, *rivals) if _ARM_WORDS.search(_words(tree, pair))]
    if len(named) == 1:
        return named[0]
    choices = tuple(tree.name(pair.left[0]) for pair in (first, *rivals))
    questions.append(Question("attachments.left_shoulder", "several pairs of chains may be the arms", choices))
    return None


def _limbs(tree: Tree, pair: Pair, middle: str, questions: list[Question]) -> tuple[Limb, Limb] | None:
    found = _divide(tree, pair.left, leg=middle == "knee")
    if found is None:
        names = tuple(tree.name(body) for body in pair.left)
        questions.append(Question(f"attachments.left_{middle}", f"no joint bends this limb like a {middle}", names))
        return None
    root, centre, end = found
    left, right = (
        Limb(chain, chain[root], chain[centre], None if end is None else chain[end])
        for chain in (pair.left, pair.right)
    )
    return left, right


def _divide(tree: Tree, chain: tuple[int, ...], *, leg: bool) -> tuple[int, int, int | None] | None:
    """Indices of hip or shoulder, knee or elbow, ankle or wrist in a chain; None where nothing bends in its middle."""
    places = [tree.position[body] for body in chain]
    tip = tree.centre[chain[-1]]
    length = float(np.linalg.norm(np.diff([*places, tip], axis=0), axis=1).sum())

    def bends(k: int) -> float:
        """Length of the shorter of the two bones that meet here, 0 where the axis only turns one about itself."""
        upper, lower = places[k] - places[0], tip - places[k]
        axis = tree.axes[tree.joints(chain[k])[-1]]
        if any(_cosine(axis, bone) > PARALLEL for bone in (upper, lower)):
            return 0.0
        return float(min(np.linalg.norm(upper), np.linalg.norm(lower)))

    middle = max(range(1, len(chain)), key=bends, default=0)
    if middle == 0 or bends(middle) < 0.1 * length:
        return None
    above = next((k for k in range(middle - 1, -1, -1) if _apart(places[k], places[middle]) > CENTRED * length), 0)
    bone = places[middle] - places[above]
    root = _root(tree, chain[:middle], places[middle], bone, CENTRED * length)
    return root, middle, _end(tree, chain, middle, length, leg=leg)


def _root(tree: Tree, bodies: tuple[int, ...], middle: Floats, bone: Floats, tolerance: float) -> int:
    """The outermost of the joints whose axes swing the bone, not turn it about itself, and pass close to its line."""
    swinging = [
        (_line_distance(tree.anchors[joint], tree.axes[joint], middle, bone), k)
        for k, body in enumerate(bodies)
        for joint in tree.joints(body)
        if _cosine(tree.axes[joint], bone) < PARALLEL
    ]
    nearest = min((distance for distance, _ in swinging), default=0.0)
    return max((k for distance, k in swinging if distance <= nearest + tolerance), default=len(bodies) - 1)


def _end(tree: Tree, chain: tuple[int, ...], middle: int, length: float, *, leg: bool) -> int | None:
    """The ankle: the outermost axis near the first one below the knee. The wrist: the outermost axis of the arm."""
    after = range(middle + 1, len(chain))
    if not leg:
        far = [k for k in after if _apart(tree.position[chain[k]], tree.position[chain[middle]]) > ONE_JOINT * length]
        return far[-1] if far else None
    shin = tree.centre[chain[-1]] - tree.position[chain[middle]]
    ankles = [k for k in after if _cosine(tree.axes[tree.joints(chain[k])[0]], shin) < PARALLEL]
    if not ankles:
        return None
    first = tree.position[chain[ankles[0]]]
    return max(k for k in ankles if _apart(tree.position[chain[k]], first) <= ONE_JOINT * length)


def _head(tree: Tree, legs: Pair | None, arms: Pair | None) -> int | None:
    """The end of a single chain that goes up from where the arms begin."""
    hubs = {pair.hub for pair in (legs, arms) if pair}
    height = tree.position[arms.left[0], 2] if arms else tree.position[tree.base, 2]
    chains = [chain for chain in tree.middle_chains() if not hubs & set(chain)]
    above = [chain for chain in chains if tree.centre[chain[-1], 2] > height]
    return max(above, key=lambda chain: tree.centre[chain[-1], 2])[-1] if above else None


def _cosine(first: Floats, second: Floats) -> float:
    return abs(float(first @ second)) / max(float(np.linalg.norm(first) * np.linalg.norm(second)), 1e-12)


def _apart(first: Floats, second: Floats) -> float:
    return float(np.linalg.norm(first - second))


def _line_distance(a: Floats, along: Floats, b: Floats, bone: Floats) -> float:
    """Distance of two lines that are not parallel."""
    normal = np.cross(along, bone)
    return abs(float((a - b) @ normal)) / float(np.linalg.norm(normal))
