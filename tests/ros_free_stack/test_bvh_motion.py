from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.bvh import Bvh, Joint, write_bvh
from ros_free_stack.formats.bvh_motion import read, write
from ros_free_stack.formats.families import FAMILIES, Family, bare, find_family
from ros_free_stack.formats.frames import from_y_up, stand, to_y_up
from ros_free_stack.formats.mapping import complete
from ros_free_stack.formats.skeleton_map import select
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.formats.stature import METRES
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import INDEX, JOINT_NAMES

MOVES, TURNS = ("Xposition", "Yposition", "Zposition"), ("Zrotation", "Xrotation", "Yrotation")
NO_OPTIONS = SourceOptions()
CAPTURED = [family for family in FAMILIES if not family.placed]


def write_rig(path: Path, names: list[str], points: Floats, *, fps: float = 20.0, prefix: str = "") -> Path:
    """A file whose joints lie where the (T, S, 3) points say; all hang on the first by position channels."""
    joints = [Joint(prefix + names[0], -1, np.zeros(3), (*MOVES, *TURNS))]
    columns = [points[:, 0], np.zeros((len(points), 3))]
    for i, name in enumerate(names[1:], start=1):
        if name.endswith("_end"):
            continue
        joints.append(Joint(prefix + name, 0, points[0, i] - points[0, 0], (*MOVES, *TURNS)))
        columns += [points[:, i] - points[:, 0], np.zeros((len(points), 3))]
        if f"{name}_end" in names:
            offset = points[0, names.index(f"{name}_end")] - points[0, i]
            joints.append(Joint(f"{prefix}{name}_end", len(joints) - 1, offset, ()))
    write_bvh(path, Bvh(tuple(joints), np.concatenate(columns, axis=1), fps))
    return path


def rig_points(family: Family, joints: Floats) -> tuple[list[str], Floats]:
    """Points of a family's skeleton that lie so that its 22 joints are the given ones."""
    names = list(dict.fromkeys(name for joint in JOINT_NAMES for name in family.weights[joint]))
    names += [name.removesuffix("_end") for name in names if name.removesuffix("_end") not in names]
    weights = np.array([[family.weights[joint].get(name, 0.0) for name in names] for joint in JOINT_NAMES])
    points = np.linalg.pinv(weights) @ joints
    names += [name for name in family.marks if name not in names]
    return names, np.concatenate([points, np.repeat(points[:, :1], len(names) - points.shape[1], axis=1)], axis=1)


@pytest.mark.parametrize("family", CAPTURED, ids=lambda family: family.name)
def test_every_family_is_known_by_its_names_and_gives_the_same_person(tmp_path: Path, person, family: Family) -> None:
    pose = person(1)
    names, points = rig_points(family, to_y_up(100 * np.repeat(pose.joints, 2, axis=0)))
    source = read(write_rig(tmp_path / "a.bvh", names, points), NO_OPTIONS)
    assert find_family(names) is family
    assert isinstance(source.content, HumanMotion)
    assert len(source.content.joints) == 2
    expected = from_y_up(select(names, points[:1] / 100, family.weights))
    np.testing.assert_allclose(source.content.joints[0], stand(expected)[0], atol=1e-5)
    np.testing.assert_allclose(expected, pose.joints, atol=0.08)
    assert family.name in source.notes[-1]


def test_a_prefix_before_all_names_does_not_matter(tmp_path: Path, person) -> None:
    mixamo = next(family for family in FAMILIES if family.name == "Mixamo")
    names, points = rig_points(mixamo, to_y_up(100 * person(3).joints))
    for prefix in ("mixamorig:", "mixamorig", "Model_", "rig|"):
        source = read(write_rig(tmp_path / "a.bvh", names, points, prefix=prefix), NO_OPTIONS)
        assert "Mixamo" in source.notes[-1]
    assert bare(["Hips", "Head"]) == ("Hips", "Head")
    assert bare(["Armature", "rig:Hips", "rig:Head"]) == ("Armature", "Hips", "Head")
    assert bare(["a:b"]) == ("b",)


@pytest.mark.parametrize("unit", METRES)
@pytest.mark.parametrize("up", ["y", "z"])
def test_unit_and_up_axis_follow_from_the_person(tmp_path: Path, person, unit, up) -> None:
    pose = person(4)
    lafan = next(family for family in FAMILIES if family.name == "LaFAN1")
    names, points = rig_points(lafan, (to_y_up(pose.joints) if up == "y" else pose.joints) / METRES[unit])
    path = write_rig(tmp_path / "a.bvh", names, points)
    for options in (NO_OPTIONS, SourceOptions(units=unit, up=up)):
        source = read(path, options)
        assert isinstance(source.content, HumanMotion)
        np.testing.assert_allclose(source.content.joints, pose.joints, atol=1e-4)
        doubt = up == "z" and options is NO_OPTIONS
        why = " (the person stands along it; such files usually have y: --up overrules)" if doubt else ""
        assert source.notes == (f"skeleton: LaFAN1; lengths in {unit}, {up} up{why}",)


def test_what_cannot_be_told_has_to_be_said(tmp_path: Path, person) -> None:
    joints = to_y_up(person(3).joints)
    lafan = next(family for family in FAMILIES if family.name == "LaFAN1")
    lying = joints[..., (1, 0, 2)] * (1, -1, 1)
    usual = read(write_rig(tmp_path / "lying.bvh", *rig_points(lafan, lying)), NO_OPTIONS)
    assert usual.notes == ("skeleton: LaFAN1; lengths in m, y up",)
    mixamo = next(family for family in FAMILIES if family.name == "Mixamo")
    unclear = write_rig(tmp_path / "lying.bvh", *rig_points(mixamo, lying))
    with pytest.raises(InvalidOption, match="--up: name the up axis"):
        read(unclear, NO_OPTIONS)
    assert read(unclear, SourceOptions(up="y")).notes == ("skeleton: Mixamo; lengths in m, y up",)
    swapped = write_rig(tmp_path / "swapped.bvh", *rig_points(lafan, joints * (-1, 1, 1)))
    with pytest.raises(InvalidFile, match="left and right are swapped"):
        read(swapped, NO_OPTIONS)


def test_frame_times_are_rounded_in_files(tmp_path: Path, person) -> None:
    lafan = next(family for family in FAMILIES if family.name == "LaFAN1")
    path = write_rig(tmp_path / "a.bvh", *rig_points(lafan, to_y_up(person(3).joints)), fps=30)
    path.write_text(path.read_text().replace("0.033333333", "0.033333"))
    assert read(path, NO_OPTIONS).content.fps == 30
    assert read(path, SourceOptions(source_fps=60)).content.fps == 60
    path.write_text(path.read_text().replace("0.033333", "0.0333667"))
    assert read(path, NO_OPTIONS).content.fps == pytest.approx(29.97, abs=1e-3)


RENAMED = {name: f"rig_{name}" for name in JOINT_NAMES}


def test_the_error_of_an_unknown_skeleton_is_a_mapping_to_start_from(tmp_path: Path, person) -> None:
    pose = person(3)
    names = [f"{name.split('_')[1]}.{name[0].upper()}" if "_" in name else name for name in JOINT_NAMES]
    names[INDEX["left_knee"]] = "kneeeee.L"
    path = write_rig(tmp_path / "a.bvh", names, to_y_up(pose.joints))
    with pytest.raises(InvalidFile, match=r"--mapping mapping\.yaml") as error:
        read(path, NO_OPTIONS)
    text = str(error.value).partition("\n")[2]
    guesses = yaml.safe_load(text)
    assert list(guesses) == list(JOINT_NAMES)
    assert {joint for joint, guess in guesses.items() if guess == "FILL_IN"} == {"left_knee"}
    assert guesses["right_wrist"] == "wrist.R"
    assert guesses["spine2"] == "spine2"
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text(text)
    with pytest.raises(UnknownName, match=r"joint \(for left_knee in .*\) 'FILL_IN'"):
        read(path, SourceOptions(mapping=mapping))
    mapping.write_text(text.replace("left_knee: FILL_IN", "left_knee: kneeeee.L"))
    source = read(path, SourceOptions(mapping=mapping))
    assert isinstance(source.content, HumanMotion)
    np.testing.assert_allclose(source.content.joints, pose.joints, atol=1e-4)


def test_trunk_joints_that_a_file_lacks_are_interpolated_and_said(tmp_path: Path, person) -> None:
    pose = person(5)
    kept = [name for name in JOINT_NAMES if "collar" not in name and name not in ("spine2", "head", "neck")]
    points = to_y_up(pose.joints[:, [INDEX[name] for name in kept]])
    path = write_rig(tmp_path / "a.bvh", [RENAMED[name] for name in kept], points)
    mapping = tmp_path / "mapping.yaml"
    mapping.write_text("".join(f"{name}: {RENAMED[name].removeprefix('rig_')}\n" for name in kept) + "left_collar:\n")
    source = read(path, SourceOptions(mapping=mapping, up="y"))
    assert isinstance(source.content, HumanMotion)
    assert source.notes[0] == "not in the file, interpolated: spine2, neck, left_collar, right_collar, head"
    joints = source.content.joints
    middle = (joints[:, INDEX["left_shoulder"]] + joints[:, INDEX["right_shoulder"]]) / 2
    np.testing.assert_allclose(joints[:, INDEX["neck"]], middle, atol=1e-9)
    span = joints[:, INDEX["spine3"]] - joints[:, INDEX["spine1"]]
    np.testing.assert_allclose(joints[:, INDEX["spine2"]], joints[:, INDEX["spine1"]] + 0.26 / 0.38 * span, atol=1e-9)


def test_known_skeletons_may_lack_hands_toes_and_trunk_joints(tmp_path: Path, person) -> None:
    pose = person(1)
    lafan = next(family for family in FAMILIES if family.name == "LaFAN1")
    names, points = rig_points(lafan, to_y_up(100 * pose.joints))
    ends = {"LeftHand": "LeftForeArm_end", "RightHand": "RightForeArm_end", "LeftToe": "LeftFoot_end"}
    kept = [i for i, name in enumerate(names) if name not in ("LeftShoulder", "Spine1")]
    names = [ends.get(names[i], names[i]) for i in kept]
    source = read(write_rig(tmp_path / "a.bvh", names, points[:, kept]), NO_OPTIONS)
    assert isinstance(source.content, HumanMotion)
    assert source.notes[:-1] == (
        "left_wrist: LeftForeArm_end stands in",
        "right_wrist: RightForeArm_end stands in",
        "left_foot: LeftFoot_end stands in",
        "not in the file, interpolated: spine2, left_collar",
    )
    rest = [INDEX[name] for name in JOINT_NAMES if name not in ("spine2", "left_collar")]
    np.testing.assert_allclose(source.content.joints[:, rest], pose.joints[:, rest], atol=1e-4)
    no_knee = [name.replace("LeftLeg", "LeftStump") for name in names]
    with pytest.raises(InvalidFile, match=r"--mapping mapping\.yaml"):
        read(write_rig(tmp_path / "a.bvh", no_knee, points[:, kept]), NO_OPTIONS)


@pytest.mark.parametrize(
    ("text", "error", "message"),
    [
        ("pelvis: Hips", InvalidFile, "says nothing of left_hip, right_hip, left_knee"),
        ("tail: Hips", UnknownName, "unknown joint in .* 'tail'"),
        ("pelvis: [Hips, Head]", UnknownName, "Hips.*Head.*; valid: "),
        ("pelvis: Tail", UnknownName, "'Tail'; valid: .*Hips"),
        ("pelvis: {Hips: 0.5}", InvalidFile, "pelvis: the weights sum to 0.5, expected 1"),
        ("pelvis: {Hips: much}", InvalidFile, "the weight of Hips is 'much'"),
        ("- pelvis", InvalidFile, "expected lines such as 'pelvis: Hips'"),
        ("pelvis: [", InvalidFile, "not a YAML mapping"),
    ],
)
def test_errors_in_a_mapping_name_the_line(tmp_path: Path, person, text: str, error: type, message: str) -> None:
    path = write_rig(tmp_path / "a.bvh", ["Hips", "Head"], person(2).joints[:, :2])
    (tmp_path / "mapping.yaml").write_text(text)
    with pytest.raises(error, match=message):
        read(path, SourceOptions(mapping=tmp_path / "mapping.yaml"))


def test_completed_weights_sum_to_one() -> None:
    table = {name: {name: 1.0} for name in JOINT_NAMES if not name.startswith(("spine", "neck", "head"))}
    full = complete({name: blend for name, blend in table.items() if "collar" not in name})
    assert set(full) == set(JOINT_NAMES)
    assert all(sum(blend.values()) == pytest.approx(1) for blend in full.values())


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 12), st.floats(0, 2.5), st.sampled_from([0, 0.03]))
def test_round_trip(tmp_path_factory, person, seed: int, frames: int, size: float, stretch: float) -> None:
    path = tmp_path_factory.mktemp("bvh") / "a.bvh"
    motion = person(frames, seed=seed, size=size)
    rng = np.random.default_rng(seed)
    motion = HumanMotion(motion.joints + stretch * rng.normal(size=motion.joints.shape), 20.0)
    notes = write(path, motion)
    assert bool(notes) == (stretch > 0 and frames > 1)
    back = read(path, SourceOptions(units="cm", up="y")).content
    assert isinstance(back, HumanMotion)
    assert back.fps == 20
    np.testing.assert_allclose(back.joints, motion.joints, atol=1e-3)
    if frames > 1 and not stretch:
        assert path.read_text().count("Xposition") == 1


def test_bones_of_no_length_and_half_turns_are_written_too(tmp_path: Path, person) -> None:
    joints = np.array(person(3).joints)
    joints[:, INDEX["head"]] = joints[:, INDEX["neck"]]
    joints[1, INDEX["left_wrist"]] = 2 * joints[1, INDEX["left_elbow"]] - joints[0, INDEX["left_wrist"]]
    motion = HumanMotion(joints, 20.0)
    write(tmp_path / "a.bvh", motion)
    back = read(tmp_path / "a.bvh", NO_OPTIONS).content
    assert isinstance(back, HumanMotion)
    np.testing.assert_allclose(back.joints, joints, atol=1e-6)
