"""Known truths: standing passes, and what breaks one rule fails that rule alone."""

import dataclasses

import numpy as np
import pytest

from ros_free_stack.errors import InvalidMessage, InvalidOption, ModelMismatch, UnknownName
from ros_free_stack.robots import load_robot
from sim.judge.verdict import judge


def failures(judgement) -> set[str]:
    return {check.name for check in judgement.verdict.failures}


@pytest.mark.parametrize("name", ["op3", "g1"])
@pytest.mark.parametrize("mount", ["free", "fixed"])
def test_standing_passes_everything(name, mount, request, standing):
    robot = request.getfixturevalue(name)
    judgement = judge(standing(robot), robot, mount=mount, level="strict")
    assert judgement.passed, judgement.verdict.failures
    assert judgement.playback is not None and judgement.playback.fell_at_s is None
    assert judgement.verdict.trajectory_digest == standing(robot).digest


def test_arms_on_a_stand_are_judged_without_feet(standing):
    robot = load_robot("g1_upper")
    judgement = judge(standing(robot), robot)
    assert judgement.passed, judgement.verdict.failures
    assert judgement.verdict.mount == "fixed"
    assert not {"foot_skate", "fall_height", "spatial_coherence"} & {check.name for check in judgement.verdict.checks}


def test_legs_alone_are_judged_without_coherence(standing):
    robot = load_robot("berkeley")
    names = {check.name for check in judge(standing(robot), robot, physics=False).verdict.checks}
    assert "foot_skate" in names
    assert "temporal_coherence" not in names


def test_swinging_feet_may_move(op3, standing):
    slide = np.zeros((100, 3))
    slide[:, 0] = 0.3 * np.arange(100) / 50.0
    assert judge(standing(op3, frames=100, root_offset=slide, contacts=False), op3, physics=False).passed


@pytest.mark.parametrize("name", ["op3", "g1"])
def test_leaning_robot_falls(name, request, standing):
    robot = request.getfixturevalue(name)
    share = np.clip((np.arange(150) - 25) / 60, 0, 1)
    lean = {"op3": 0.88, "g1": 0.45}[name] * share**2 * (3 - 2 * share)
    ankles = {"op3": {"l_ank_pitch": 0.35, "r_ank_pitch": -0.35}, "g1": dict.fromkeys(
        ("left_ankle_pitch_joint", "right_ankle_pitch_joint"), -0.25)}[name]  # fmt: skip
    signs = {"op3": {"l_ank_pitch": -1, "r_ank_pitch": 1}, "g1": dict.fromkeys(ankles, 1)}[name]
    joints = {joint: start + signs[joint] * lean for joint, start in ankles.items()}
    trajectory = standing(robot, frames=150, joints=joints)
    judgement = judge(trajectory, robot)
    assert {"fall_height", "fall_orientation"} & failures(judgement)
    assert judgement.playback is not None and judgement.playback.fell_at_s is not None
    assert judgement.playback.frames <= len(judgement.reference.qpos)
    assert len(judgement.reference.qpos) / judgement.reference.trajectory.fps < 3.1
    held = judge(trajectory, robot, mount="fixed")
    assert held.passed, held.verdict.failures
    assert not {"ground_penetration", "fall_height", "foot_skate"} & {c.name for c in held.verdict.checks}


def test_floating_reference_fails_in_physics(op3, standing):
    rise = np.zeros((100, 3))
    rise[:, 2] = np.linspace(0, 0.2, 100)
    judgement = judge(standing(op3, frames=100, root_offset=rise, contacts=False), op3)
    assert "fall_height" in failures(judgement)


def test_one_frame_is_judged(op3, standing):
    assert judge(standing(op3, frames=1), op3).passed


def test_other_model_is_refused(op3, g1, standing):
    with pytest.raises(ModelMismatch, match="made for op3"):
        judge(standing(op3), g1)
    renamed = dataclasses.replace(standing(op3), joint_names=("nose", *op3.joint_names[1:]), model_sha256=op3.sha256)
    with pytest.raises(ModelMismatch, match="nose"):
        judge(renamed, op3)


def test_joint_order_does_not_matter(op3, standing):
    pan = np.linspace(0, 2.0, 100)
    trajectory = standing(op3, frames=100, joints={"head_pan": pan})
    shuffled = dataclasses.replace(
        trajectory, joint_names=trajectory.joint_names[::-1], joint_pos=trajectory.joint_pos[:, ::-1]
    )
    first, second = (judge(item, op3, physics=False).verdict for item in (trajectory, shuffled))
    assert first.checks == second.checks


def test_same_verdict_twice(op3, standing):
    trajectory = standing(op3, joints={"l_el": 0.6 + 0.3 * np.sin(0.1 * np.arange(50))})
    assert judge(trajectory, op3).verdict == judge(trajectory, op3).verdict


def test_unknown_level(op3, standing):
    with pytest.raises(UnknownName, match="strict"):
        judge(standing(op3), op3, level="gentle")  # pyright: ignore[reportArgumentType]


def test_a_huge_clip_is_refused_at_once(op3, standing):
    trajectory = dataclasses.replace(standing(op3, frames=50), fps=0.05)
    with pytest.raises(InvalidOption, match="lasts 1000 s, expected at most 600 s: cut it into parts"):
        judge(trajectory, op3)


def test_a_negative_number_of_runs(op3, standing):
    with pytest.raises(InvalidOption, match="--perturbed: expected 0 or more runs, found -1"):
        judge(standing(op3), op3, perturbed=-1)


@pytest.mark.parametrize(
    ("change", "message"),
    [({"fps": 0.0}, "fps: expected a positive number"), ({"joint_pos": np.full((50, 20), np.nan)}, "found nan at")],
)
def test_what_no_trajectory_can_hold(op3, standing, change, message):
    with pytest.raises(InvalidMessage, match=message):
        dataclasses.replace(standing(op3), **change)


@pytest.mark.parametrize("controller", ["pd", "wbc"])
@pytest.mark.parametrize("state", ["true", "estimated"])
def test_standing_passes_with_every_controller(op3, standing, controller, state):
    judgement = judge(standing(op3, frames=25), op3, controller=controller, state=state)
    assert judgement.passed, judgement.verdict.failures
    assert f"played by the {controller} controller on the {state} state" in judgement.verdict.notes


@pytest.mark.parametrize("name", ["h1", "t1"])
def test_other_robots_stand_too(name, standing):
    """H1's model has bare motors, T1 hangs its pelvis from the trunk."""
    robot = load_robot(name)
    judgement = judge(standing(robot), robot)
    assert judgement.passed, judgement.verdict.failures


def test_an_arm_of_h1_follows(standing):
    """Bare motors driven by angles as if these were torques lagged by more than a radian a second."""
    robot = load_robot("h1")
    swing = robot.standing["left_elbow"] + 0.4 * (1 - np.cos(4.0 * np.arange(100) / 50))
    judgement = judge(standing(robot, frames=100, joints={"left_elbow": swing}), robot)
    (check,) = [check for check in judgement.verdict.checks if check.name == "joint_velocity_error"]
    assert judgement.passed and check.value < 0.2
