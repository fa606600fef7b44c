"""What is judged is what servos do between the frames, and on the way to the first."""

import numpy as np
import pytest

from ros_free_stack.errors import UnsafeCommand
from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robots import RobotDescription
from ros_free_stack.servo_path import servo_path
from ros_free_stack.thresholds import load_thresholds
from sim.judge.checks.contact import self_collision
from sim.judge.verdict import judge
from sim.judge.way_in import check_way_in
from sim.model import judging_model
from sim.playback.physics import set_stage
from sim.reference import make_reference


def arm_poses(robot: RobotDescription, standing, seed: int) -> RobotTrajectory:
    """Six poses of both arms, half a second apart, from the stance."""
    rng = np.random.default_rng(seed)
    joints: dict[str, np.ndarray] = {}
    for name in (name for name in robot.joint_names if "sho" in name or name.endswith("_el")):
        limits, angles = robot.joints[name], [robot.standing.get(name, 0.0)]
        for _ in range(5):
            further = angles[-1] + rng.uniform(-1.4, 1.4)
            angles.append(np.clip(further, max(limits.lower, -2.4), min(limits.upper, 2.4)))
        joints[name] = np.array(angles)
    return standing(robot, frames=6, fps=2.0, joints=joints)


@pytest.mark.parametrize("seed", [1210, 673, 442, 238])
def test_frames_that_are_clear_with_a_path_that_is_not_are_refused(op3, standing, seed):
    trajectory = arm_poses(op3, standing, seed)
    limit = load_thresholds("default", scale=1.0)["self_collision"]
    assert self_collision(make_reference(trajectory, op3, judging_model(op3)), limit).passed
    verdict = judge(trajectory, op3, physics=False).verdict
    assert {check.name for check in verdict.failures} >= {"self_collision"}


def test_playback_plays_the_frames_of_the_path(op3, standing):
    path = servo_path(arm_poses(op3, standing, 3), op3)
    plan = set_stage(make_reference(path, op3, judging_model(op3)), mount="fixed").plan
    first = round(plan.hold_s / plan.cycle_s)
    assert np.abs(plan.joint_pos[first : first + len(path.joint_pos)] - path.joint_pos).max() < 1e-9


def test_verdict_names_the_path(op3, standing):
    trajectory = arm_poses(op3, standing, 3)
    judgement = judge(trajectory, op3, physics=False)
    assert judgement.verdict.trajectory_digest == trajectory.digest
    assert judgement.verdict.path_digest == judgement.reference.trajectory.digest == servo_path(trajectory, op3).digest


def test_the_way_to_the_first_pose_is_refused_where_it_collides(op3):
    names = ("l_hip_roll", "r_hip_roll")
    stance = np.array([op3.standing.get(name, 0.0) for name in names])
    check_way_in(op3, names, np.linspace(stance - 0.05, stance, 20))
    crossed = np.array([0.35, -0.35])
    with pytest.raises(UnsafeCommand, match=r"on the way .* run into each other by .* mm"):
        check_way_in(op3, names, np.linspace(crossed, stance, 20))
