"""Known truths: standing passes, and what breaks one rule fails that rule alone."""

import dataclasses

import numpy as np
import pytest

from ros_free_stack.errors import ModelMismatch, UnknownName
from ros_free_stack.robots import load_robot
from sim.verdict import judge


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


def test_beyond_the_range(op3, standing):
    pan = np.linspace(0, op3.joints["head_pan"].upper + 0.1, 200)
    judgement = judge(standing(op3, frames=200, joints={"head_pan": pan}), op3, physics=False)
    assert failures(judgement) == {"joint_range"}
    (check,) = judgement.verdict.failures
    assert (check.worst_item, check.worst_frame) == ("head_pan", 199)
    assert check.value == pytest.approx(0.1)


def sine(amplitude: float, omega: float, frames: int, fps: float) -> np.ndarray:
    return amplitude * np.sin(omega * np.arange(frames) / fps)


def test_too_fast(op3, standing):
    omega = 6.0
    pan = sine(1.2 * op3.joints["head_pan"].velocity / omega, omega, 200, 200.0)
    judgement = judge(standing(op3, frames=200, fps=200.0, joints={"head_pan": pan}), op3, physics=False)
    assert failures(judgement) == {"joint_velocity"}
    assert judgement.verdict.failures[0].value == pytest.approx(1.2, rel=1e-3)


def test_too_jerky(op3, standing):
    omega = 25.0
    pan = sine(1.3 * op3.joints["head_pan"].acceleration / omega**2, omega, 200, 200.0)
    judgement = judge(standing(op3, frames=200, fps=200.0, joints={"head_pan": pan}), op3, physics=False)
    assert failures(judgement) == {"joint_acceleration"}
    assert judgement.verdict.failures[0].value == pytest.approx(1.3, rel=2e-2)


@pytest.mark.parametrize("name", ["op3", "g1"])
def test_in_the_floor(name, request, standing):
    robot = request.getfixturevalue(name)
    judgement = judge(standing(robot, root_offset=[0, 0, -0.02]), robot, physics=False)
    assert failures(judgement) == {"ground_penetration"}
    assert judgement.verdict.failures[0].value == pytest.approx(0.02, abs=1e-3)


def test_slow_skating(op3, standing):
    slide = np.zeros((100, 3))
    slide[:, 1] = 0.05 * np.arange(100) / 50.0
    judgement = judge(standing(op3, frames=100, root_offset=slide), op3, physics=False)
    assert failures(judgement) == {"foot_skate"}
    assert judgement.verdict.failures[0].value == pytest.approx(0.05)


def test_one_slip(op3, standing):
    slide = np.zeros((200, 3))
    slide[100:, 0] = 0.5 / 50.0
    judgement = judge(standing(op3, frames=200, root_offset=slide), op3, physics=False)
    assert failures(judgement) == {"foot_skate_peak"}
    check = judgement.verdict.failures[0]
    assert check.value == pytest.approx(0.5) and check.worst_frame == 99


def test_swinging_feet_may_move(op3, standing):
    slide = np.zeros((100, 3))
    slide[:, 0] = 0.3 * np.arange(100) / 50.0
    assert judge(standing(op3, frames=100, root_offset=slide, contacts=False), op3, physics=False).passed


def test_legs_into_each_other(op3, standing):
    crossed = {"l_hip_roll": np.full(50, 0.35), "r_hip_roll": np.full(50, -0.35)}
    uncrossed = {"l_hip_roll": np.full(50, -0.35), "r_hip_roll": np.full(50, 0.35)}
    verdicts = [
        judge(standing(op3, root_offset=[0, 0, 0.1], joints=joints, contacts=False), op3, physics=False).verdict
        for joints in (crossed, uncrossed)
    ]
    failed = [{check.name for check in verdict.failures} for verdict in verdicts]
    assert sorted(failed, key=len) == [set(), {"self_collision"}]


@pytest.mark.parametrize("name", ["op3", "g1"])
def test_leaning_robot_falls(name, request, standing):
    robot = request.getfixturevalue(name)
    lean = 0.45 * np.clip((np.arange(150) - 25) / 50, 0, 1)
    ankles = {"op3": {"l_ank_pitch": 0.35, "r_ank_pitch": -0.35}, "g1": dict.fromkeys(
        ("left_ankle_pitch_joint", "right_ankle_pitch_joint"), -0.25)}[name]  # fmt: skip
    signs = {"op3": {"l_ank_pitch": -1, "r_ank_pitch": 1}, "g1": dict.fromkeys(ankles, 1)}[name]
    joints = {joint: start + signs[joint] * lean for joint, start in ankles.items()}
    trajectory = standing(robot, frames=150, joints=joints)
    judgement = judge(trajectory, robot)
    assert {"fall_height", "fall_orientation"} & failures(judgement)
    assert judgement.playback is not None and judgement.playback.fell_at_s is not None
    assert judgement.playback.frames <= 150
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
    trajectory = standing(op3, joints={"l_el": 0.6 + sine(0.3, 5.0, 50, 50.0)})
    assert judge(trajectory, op3).verdict == judge(trajectory, op3).verdict


def test_unknown_level(op3, standing):
    with pytest.raises(UnknownName, match="strict"):
        judge(standing(op3), op3, level="gentle")  # pyright: ignore[reportArgumentType]
