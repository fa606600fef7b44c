"""The ladder: the first rung that passes, what was changed for it, and what was tried where none does."""

import dataclasses

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.robot_model import kinematic_model, standing_qpos
from ros_free_stack.skeleton import INDEX, JOINT_COUNT
from sim.judge.repair import GENTLER, Change, gentler, repair, turning
from sim.judge.verdict import judge


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
        return standing(op3, frames=len(time), joints={"head_pan": 0.505 * (1 - np.cos(8.0 / slowdown * time))})

    found = repair(turning_head(person()), op3, motion=person(), retarget=turning_head, level="lenient")
    assert found.judgement.passed, found.tried
    assert found.change == Change(slowdown=1.6) and found.controller == "default"
    assert found.tried[0].startswith("as it was, default controller: failed joint_velocity")
    assert not any("wbc" in line for line in found.tried), "another controller cannot mend a joint speed"
    assert "changed: 1.6 times slower, default controller" in found.judgement.verdict.notes[-1]
    assert found.judgement.verdict.trajectory_digest == found.trajectory.digest


def leaning(op3, standing, frames: int = 60):
    """OP3 turns forward about its ankles with flat soles, until its weight is in front of them."""
    lean = 0.4 * np.clip(np.arange(frames) / 50, 0, 1)
    angles = {"l_ank_pitch": op3.standing["l_ank_pitch"] + lean, "r_ank_pitch": op3.standing["r_ank_pitch"] - lean}
    upright = standing(op3, frames=frames, joints=angles)
    model = kinematic_model(op3)
    data = mujoco.MjData(model)
    data.qpos[:] = standing_qpos(model, op3)
    mujoco.mj_kinematics(model, data)
    ankle, turned = data.joint("l_ank_pitch").xanchor, Rotation.from_rotvec(np.outer(lean, [0.0, 1.0, 0.0]))
    return dataclasses.replace(
        upright,
        root_pos=ankle + turned.apply(upright.root_pos - ankle),
        root_quat=(turned * Rotation.from_quat(upright.root_quat, scalar_first=True)).as_quat(scalar_first=True),
    )


def test_infeasible_with_the_reason(op3, standing):
    falling = leaning(op3, standing)
    found = repair(falling, op3, motion=person(), retarget=lambda motion: falling)
    assert not found.judgement.passed
    assert found.trajectory is falling and found.change == Change()
    tried = [note for note in found.judgement.verdict.notes if note.startswith("tried")]
    assert len(found.tried) >= 1 + len(GENTLER)
    assert len(tried) == len(found.tried) - 1
    assert "wbc controller" in " ".join(found.tried) and "fall_height" in found.tried[0]


def test_without_the_human_motion_only_controllers_are_tried(op3, standing):
    found = repair(leaning(op3, standing), op3)
    assert [line.split(":")[0] for line in found.tried] == [
        "as it was, default controller",
        "as it was, wbc controller",
    ]


def test_what_is_known_is_not_judged_again(op3, standing, monkeypatch):
    falling = leaning(op3, standing)
    known = judge(falling, op3)
    asked: list[str] = []

    def counted(trajectory, robot, **options):
        asked.append(options["controller"])
        return judge(trajectory, robot, **options)

    monkeypatch.setattr("sim.judge.repair.judge", counted)
    found = repair(falling, op3, known=known)
    assert asked == ["wbc"]
    assert found.tried[0].startswith("as it was, default controller: failed")
    assert found.judgement.verdict.checks == known.verdict.checks
