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
