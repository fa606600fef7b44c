"""Goals are the frames of the path, held to the limits of the rig; the ramp that leads there keeps to them too."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw.goals import goals_of, ramp
from hw.rig import Rig
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robots import load_robot
from ros_free_stack.servo_path import servo_path

OP3 = load_robot("op3")
RIG = Rig.of_robot(OP3, only=("head_pan", "r_el"))


def trajectory(frames: np.ndarray, fps: float = 20.0) -> RobotTrajectory:
    count = len(frames)
    return RobotTrajectory(
        robot="op3",
        model_sha256=OP3.sha256,
        joint_names=("r_el", "head_pan"),
        fps=fps,
        root_pos=np.zeros((count, 3)),
        root_quat=np.tile([1.0, 0, 0, 0], (count, 1)),
        joint_pos=frames,
        contacts=np.ones((count, 2), dtype=bool),
        foot_names=("left", "right"),
    )


def goals(frames: np.ndarray, rig: Rig = RIG) -> np.ndarray:
    return goals_of(servo_path(trajectory(frames), OP3), rig)


def test_joints_are_matched_by_name() -> None:
    frames = np.tile([0.3, -0.1], (10, 1))
    assert np.allclose(goals(frames), [-0.1, 0.3])


@pytest.mark.parametrize(
    ("frames", "words"),
    [
        (np.tile([9.0, 0.0], (10, 1)), "r_el .* range"),
        (np.tile([-9.0, 0.0], (10, 1)), "r_el .* range"),
        (np.column_stack([np.linspace(0, 1.5, 6), np.zeros(6)]), "r_el .* speed"),
        (np.column_stack([np.linspace(0, -1.5, 6), np.zeros(6)]), "r_el .* speed"),
        (np.column_stack([np.tile([0.0, 0.15], 10), np.zeros(20)]), "r_el .* acceleration"),
    ],
)
def test_a_broken_limit_is_named_not_clipped(frames: np.ndarray, words: str) -> None:
    with pytest.raises(UnsafeCommand, match=words):
        goals(frames)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("share", "passes"), [(0.99, True), (1.02, False)])
def test_the_speed_limit_holds_to_the_percent(sign: int, share: float, passes: bool) -> None:
    step = sign * share * RIG.velocity[1] / 20.0
    frames = np.column_stack([np.arange(6) * step, np.zeros(6)])
    frames[:, 0] -= frames[:, 0].mean()
    rig = replace(RIG, lower=RIG.lower - 2, upper=RIG.upper + 2, acceleration=RIG.acceleration * 10)
    if passes:
        goals(frames, rig)
    else:
        with pytest.raises(UnsafeCommand, match=r"r_el .* speed"):
            goals(frames, rig)


@pytest.mark.parametrize(("share", "passes"), [(1.05, True), (0.95, False)])
def test_easing_into_a_motion_at_speed_is_held_to_the_acceleration_limit(share: float, passes: bool) -> None:
    """A straight line has no acceleration of its own; its start and end have: at most 3/2 of the speed over 0.3 s."""
    speed = 0.5
    frames = np.column_stack([np.linspace(-0.5, 0.5, 41), np.zeros(41)])
    rig = replace(RIG, acceleration=np.full(2, share * 1.5 * speed / 0.3))
    if passes:
        goals(frames, rig)
    else:
        with pytest.raises(UnsafeCommand, match=r"r_el .* acceleration 2.50"):
            goals(frames, rig)


def test_a_path_on_another_cycle_is_refused() -> None:
    with pytest.raises(ModelMismatch, match="20 frames a second, the servos 125 cycles"):
        goals_of(trajectory(np.zeros((5, 2))), RIG)


@pytest.mark.parametrize("reverse", [False, True])
def test_a_path_that_is_not_at_rest_at_an_end_is_refused(reverse: bool) -> None:
    angles = 0.25 * np.linspace(0, 1, 60) ** 2
    frames = np.column_stack([angles if reverse else angles[::-1], np.zeros(60)])
    with pytest.raises(UnsafeCommand, match=r"r_el .* acceleration"):
        goals_of(trajectory(frames, fps=1 / RIG.cycle_s), RIG)


def test_goals_are_the_frames_of_the_path_to_the_bit() -> None:
    path = servo_path(trajectory(0.1 * np.sin(np.linspace(0, 6, 40))[:, None] * [1, -1]), OP3)
    assert np.array_equal(goals_of(path, RIG), path.joint_pos[:, ::-1])


def test_a_missing_joint_is_named() -> None:
    with pytest.raises(ModelMismatch, match="l_knee"):
        goals(np.zeros((5, 2)), Rig.of_robot(OP3, only=("l_knee",)))


@settings(deadline=None)
@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0.2, 3))
def test_ramp_is_never_faster_than_told(start: float, end: float, speed: float) -> None:
    path = ramp(np.array([start]), np.array([end]), speed=speed, acceleration=np.array([45.0]), cycle_s=0.008)
    whole = np.concatenate([[start], path[:, 0]])
    assert path[-1, 0] == pytest.approx(end)
    assert np.abs(np.diff(whole)).max() <= speed * 0.008 * 1.001


@pytest.mark.parametrize("distance", [0.01, 0.1, 1.0])
def test_ramp_keeps_to_the_acceleration_of_every_joint(distance: float) -> None:
    limit = np.array([45.0, 5.0])
    path = ramp(np.zeros(2), np.array([distance, -distance]), speed=4.0, acceleration=limit, cycle_s=0.001)
    still = np.zeros((2, 2))
    change = np.diff(np.concatenate([still, path, path[-1:]]), 2, axis=0) / 0.001**2
    assert np.all(np.abs(change).max(axis=0) <= 1.01 * limit)
