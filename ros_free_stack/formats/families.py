"""Skeletons that are known by their joints' names, whatever file they come in."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from ros_free_stack.formats.skeleton_map import ASF, DAZ, SUBJECT_131, Weights, weights
from ros_free_stack.formats.source import UpAxis
from ros_free_stack.skeleton import JOINT_NAMES


@dataclass(frozen=True)
class Family:
    """A known skeleton.

    Attributes:
        name: for people.
        weights: where HumanML3D's 22 joints lie between the skeleton's own.
        marks: further joints that only this skeleton has.
        up: the up axis of its files as published; None where programs write them either way.
        placed: whether its files stand on the floor, at the origin and facing forward already.
    """

    name: str
    weights: Weights
    marks: tuple[str, ...] = ()
    up: UpAxis | None = None
    placed: bool = False

    def fits(self, names: Sequence[str]) -> bool:
        """Whether every joint that it needs is among the names."""
        needed = {name for blend in self.weights.values() for name in blend}
        return needed.union(self.marks) <= set(names)

    def with_prefix(self, prefix: str) -> "Family":
        """The family in a file that puts a prefix before all names."""
        if not prefix:
            return self
        table = {
            joint: {prefix + name: share for name, share in blend.items()} for joint, blend in self.weights.items()
        }
        return replace(self, weights=table, marks=tuple(prefix + mark for mark in self.marks))


_MOTIONBUILDER_ARMS: Final = {
    "collar": "{side}Shoulder",
    "shoulder": "{side}Arm",
    "elbow": "{side}ForeArm",
    "wrist": "{side}Hand",
}
_MOTIONBUILDER_LEGS: Final = {"hip": "{side}UpLeg", "knee": "{side}Leg", "ankle": "{side}Foot"}
_MOTIONBUILDER_TRUNK: Final = {
    "pelvis": "Hips",
    "spine1": "Spine",
    "spine2": "Spine1",
    "spine3": "Spine2",
    "neck": "Neck",
    "head": "Head",
}

FAMILIES: Final = (
    Family("this project's own skeleton", weights(**{name: name for name in JOINT_NAMES}), up="y", placed=True),
    Family(
        "LaFAN1",
        weights(**_MOTIONBUILDER_TRUNK, **_MOTIONBUILDER_ARMS, **_MOTIONBUILDER_LEGS, foot="{side}Toe"),
        up="y",
    ),
    Family(
        "Mixamo",
        weights(**_MOTIONBUILDER_TRUNK, **_MOTIONBUILDER_ARMS, **_MOTIONBUILDER_LEGS, foot="{side}ToeBase"),
    ),
    Family(
        "SOMA (BONES-SEED, Kimodo)",
        weights(
            pelvis="Hips",
            spine1="Spine1",
            spine2="Spine2",
            spine3="Chest",
            neck="Neck1",
            head="Head",
            hip="{side}Leg",
            knee="{side}Shin",
            ankle="{side}Foot",
            foot="{side}ToeBase",
            **_MOTIONBUILDER_ARMS,
        ),
        up="y",
    ),
    Family(
        "Xsens",
        weights(
            pelvis="Hips",
            spine1="Chest",
            spine2={"Chest2": 0.5, "Chest3": 0.5},
            spine3="Chest3",
            neck="Neck",
            head="Head",
            hip="{side}Hip",
            knee="{side}Knee",
            ankle="{side}Ankle",
            foot="{side}Toe",
            collar="{side}Collar",
            shoulder="{side}Shoulder",
            elbow="{side}Elbow",
            wrist="{side}Wrist",
        ),
        marks=("Chest4",),
        up="y",
    ),
    Family(
        "CMU, for MotionBuilder",
        weights(
            pelvis="Hips",
            spine1="Spine",
            spine2={"Spine": 0.5, "Spine1": 0.5},
            spine3="Spine1",
            neck="Head",
            head="Head_end",
            foot="{side}ToeBase",
            **_MOTIONBUILDER_LEGS,
            collar={"Spine1": 0.55, "{side}Arm": 0.45},
            shoulder="{side}Arm",
            elbow="{side}ForeArm",
            wrist={"{side}ForeArm": -0.3, "{side}Hand": 1.3},
        ),
        marks=("LowerBack", "LHipJoint"),
        up="y",
    ),
    Family("CMU, for DAZ", DAZ, up="y"),
    Family("CMU, subject 131", SUBJECT_131, marks=("LHipJoint",), up="y"),
    Family(
        "Rigify",
        weights(
            pelvis="spine",
            spine1="spine.001",
            spine2="spine.002",
            spine3="spine.003",
            neck="spine.004",
            head="spine.006",
            hip="thigh.{S}",
            knee="shin.{S}",
            ankle="foot.{S}",
            foot="toe.{S}",
            collar="shoulder.{S}",
            shoulder="upper_arm.{S}",
            elbow="forearm.{S}",
            wrist="hand.{S}",
        ),
    ),
    Family(
        "CMU, bones of ASF as joints",
        weights(
            pelvis="root",
            spine1="upperback",
            spine2="thorax",
            spine3="lowerneck",
            neck="head",
            head="head_end",
            hip="{s}femur",
            knee="{s}tibia",
            ankle="{s}foot",
            foot="{s}toes",
            collar={"lowerneck": 0.55, "{s}humerus": 0.45},
            shoulder="{s}humerus",
            elbow="{s}radius",
            wrist={"{s}wrist": 0.4, "{s}hand": 0.6},
        ),
        marks=("lhipjoint",),
        up="y",
    ),
)
"""Every known skeleton whose joints are named by where a bone starts, as in BVH; the first that fits counts."""

ASF_FAMILIES: Final = (Family("CMU, ASF/AMC", ASF),)
"""Those whose joints are named by the bone that ends there."""


def find_family(names: Sequence[str], families: Sequence[Family] = FAMILIES) -> Family | None:
    """The first family that fits, its joints named as in the file, with a prefix before all of them or without."""
    for family in families:
        for prefix in prefixes(family, names):
            renamed = family.with_prefix(prefix)
            if renamed.fits(names):
                return renamed
    return None


def prefixes(family: Family, names: Sequence[str]) -> list[str]:
    """What may stand before a family's names, by the joints that are named like its pelvis; the shortest first."""
    (pelvis,) = family.weights["pelvis"] if len(family.weights["pelvis"]) == 1 else ("",)
    return sorted({name.removesuffix(pelvis) for name in names if pelvis and name.endswith(pelvis)}, key=len)


def bare(names: Sequence[str]) -> tuple[str, ...]:
    """Joint names without the prefix that some programs put before all of them (`mixamorig:Hips`, `Model_Hips`)."""
    first, last = min(names), max(names)  # what these two share, all share
    differs = (i for i, pair in enumerate(zip(first, last, strict=False)) if pair[0] != pair[1])
    shared = next(differs, len(first))
    end = max(first.rfind(mark, 0, shared) for mark in ":_| ") + 1
    short = (name[end:] for name in names)
    return tuple(name[max(name.rfind(mark) for mark in ":|") + 1 :] for name in short)
