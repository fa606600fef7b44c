"""The ladder: the first rung that passes, what was changed for it, and what was tried where none does."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import INDEX, JOINT_COUNT
from sim.repair import GENTLER, Change, gentler, repair, turning


def person(frames: int = 40) -> HumanMotion:
    """Somebody whose hips keep their heading while the right wrist rises."""
    joints = np.zeros((frames, JOINT_COUNT, 3))
    joints[:, INDEX["left_hip"], 1], joints[:, INDEX["right_hip"], 1] = 0.1, -0.1
    joints[:, INDEX["right_wrist"], 2] = np.linspace(0.8, 1.8, frames)
    return HumanMotion(joints, 20.0, "a person raises the right hand", (Segment("raises", 0.0, 2.0),))


@given(st.floats(0.3, 3.0), st.floats(0.1, 1.0))
@settings(max_examples=30, deadline=None)
def test_slower_and_smaller(slowdown, amplitude):
    motion = person()
    changed = gentler(motion, Change(slowdown=slowdown, amplitude=amplitude))
    assert changed.duration_s == pytest.approx(slowdown * motion.duration_s)
    assert changed.segments[0].end_s == pytest.approx(2.0 * slowdown)
    risen = np.ptp(changed.joints[:, INDEX["right_wrist"], 2])
    assert risen == pytest.approx(amplitude * 1.0)
    assert np.ptp(changed.joints[:, INDEX["left_foot"]], axis=0) == pytest.approx(0.0)


def test_turning():
    assert turning(person()) == 0
    joints = person(5).joints.copy()
    joints[-1, :, :2] = joints[-1, :, :2] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    assert turning(HumanMotion(joints, 20.0)) == pytest.approx(np.pi / 2)


def test_a_motion_that_passes_is_left_alone(op3, standing):
    trajectory = standing(op3)
    found = repair(trajectory, op3, motion=person(), retarget=lambda motion: pytest.fail(f"{motion} was changed"))
    assert found.judgement.passed
    assert found.trajectory is trajectory
    assert found.change == Change() and len(found.tried) == 1
    assert not any(note.startswith("changed") for note in found.judgement.verdict.notes)


def test_slower_until_it_passes(op3, standing):
    """The head turns to and fro at 1.4 times its speed limit until the motion takes 1.6 times as long."""

    def turning_head(motion: HumanMotion):
        slowdown = motion.duration_s / 2.0
        time = np.arange(round(50.0 * motion.duration_s)) / 50.0
        return standing(op3, frames=len(time), joints={"head_pan": 0.75 * (1 - np.cos(8.0 / slowdown * time))})

    found = repair(turning_head(person()), op3, motion=person(), retarget=turning_head, level="lenient")
    assert found.judgement.passed, found.tried
    assert found.change == Change(slowdown=1.6) and found.controller == "default"
    assert found.tried[0].startswith("as it was, default controller: failed joint_velocity")
    assert not any("wbc" in line for line in found.tried), "another controller cannot mend a joint speed"
    assert "changed: 1.6 times slower, default controller" in found.judgement.verdict.notes[-1]
    assert found.judgement.verdict.trajectory_digest == found.trajectory.digest


def test_infeasible_with_the_reason(op3, standing):
    rise = np.zeros((40, 3))
    rise[:, 2] = np.linspace(0, 0.3, 40)
    floating = standing(op3, frames=40, root_offset=rise, contacts=False)
    found = repair(floating, op3, motion=person(), retarget=lambda motion: floating)
    assert not found.judgement.passed
    assert found.trajectory is floating and found.change == Change()
    tried = [note for note in found.judgement.verdict.notes if note.startswith("tried")]
    assert len(found.tried) >= 1 + len(GENTLER)
    assert len(tried) == len(found.tried) - 1
    assert "wbc controller" in " ".join(found.tried) and "fall_height" in found.tried[0]


def test_without_the_human_motion_only_controllers_are_tried(op3, standing):
    rise = np.zeros((40, 3))
    rise[:, 2] = np.linspace(0, 0.3, 40)
    floating = standing(op3, frames=40, root_offset=rise, contacts=False)
    found = repair(dataclasses.replace(floating), op3)
    assert [line.split(":")[0] for line in found.tried] == [
        "as it was, default controller",
        "as it was, wbc controller",
    ]
