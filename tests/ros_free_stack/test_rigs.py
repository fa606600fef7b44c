"""Rigs of many programs: which joint plays which role, and who of several people is meant."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from benchmarks.rigs import RIGS, build
from benchmarks.walk_variants import REST, Arguments, Variant, judge, make, run, walk
from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.bvh import Bvh, Joint, write_bvh
from ros_free_stack.formats.bvh_motion import read
from ros_free_stack.formats.bvh_reader import read_bvh
from ros_free_stack.formats.frames import stand
from ros_free_stack.formats.joint_roles import Tree, find_roles
from ros_free_stack.formats.joint_words import understand
from ros_free_stack.formats.mapping import template
from ros_free_stack.formats.rigs import skeleton_of
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.formats.upright import turned_up
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import INDEX, JOINT_NAMES

NO_OPTIONS = SourceOptions()
PLAIN = Variant(
    rig="Mixamo", prefix="", foreign_root=False, unit="cm", up="y", rest="T-pose", order="ZXY", moves="XYZ",
    all_move=False, fps=30.0, quirk="plain", lead="none", tall=1.7, heading=0.4, start=0.0, seconds=1.0,
)  # fmt: skip
NEEDED = [name for name in JOINT_NAMES if not name.startswith(("spine", "neck", "head")) and "collar" not in name]


def tree_of(rig: str, prefix: str = "", renamed: dict[str, str] | None = None) -> tuple[Tree, dict[str, str]]:
    """A rig's tree, and the name of the joint of each role."""
    bones = build(RIGS[rig], REST, prefix)
    names: list[str] = []
    roles: dict[str, str] = {}
    for bone in bones:
        name = f"{names[bone.parent]}_end" if bone.ends else (renamed or {}).get(bone.name, bone.name)
        names.append(name)
        if not bone.ends:
            roles.setdefault(bone.role, name)
    roles["pelvis"] = (renamed or {}).get(prefix + RIGS[rig].pelvis, prefix + RIGS[rig].pelvis)
    lengths = [float(np.linalg.norm(bone.place - bones[max(bone.parent, 0)].place)) for bone in bones]
    return Tree(tuple(names), tuple(bone.parent for bone in bones), tuple(lengths)), roles


def test_a_walk_comes_back_from_every_variant() -> None:
    counts, failures = run(Arguments(count=50, seed=7))
    assert not failures
    assert counts["sound, right"] >= 40 and counts["faulty, asked"] >= 3


@pytest.mark.parametrize("rig", RIGS)
def test_every_rig_is_read(tmp_path: Path, rig: str) -> None:
    for prefix in RIGS[rig].prefixes:
        variant = replace(PLAIN, rig=rig, prefix=prefix, foreign_root=True)
        data, wanted = make(variant)
        (tmp_path / "a.bvh").write_bytes(data)
        assert judge(tmp_path / "a.bvh", variant, wanted) == ("right", "")


@pytest.mark.parametrize("rig", RIGS)
def test_a_proposed_mapping_is_right_or_left_open(rig: str) -> None:
    """With a joint that nobody can understand, every other proposal stays right, and none is made twice."""
    if rig in ("CMU", "Rigify"):  # whose own names mislead; known by all their names together
        return
    _, plain = tree_of(rig)
    for hidden in ("left_knee", "right_shoulder", "pelvis", "left_hip"):
        tree, roles = tree_of(rig, renamed={plain[hidden]: "thing"})
        proposed = yaml.safe_load(template(tree.names, find_roles(tree)))
        for role in NEEDED:
            if proposed[role] != "FILL_IN":
                assert proposed[role] == roles.get(role, ""), (hidden, role)
        assert proposed[hidden] in ("FILL_IN", "thing")
        single = [name for name in proposed.values() if isinstance(name, str) and name != "FILL_IN"]
        assert len(single) == len(set(single))
        left_open = [role for role in NEEDED if proposed[role] == "FILL_IN" and role in roles]
        assert len(left_open) <= 3, left_open


def test_words_of_names() -> None:
    said = understand(["LeftUpLeg", "LFArm", "upper_arm.L.001", "lShldr", "rtibia", "HipCenter", "KneeRight"])
    assert [(name.side, name.part, name.number) for name in said] == [
        ("left", "thigh", None),
        ("left", "forearm", None),
        ("left", "arm", 1),
        ("left", "arm", None),
        ("right", "shin", None),
        ("", "pelvis", None),
        ("right", "shin", None),
    ]
    assert understand(["左ひざ", "右足首", "下半身", "LeftHandIndex1", "Left_end"])[2].part == "pelvis"


def test_two_joints_that_could_play_a_role_leave_it_open() -> None:
    names = ("Hips", "LeftThigh", "LeftUpLeg", "LeftShin", "LeftFoot", "RightThigh", "RightShin", "RightFoot")
    roles = find_roles(Tree(names, (-1, 0, 0, 2, 3, 0, 5, 6), (0.0, *[1.0] * 7)))
    assert "left_hip" not in roles
    assert roles["right_hip"] == {"RightThigh": 1.0}
    assert "left_foot" not in roles and roles["left_ankle"] == {"LeftFoot": 1.0}


@pytest.mark.parametrize("shape", ["two roots", "two roots of one name", "one scene"])
def test_of_two_people_one_is_asked_for(tmp_path: Path, shape: str) -> None:
    data, wanted = make(PLAIN)
    path = tmp_path / "a.bvh"
    path.write_bytes(data)
    first = read_bvh(path)
    other = replace(
        PLAIN, rig="Unreal" if shape == "two roots" else "Mixamo", prefix="B:" if shape == "one scene" else ""
    )
    path.write_bytes(make(replace(other, heading=2.0, tall=1.5))[0])
    second = read_bvh(path)
    scene = [Joint("Scene", -1, np.zeros(3), ())] if shape == "one scene" else []
    joints = list(scene)
    for bvh in (first, second):
        shift = len(joints)
        joints += [
            Joint(j.name, j.parent + shift if j.parent >= 0 else len(scene) - 1, j.offset, j.channels)
            for j in bvh.joints
        ]
    both = Bvh(tuple(joints), np.concatenate([first.values, second.values], axis=1), 30.0)
    write_two(path, both)
    second_name = {"two roots": "pelvis", "two roots of one name": "Hips 2", "one scene": "B:Hips"}[shape]
    first_name = "Hips 1" if shape == "two roots of one name" else "Hips"
    with pytest.raises(InvalidOption, match=f"--clip: name one of the 2 skeletons of .*: {first_name}, {second_name}"):
        read(path, NO_OPTIONS)
    with pytest.raises(UnknownName, match=f"unknown skeleton in .* 'tail'; valid: {second_name}|{first_name}"):
        read(path, SourceOptions(clip="tail"))
    motion = read(path, SourceOptions(clip=first_name)).content
    assert isinstance(motion, HumanMotion)
    np.testing.assert_allclose(motion.joints[:, INDEX["left_knee"]], wanted[:, INDEX["left_knee"]], atol=1e-3)
    assert (shape == "one scene") != any(
        note.startswith(f"the skeleton below {first.names[0]} is read; left out: ")
        for note in read(path, SourceOptions(clip=first_name)).notes
    )
    small = read(path, SourceOptions(clip=second_name)).content
    assert isinstance(small, HumanMotion)
    expected = stand(turned_up(walk(replace(other, heading=2.0, tall=1.5))[2], "y"))  # pyright: ignore[reportArgumentType]
    np.testing.assert_allclose(small.joints[:, INDEX["left_knee"]], expected[:, INDEX["left_knee"]], atol=1e-3)


def write_two(path: Path, bvh: Bvh) -> None:
    """`write_bvh` writes one tree; a second root follows the first."""
    roots = [i for i, joint in enumerate(bvh.joints) if joint.parent < 0]
    texts: list[str] = []
    for start, end in zip(roots, [*roots[1:], len(bvh.joints)], strict=True):
        part = tuple(replace(joint, parent=max(joint.parent - start, -1)) for joint in bvh.joints[start:end])
        part = tuple(replace(j, channels=("Xposition",)) if j.name == "Scene" else j for j in part)
        write_bvh(path, Bvh(part, np.zeros((1, 1)), bvh.fps))
        texts.append(path.read_text(encoding="utf-8").partition("MOTION")[0].removeprefix("HIERARCHY"))
    values = bvh.values if bvh.joints[0].name != "Scene" else np.insert(bvh.values, 0, 0.0, axis=1)
    rows = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in values)
    path.write_text(f"HIERARCHY{''.join(texts)}MOTION\nFrames: {len(values)}\nFrame Time: 0.0333333\n{rows}\n")


def test_joints_of_one_name_are_refused_where_one_is_needed(tmp_path: Path) -> None:
    path = tmp_path / "a.bvh"
    path.write_bytes(make(PLAIN)[0].replace(b"RightLeg", b"LeftLeg"))
    with pytest.raises(InvalidFile, match=r"--mapping mapping\.yaml"):
        read(path, NO_OPTIONS)
    path.write_bytes(make(PLAIN)[0].replace(b"LeftHandPinky1", b"LeftLeg"))
    with pytest.raises(InvalidFile, match="2 joints are named LeftLeg, one is needed for left_knee"):
        read(path, NO_OPTIONS)
    path.write_bytes(make(PLAIN)[0].replace(b"LeftHandPinky1", b"LeftHandIndex1"))
    assert read(path, NO_OPTIONS).content.fps == 30


def test_a_mapping_names_each_joint_once_and_in_full_or_short(tmp_path: Path) -> None:
    data, wanted = make(replace(PLAIN, prefix="mixamorig:"))
    path, mapping = tmp_path / "a.bvh", tmp_path / "mapping.yaml"
    path.write_bytes(data)
    _, roles = tree_of("Mixamo", "mixamorig:")
    rows = {role: roles[role] for role in NEEDED}
    for shorten in (False, True):
        table = {role: name.removeprefix("mixamorig:") if shorten else name for role, name in rows.items()}
        mapping.write_text(yaml.safe_dump(table))
        motion = read(path, SourceOptions(mapping=mapping)).content
        assert isinstance(motion, HumanMotion)
        places = [INDEX[role] for role in NEEDED]
        np.testing.assert_allclose(motion.joints[:, places], wanted[:, places], atol=1e-3)
    mapping.write_text(yaml.safe_dump(rows | {"left_foot": rows["left_ankle"]}))
    with pytest.raises(
        InvalidFile, match="left_ankle and left_foot are both mixamorig:LeftFoot: each joint plays one role"
    ):
        read(path, SourceOptions(mapping=mapping))
    mapping.write_text(yaml.safe_dump(rows | {"left_wrist": "LeftHandThumb1", "left_elbow": "LeftHand"}))
    with pytest.raises(InvalidFile, match="left_elbow and left_wrist lie together"):
        read(path, SourceOptions(mapping=mapping))


def test_names_in_any_script_match_their_mapping(tmp_path: Path) -> None:
    data, wanted = make(replace(PLAIN, quirk="UTF-16"))
    path, mapping = tmp_path / "a.bvh", tmp_path / "mapping.yaml"
    path.write_bytes(data.decode("utf-16").replace("LeftLeg", "Kniegelenk-Größe 左").encode("utf-16"))
    _, roles = tree_of("Mixamo")
    table = {role: roles[role] for role in NEEDED} | {"left_knee": "Kniegelenk-Größe 左"}
    mapping.write_text(yaml.safe_dump(table, allow_unicode=True), encoding="utf-8")
    motion = read(path, SourceOptions(mapping=mapping)).content
    assert isinstance(motion, HumanMotion)
    np.testing.assert_allclose(motion.joints[:, INDEX["left_knee"]], wanted[:, INDEX["left_knee"]], atol=1e-3)


def test_a_lone_person_is_found_below_scenery() -> None:
    tree, roles = tree_of("Unreal")
    more = Tree(
        ("World", *tree.names, "Camera"),
        (-1, *(parent + 1 if parent >= 0 else 0 for parent in tree.parents), 0),
        (0.0, *tree.lengths, 1.0),
    )
    (family, _), joints = skeleton_of(Path("a.bvh"), more, mapping=None, clip=None)
    assert family.weights["left_knee"] == {roles["left_knee"]: 1.0}
    assert more.names[joints[0]] == "pelvis" and len(joints) == len(tree.names) - 1
