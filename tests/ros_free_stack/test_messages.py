"""Messages refuse wrong arrays by field name and are immutable."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_free_stack.errors import InvalidMessage
from ros_free_stack.messages import Check, HumanMotion, RobotTrajectory, Segment, Verdict


def trajectory(**changes) -> RobotTrajectory:
    fields = {
        "robot": "op3",
        "model_sha256": "0" * 64,
        "joint_names": ("a", "b"),
        "fps": 50.0,
        "root_pos": np.zeros((3, 3)),
        "root_quat": np.tile([1.0, 0, 0, 0], (3, 1)),
        "joint_pos": np.zeros((3, 2)),
        "contacts": np.ones((3, 2), bool),
        "foot_names": ("left", "right"),
    }
    return RobotTrajectory(**{**fields, **changes})


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({"root_pos": np.zeros((2, 3))}, "root_pos"),
        ({"root_quat": np.zeros((3, 4))}, "root_quat"),
        ({"joint_pos": np.zeros((3, 3))}, "joint_pos"),
        ({"joint_pos": np.full((3, 2), np.nan)}, "joint_pos"),
        ({"contacts": np.ones((3, 1))}, "contacts"),
        ({"fps": 0.0}, "fps"),
        ({"fps": float("nan")}, "fps"),
        ({"joint_names": ("a", "a")}, "joint_names"),
        ({"joint_pos": "words"}, "joint_pos"),
        ({"joint_pos": np.zeros((0, 2))}, "joint_pos"),
    ],
)
def test_wrong_trajectory_names_the_field(changes, field):
    with pytest.raises(InvalidMessage) as caught:
        trajectory(**changes)
    assert caught.value.field == field
    assert field in str(caught.value)


@pytest.mark.parametrize("joints", [np.zeros((5, 21, 3)), np.zeros((22, 3)), np.full((5, 22, 3), np.inf)])
def test_wrong_motion_is_refused(joints):
    with pytest.raises(InvalidMessage, match=r"HumanMotion\.joints"):
        HumanMotion(joints=joints, fps=20)


def test_arrays_are_read_only_copies():
    source = np.zeros((4, 22, 3))
    motion = HumanMotion(joints=source, fps=20)
    source[0, 0, 0] = 1
    assert motion.joints[0, 0, 0] == 0
    with pytest.raises(ValueError, match="read-only"):
        motion.joints[0, 0, 0] = 1
    with pytest.raises(dataclasses.FrozenInstanceError):
        motion.fps = 30  # type: ignore[misc]


def test_segment_times_are_ordered():
    with pytest.raises(InvalidMessage):
        Segment("a person bows", 2.0, 1.0)


@given(st.integers(0, 2), st.integers(0, 1), st.floats(1e-9, 1.0))
def test_digest_sees_every_joint_value(frame, joint, change):
    changed = np.zeros((3, 2))
    changed[frame, joint] = change
    assert trajectory(joint_pos=changed).digest != trajectory().digest


def test_digest_is_stable():
    assert trajectory().digest == trajectory().digest


def test_verdict_needs_at_least_one_check_and_all_passed():
    good = Check("a", 0.0, "m", 1.0, True)
    bad = Check("b", 2.0, "m", 1.0, False)
    assert Verdict("op3", "", "", (good,)).passed
    assert not Verdict("op3", "", "", ()).passed
    assert not Verdict("op3", "", "", (good, bad)).passed
    assert Verdict("op3", "", "", (good, bad)).failures == (bad,)


def _changed(array, index, value):
    changed = np.array(array)
    changed[index] = value
    return changed


@pytest.mark.parametrize(
    "changes",
    [
        {"robot": "g1"},
        {"model_sha256": "1" * 64},
        {"joint_names": ("a", "c")},
        {"foot_names": ("left", "other")},
        {"fps": 50.000001},
        {"root_pos": _changed(np.zeros((3, 3)), (2, 2), 1e-12)},
        {"root_quat": np.tile([-1.0, 0, 0, 0], (3, 1))},
        {"joint_pos": _changed(np.zeros((3, 2)), (0, 1), 1e-12)},
        {"contacts": _changed(np.ones((3, 2), bool), (1, 0), False)},
    ],
    ids=lambda changes: next(iter(changes)),
)
def test_digest_sees_every_field(changes):
    assert trajectory(**changes).digest != trajectory().digest


def test_every_field_of_a_trajectory_is_in_the_digest_test():
    (mark,) = test_digest_sees_every_field.pytestmark
    assert {name for changes in mark.args[1] for name in changes} == {
        field.name for field in dataclasses.fields(RobotTrajectory)
    }


@pytest.mark.parametrize("off", [1e-5, -1e-5])
def test_quaternions_a_little_off_unit_norm_are_refused(off):
    root_quat = np.tile([1.0, 0, 0, 0], (3, 1))
    root_quat[1] *= 1 + off
    with pytest.raises(InvalidMessage, match=r"root_quat.*frame 1"):
        trajectory(root_quat=root_quat)


@pytest.mark.parametrize(
    ("value", "minimum", "holds"),
    [(1.0, False, True), (1.1, False, False), (1.0, True, True), (1.1, True, True), (0.9, True, False)],
)
def test_a_check_holds_by_its_numbers_alone(value, minimum, holds):
    for passed in (True, False):
        assert Check("a", value, "m", 1.0, passed, minimum=minimum).holds is holds


@pytest.mark.parametrize("minimum", [True, False])
def test_no_number_never_holds(minimum):
    assert not Check("a", float("nan"), "m", 1.0, True, minimum=minimum).holds
