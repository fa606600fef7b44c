"""Rigs as programs name and build them, and a person's motion written on any of them as BVH."""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation

from ros_free_stack.formats.bvh import Bvh, Joint
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import INDEX, PARENTS

SIDES = ("left", "right")
LEG = ("hip", "knee", "ankle", "foot")
ARM = ("collar", "shoulder", "elbow", "wrist")

STATIC = "static"
"""Role of what stands in the scene above the person."""


@dataclass(frozen=True)
class RigNames:
    """How a program names the joints of a person.

    Attributes:
        pelvis, spine, neck, head: of the trunk, from below.
        leg: hip, knee, ankle, toe; "" for a toe that is an end site only.
        arm: collar ("" where there is none), shoulder, elbow, wrist.
        more: further joints, each as (name, the role that it hangs on).
        prefixes: what may stand before all names.
        above: joints between root and pelvis.
        forearm: share of the forearm at whose end the file has the hand.
    """

    pelvis: str
    spine: tuple[str, ...]
    neck: str
    head: str
    leg: tuple[str, str, str, str]
    arm: tuple[str, str, str, str]
    more: tuple[tuple[str, str], ...] = ()
    prefixes: tuple[str, ...] = ("",)
    above: tuple[str, ...] = ()
    forearm: float = 1.0


_MIXAMO_ARM = ("{Side}Shoulder", "{Side}Arm", "{Side}ForeArm", "{Side}Hand")
_MIXAMO_LEG = ("{Side}UpLeg", "{Side}Leg", "{Side}Foot", "{Side}ToeBase")
_SPINE = ("Spine", "Spine1", "Spine2")
_FINGERS = tuple((f"{{Side}}Hand{finger}1", "wrist") for finger in ("Thumb", "Index", "Pinky"))

RIGS = {
    "Mixamo": RigNames(
        "Hips", _SPINE, "Neck", "Head", _MIXAMO_LEG, _MIXAMO_ARM, _FINGERS, ("", "mixamorig:", "mixamorig", "rig|")
    ),
    "LaFAN1": RigNames(
        "Hips", _SPINE, "Neck", "Head", (*_MIXAMO_LEG[:3], "{Side}Toe"), _MIXAMO_ARM, (), ("", "Model:")
    ),
    "Perception Neuron": RigNames(
        "Hips", (*_SPINE, "Spine3"), "Neck", "Head", (*_MIXAMO_LEG[:3], ""), _MIXAMO_ARM, _FINGERS, ("", "Robot_")
    ),
    "Unreal": RigNames(
        "pelvis",
        tuple(f"spine_0{i}" for i in (1, 2, 3)),
        "neck_01",
        "head",
        ("thigh_{s}", "calf_{s}", "foot_{s}", "ball_{s}"),
        ("clavicle_{s}", "upperarm_{s}", "lowerarm_{s}", "hand_{s}"),
        (("thumb_01_{s}", "wrist"), ("upperarm_twist_01_{s}", "shoulder"), ("calf_twist_01_{s}", "knee")),
        above=("root",),
    ),
    "Biped": RigNames(
        "Bip01 Pelvis",
        ("Bip01 Spine", "Bip01 Spine1"),
        "Bip01 Neck",
        "Bip01 Head",
        ("Bip01 {S} Thigh", "Bip01 {S} Calf", "Bip01 {S} Foot", "Bip01 {S} Toe0"),
        ("Bip01 {S} Clavicle", "Bip01 {S} UpperArm", "Bip01 {S} Forearm", "Bip01 {S} Hand"),
        (("Bip01 {S} Finger0", "wrist"),),
        above=("Bip01",),
    ),
    "VRM": RigNames(
        "J_Bip_C_Hips",
        ("J_Bip_C_Spine", "J_Bip_C_Chest", "J_Bip_C_UpperChest"),
        "J_Bip_C_Neck",
        "J_Bip_C_Head",
        ("J_Bip_{S}_UpperLeg", "J_Bip_{S}_LowerLeg", "J_Bip_{S}_Foot", "J_Bip_{S}_ToeBase"),
        ("J_Bip_{S}_Shoulder", "J_Bip_{S}_UpperArm", "J_Bip_{S}_LowerArm", "J_Bip_{S}_Hand"),
        (("J_Sec_{S}_Bust1", "shoulder"), ("J_Bip_{S}_Index1", "wrist")),
        above=("Root",),
    ),
    "Rigify": RigNames(
        "spine",
        ("spine.001", "spine.002", "spine.003"),
        "spine.004",
        "spine.006",
        ("thigh.{S}", "shin.{S}", "foot.{S}", "toe.{S}"),
        ("shoulder.{S}", "upper_arm.{S}", "forearm.{S}", "hand.{S}"),
        (("thigh.{S}.001", "hip"), ("upper_arm.{S}.001", "shoulder"), ("f_index.01.{S}", "wrist")),
        ("", "DEF-"),
    ),
    "Motive": RigNames(
        "Hip",
        ("Ab", "Chest"),
        "Neck",
        "Head",
        ("{S}Thigh", "{S}Shin", "{S}Foot", "{S}Toe"),
        ("{S}Shoulder", "{S}UArm", "{S}FArm", "{S}Hand"),
        prefixes=("", "Skeleton 001_", "Actor:"),
    ),
    "DAZ": RigNames(
        "hip",
        ("abdomen", "chest"),
        "neck",
        "head",
        ("{s}Thigh", "{s}Shin", "{s}Foot", "{s}Toe"),
        ("{s}Collar", "{s}Shldr", "{s}ForeArm", "{s}Hand"),
        (("{s}Index1", "wrist"), ("{s}Eye", "head")),
    ),
    "SMPL": RigNames(
        "Pelvis",
        ("Spine1", "Spine2", "Spine3"),
        "Neck",
        "Head",
        ("{S}_Hip", "{S}_Knee", "{S}_Ankle", "{S}_Foot"),
        ("{S}_Collar", "{S}_Shoulder", "{S}_Elbow", "{S}_Wrist"),
        (("{S}_Hand", "wrist"),),
        ("", "m_avg_"),
    ),
    "Character Creator": RigNames(
        "CC_Base_Hip",
        ("CC_Base_Waist", "CC_Base_Spine01", "CC_Base_Spine02"),
        "CC_Base_NeckTwist01",
        "CC_Base_Head",
        ("CC_Base_{S}_Thigh", "CC_Base_{S}_Calf", "CC_Base_{S}_Foot", "CC_Base_{S}_ToeBase"),
        ("CC_Base_{S}_Clavicle", "CC_Base_{S}_Upperarm", "CC_Base_{S}_Forearm", "CC_Base_{S}_Hand"),
        (("CC_Base_{S}_ThighTwist01", "hip"), ("CC_Base_{S}_Eye", "head")),
    ),
    "old BVH": RigNames(
        "Hips",
        ("Chest",),
        "Neck",
        "Head",
        ("{Side}Hip", "{Side}Knee", "{Side}Ankle", ""),
        ("{Side}Collar", "{Side}Shoulder", "{Side}Elbow", "{Side}Wrist"),
    ),
    "CMU": RigNames(
        "Hips",
        ("Spine", "Spine1"),
        "Neck1",
        "Head",
        _MIXAMO_LEG,
        _MIXAMO_ARM,
        (("LowerBack", "pelvis"), ("LHipJoint", "pelvis"), ("RHipJoint", "pelvis")),
        forearm=1 / 1.3,
    ),
}


@dataclass(frozen=True)
class Bone:
    """A joint of a built rig: its name, the place of its parent, its role in the body, its place there (y up, m)."""

    name: str
    parent: int
    role: str
    place: Floats
    ends: bool = field(default=False)


def build(names: RigNames, rest: Floats, prefix: str, *, foreign_root: bool = False) -> list[Bone]:
    """The joints of a rig, parents first, on a person whose (22, 3) joints in the T-pose are given, y up."""
    bones: list[Bone] = []

    def place(role: str) -> Floats:
        return rest[INDEX[role]]

    def add(name: str, parent: int, role: str, where: Floats, *, ends: bool = False) -> int:
        bones.append(Bone(name if role == STATIC else prefix + name, parent, role, where, ends))
        return len(bones) - 1

    last = -1
    for name in (("Armature",) if foreign_root else ()) + names.above:
        moves = name.startswith("Bip01")
        last = add(name, last, "pelvis" if moves else STATIC, place("pelvis") if moves else np.zeros(3))
    on = {"pelvis": add(names.pelvis, last, "pelvis", place("pelvis"))}
    for side in SIDES:
        last = on["pelvis"]
        for role, name in zip(LEG, names.leg, strict=True):
            if name:
                last = on[f"{side}_{role}"] = add(_named(name, side), last, f"{side}_{role}", place(f"{side}_{role}"))
        toe = place(f"{side}_foot")
        add("", last, f"{side}_foot", toe + np.array([0, 0, 0.05 if names.leg[3] else 0]), ends=True)
    last = on["pelvis"]
    for i, name in enumerate(names.spine):
        share = (i + 1) / (len(names.spine) + 1)
        role = ("spine1", "spine2", "spine3")[min(int(3 * i / len(names.spine)), 2)]
        last = add(name, last, role, (1 - share) * place("pelvis") + share * place("neck"))
    on["neck"] = add(names.neck, last, "neck", place("neck"))
    on["head"] = add(names.head, on["neck"], "head", place("head"))
    add("", on["head"], "head", place("head") + np.array([0, 0.15, 0]), ends=True)
    for side in SIDES:
        last = on["neck"] - 1
        for role, name in zip(ARM, names.arm, strict=True):
            if not name:
                continue
            where = place(f"{side}_{role}")
            if role == "wrist":
                where = names.forearm * where + (1 - names.forearm) * place(f"{side}_elbow")
            last = on[f"{side}_{role}"] = add(_named(name, side), last, f"{side}_{role}", where)
        add(
            "", last, f"{side}_wrist", bones[last].place + 0.3 * (bones[last].place - place(f"{side}_elbow")), ends=True
        )
    for name, role in names.more:
        for side in SIDES if "{" in name else ("",):
            at = on[f"{side}_{role}"] if f"{side}_{role}" in on else on[role]
            add(_named(name, side), at, bones[at].role, bones[at].place + np.array([0.001, 0.02, 0.01]))
    return _depth_first(bones)


def write(
    bones: Sequence[Bone],
    turns: dict[str, Floats],
    root: Floats,
    *,
    fps: float,
    frames: dict[str, Floats],
    order: str,
    moves: str,
    all_move: bool = False,
) -> Bvh:
    """A motion on a rig.

    Args:
        bones: of the rig, depth first; end sites have no name.
        turns: (T, 3, 3) world rotation of the part of the body that each role carries; y up and the T-pose without.
        root: (T, 3) where the pelvis is.
        fps: frames a second.
        frames: (3, 3) the rig's own frame of each role in the T-pose.
        order: of the rotation channels, such as "ZXY".
        moves: order of the position channels, such as "XYZ".
        all_move: give every joint position channels, in place of its offset.
    """
    joints, columns, count = list[Joint](), list[Floats](), len(root)
    still = np.broadcast_to(np.eye(3), (count, 3, 3))
    world = [still if bone.role == STATIC else turns[bone.role] @ frames[bone.role] for bone in bones]
    carried = False
    for bone, turn in zip(bones, world, strict=True):
        parent = bones[max(bone.parent, 0)]
        first = bone.role == "pelvis" and not carried
        within = bone.parent >= 0 and parent.role != STATIC
        offset = frames[parent.role].T @ (bone.place - parent.place) if within else np.zeros(3)
        if bone.ends:
            joints.append(Joint(f"{parent.name}_end", bone.parent, offset, ()))
            continue
        local = turn if bone.parent < 0 else world[bone.parent].swapaxes(-1, -2) @ turn
        channels = tuple(f"{axis}rotation" for axis in order)
        if first or bone.parent < 0 or all_move:
            channels = (*(f"{axis}position" for axis in moves), *channels)
            columns.append((root if first else np.tile(offset, (count, 1)))[:, ["XYZ".index(axis) for axis in moves]])
        carried |= first
        columns.append(_euler(order, local))
        joints.append(Joint(bone.name, bone.parent, offset, channels))
    return Bvh(tuple(joints), np.concatenate(columns, axis=1), fps)


def world_turns(local: Floats) -> dict[str, Floats]:
    """(T, 3, 3) world rotations by joint of the 22, from (T, 22, 3, 3) rotations relative to the parents."""
    turns: dict[str, Floats] = {}
    for role, joint in INDEX.items():
        parent = PARENTS[joint]
        first = next((name for name, place in INDEX.items() if place == parent), "")
        turns[role] = turns[first] @ local[:, joint] if first else local[:, joint]
    return turns


def _euler(order: str, turns: Floats) -> Floats:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # at gimbal lock any of the equal angles will do
        return np.rad2deg(np.unwrap(Rotation.from_matrix(turns).as_euler(order), axis=0))


def _named(name: str, side: str) -> str:
    return name.format(Side=side.capitalize(), S=side[:1].upper(), s=side[:1], side=side)


def _depth_first(bones: list[Bone]) -> list[Bone]:
    order: list[int] = []

    def visit(bone: int) -> None:
        order.append(bone)
        for child, item in enumerate(bones):
            if item.parent == bone:
                visit(child)

    visit(0)
    place = {old: new for new, old in enumerate(order)}
    return [
        Bone(
            bones[i].name,
            place[bones[i].parent] if bones[i].parent >= 0 else -1,
            bones[i].role,
            bones[i].place,
            bones[i].ends,
        )
        for i in order
    ]
