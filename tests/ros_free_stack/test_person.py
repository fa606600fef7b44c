"""What every reader of human motion does with the joints that it read."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats.body import is_t_pose
from ros_free_stack.formats.frames import from_y_up, resample, stand, to_y_up
from ros_free_stack.formats.jumps import find_capture
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.source import SourceOptions, Units
from ros_free_stack.formats.stature import METRES, stature
from ros_free_stack.messages import Floats, HumanMotion
from ros_free_stack.skeleton import INDEX, MIRRORED

NAMELESS = Habits(title="test")
Y_UP = Habits(title="test", up="y", units="m")
NO_OPTIONS = SourceOptions()
FILE = Path("a.bvh")


def read(joints: Floats, options: SourceOptions = NO_OPTIONS, habits: Habits = Y_UP, fps: float | None = 30.0):
    source = person_source(FILE, joints, options, habits, fps=fps)
    assert isinstance(source.content, HumanMotion)
    return source.content, source.notes


# --- rates ---


@pytest.mark.parametrize(
    ("fps", "hint"),
    [
        (1 / 30, r"states 0.03333 frames a second, 30 s each \(perhaps 30 or 33.33 is meant\)"),
        (1 / 8.333, r"8.333 s each \(perhaps 8.333 or 120 is meant\)"),
        (1.0, "states 1 frames a second"),
        (3e4, "states 3e.04 frames a second"),
        (0.0, "states none that is positive"),
        (np.nan, "states none that is positive"),
        (None, "does not state it"),
    ],
)
def test_a_rate_that_cannot_be_is_asked_for(person, fps: float | None, hint: str) -> None:
    joints = to_y_up(person(10).joints)
    with pytest.raises(InvalidOption, match=f"--source-fps: name the frame rate of a.bvh: .*{hint}"):
        read(joints, fps=fps)
    motion, _ = read(joints, SourceOptions(source_fps=30), fps=fps)
    assert motion.fps == 30
    with pytest.raises(InvalidOption, match="--source-fps: expected 5 to 1000 frames a second"):
        read(joints, SourceOptions(source_fps=0.033), fps=fps)


def test_a_rate_that_makes_hands_too_fast_is_doubted(person) -> None:
    joints = to_y_up(person(40).joints)
    assert not read(joints)[1]
    assert any("m/s: is 1000 the right frame rate" in note for note in read(joints, SourceOptions(source_fps=1000))[1])


# --- sizes ---


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(list(METRES)), st.floats(1.3, 2.1), st.floats(0.75, 1.3), st.floats(0.75, 1.3))
def test_the_unit_is_told_by_the_whole_body(person, unit: Units, tall: float, legs: float, arms: float) -> None:
    """Long legs or short arms alone mislead nobody."""
    joints = np.array(person(3).joints)
    joints *= tall / stature(joints)
    for side in ("left", "right"):
        hip, shoulder = (joints[:, [INDEX[f"{side}_{name}"]]] for name in ("hip", "shoulder"))
        leg, arm = (
            [INDEX[f"{side}_{name}"] for name in names] for names in (("knee", "ankle", "foot"), ("elbow", "wrist"))
        )
        joints[:, leg] = hip + legs * (joints[:, leg] - hip)
        joints[:, arm] = shoulder + arms * (joints[:, arm] - shoulder)
    assert stature(joints) == pytest.approx(tall, rel=0.31)
    if not 1.3 < stature(joints) < 2.1:
        return
    motion, notes = read(to_y_up(joints) / METRES[unit], habits=replace(NAMELESS, up="y", told=True))
    np.testing.assert_allclose(motion.joints, stand(joints), atol=1e-9)
    assert notes == (f"skeleton: test; lengths in {unit}, y up",)


def test_a_size_of_no_unit_is_one_guess_and_told(person) -> None:
    pose = person(3).joints
    joints = to_y_up(pose)
    for scale in (24.5, 26.2, 400.0, 7e-3):
        motion, notes = read(scale * joints, habits=NAMELESS)
        assert stature(motion.joints) == pytest.approx(1.7)
        assert "scaled to 1.7 m; --height or --units settles it" in notes[1]
        np.testing.assert_allclose(read(scale * joints, SourceOptions(height=stature(pose)))[0].joints, pose, atol=1e-9)
    assert stature(read(24.5 * joints, SourceOptions(units="cmu"))[0].joints) > 2
    for options in (SourceOptions(height=1.7, units="m"), SourceOptions(height=170)):
        with pytest.raises(InvalidOption, match=r"--height: expected 0\.3 to 3 m, and no --units"):
            read(joints, options)
    with pytest.raises(InvalidOption, match="no length"):
        read(0 * joints)


def test_a_usual_unit_gives_way_to_the_person_and_stays_in_doubt(person) -> None:
    pose = person(3).joints
    np.testing.assert_allclose(read(100 * to_y_up(pose))[0].joints, pose, atol=1e-9)
    child, notes = read(0.6 * to_y_up(pose))
    assert stature(child.joints) == pytest.approx(0.6 * stature(pose))
    assert any("m tall if lengths are in m; --height or --units settles it" in note for note in notes)


# --- up ---


@pytest.mark.parametrize("usual", [None, "y", "z"])
@pytest.mark.parametrize("up", ["y", "z", "y-down"])
def test_up_is_the_way_in_which_the_person_stands(person, usual, up) -> None:
    pose = person(4).joints
    points = {"y": to_y_up(pose), "z": pose, "y-down": to_y_up(pose) * (1, -1, -1)}[up]
    motion, notes = read(points, habits=replace(Y_UP, up=usual))
    np.testing.assert_allclose(motion.joints, stand(pose), atol=1e-9)
    told = " ".join(notes)
    assert (f"{up} up" in told) == (usual != up)
    assert ("--up overrules" in told) == (usual != up and (usual is not None or up == "y-down"))
    np.testing.assert_array_equal(read(points, SourceOptions(up=up))[0].joints, motion.joints)


def test_a_person_who_lies_leaves_up_as_usual_or_asked_for(person) -> None:
    pose = person(4).joints
    lying = to_y_up(pose)[..., (1, 0, 2)] * (1, -1, 1)
    motion, notes = read(lying)
    assert np.ptp(motion.joints[..., 2]) < 1.2 and not notes
    with pytest.raises(InvalidOption, match=r"--up: name the up axis of a.bvh \(y or z\)"):
        read(lying, habits=NAMELESS)
    np.testing.assert_allclose(read(lying, SourceOptions(up="x"))[0].joints[..., 2], stand(pose)[..., 2], atol=1e-9)
    with pytest.raises(InvalidOption, match="--up"):
        read(pose * (1, -1, -1), habits=replace(Y_UP, up="z"))


# --- frames that are no capture ---


@pytest.fixture
def t_pose(rest: Floats) -> Floats:
    """(22, 3) m, z up."""
    return from_y_up(rest)


def walk(person, frames: int = 60, fps: float = 30.0) -> Floats:
    """A motion whose arms hang, z up."""
    slow = person(round(frames * 20 / fps) + 2, size=0.25).joints
    joints = resample(slow, fps=20.0, to=fps)[:frames]
    for side, sign in (("left", -1), ("right", 1)):
        shoulder = joints[:, [INDEX[f"{side}_shoulder"]]]
        arm = [INDEX[f"{side}_{name}"] for name in ("elbow", "wrist")]
        joints[:, arm] = shoulder + (joints[:, arm] - shoulder)[..., (0, 2, 1)] * (1, 1, sign)
    assert len(joints) == frames
    return joints


@pytest.mark.parametrize("fps", [20.0, 30.0, 60.0, 120.0])
@pytest.mark.parametrize("far", [(0, 0, 0), (0, -4, 0), (0.5, 0, 0)])
@pytest.mark.parametrize("held", [1, 2, 45])
def test_a_pose_before_or_after_the_motion_is_left_out_and_told(person, t_pose, fps, far, held) -> None:
    motion = walk(person, fps=fps)
    pose = np.repeat((t_pose + far)[None], held, axis=0)
    for joints, where in (
        (np.concatenate([pose, motion]), "first"),
        (np.concatenate([motion, motion[-1, 0] * (1, 1, 0) + pose]), "last"),
    ):
        found, notes = read(to_y_up(joints), fps=fps)
        np.testing.assert_allclose(found.joints, stand(motion), atol=1e-9)
        assert any(f"the {where} {held} frame" in note and "left out" in note for note in notes)


def test_a_pose_that_a_person_holds_is_left_out_too(person, t_pose) -> None:
    """A T-pose of two seconds that is captured: it sways, so that nothing is frozen."""
    motion = walk(person)
    time = np.arange(60)[:, None, None] / 30
    sway = t_pose + 0.03 * np.sin(2 * time) * (0, 1, 0.2) * (t_pose[:, 2:] / 1.5)
    found, notes = read(to_y_up(np.concatenate([sway - np.array([0, 3, 0]), motion])))
    np.testing.assert_allclose(found.joints, stand(motion), atol=1e-9)
    assert notes == ("the first 60 frames are a pose that the motion jumps from or to: left out",)
    walks = np.concatenate([motion - np.array([0, 3, 0]), motion])
    assert len(read(to_y_up(walks))[0].joints) == 120


def test_a_smoothed_way_from_the_pose_is_left_out_with_it(person, t_pose) -> None:
    motion = walk(person, 240, 120.0)
    way = np.geomspace(1, 0.03, 6)[:, None, None]
    lead = way * t_pose + (1 - way) * motion[0]
    capture = find_capture(np.concatenate([lead, motion]), 120.0)
    assert (capture.start, capture.end, capture.jumps) == (pytest.approx(6, abs=1), 246, ())


def test_a_clip_without_a_pose_keeps_every_frame(person) -> None:
    for fps in (20.0, 30.0, 120.0):
        motion = walk(person, fps=fps)
        capture = find_capture(motion, fps)
        assert (capture.start, capture.end, capture.jumps) == (0, 60, ())


def test_a_jump_inside_is_told_and_kept(person) -> None:
    joints = walk(person)
    joints[20:, :, 0] += 1.0
    found, notes = read(to_y_up(joints))
    assert len(found.joints) == 60
    assert any(note.startswith("the motion jumps by 1.0") and "at 0.63 s; --start and --end" in note for note in notes)
    part, notes = read(to_y_up(joints), SourceOptions(start=0.7))
    assert len(part.joints) == 39 and not notes


def test_the_pose_of_calibration_is_known(t_pose, person) -> None:
    assert is_t_pose(t_pose)
    assert is_t_pose(t_pose @ np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]]).T)
    assert not is_t_pose(walk(person)[0])


# --- parts ---


def test_start_and_end_take_the_frames_between(person) -> None:
    joints = to_y_up(walk(person))
    whole, _ = read(joints)
    part, _ = read(joints, SourceOptions(start=0.5, end=1.0))
    np.testing.assert_allclose(part.joints, stand(whole.joints[15:31]), atol=0.02)
    assert len(read(joints, SourceOptions(end=99.0))[0].joints) == 60
    for options, message in (
        (SourceOptions(start=-1.0), "--start: expected seconds"),
        (SourceOptions(start=2.5), r"--start: a.bvh ends at 1.97 s, found 2.5"),
        (SourceOptions(start=1.0, end=0.5), r"--end: expected a time after --start \(1 s\), found 0.5"),
        (SourceOptions(end=np.nan), "--end: expected seconds"),
    ):
        with pytest.raises(InvalidOption, match=message):
            read(joints, options)


# --- bodies ---


def test_joints_that_are_no_person_are_refused(person) -> None:
    pose = person(4).joints

    def problem(change) -> str:
        joints = np.array(pose)
        change(joints)
        with pytest.raises(InvalidFile) as error:
            read(to_y_up(joints))
        return str(error.value)

    def move(joint: str, to: str, share: float = 1.0):
        def change(joints: Floats) -> None:
            a, b = INDEX[joint], INDEX[to]
            joints[:, a] += share * (joints[:, b] - joints[:, a])

        return change

    assert "left_ankle and left_foot lie together (0 % of the leg apart)" in problem(move("left_foot", "left_ankle"))
    assert "right_shoulder and right_elbow lie together" in problem(move("right_elbow", "right_shoulder"))
    assert "pelvis and neck lie together" in problem(move("neck", "pelvis"))
    assert "times as far as on the other side" in problem(move("left_wrist", "right_wrist"))
    mirrored = to_y_up(pose[:, list(MIRRORED)])
    with pytest.raises(InvalidFile, match="the toes point backwards: left and right are swapped"):
        read(mirrored)
    noise = to_y_up(pose) + np.random.default_rng(0).normal(size=pose.shape)
    with pytest.raises(InvalidFile, match=r"changes its length|other side|lie together"):
        read(noise)
    with pytest.raises(InvalidFile, match=r"expected joints \(T, 22, 3\), found \(4, 21, 3\)"):
        read(to_y_up(pose)[:, :21])
