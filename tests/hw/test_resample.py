"""Goals on the servo cycle stay inside the bounds of the frames."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hw.resample import ramp, resample
from hw.rig import Rig
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robots import load_robot

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


@settings(deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 60), st.sampled_from([20.0, 30.0, 50.0, 120.0]))
def test_bounds_of_the_frames_hold_between_them(seed: int, count: int, fps: float) -> None:
    walk = np.random.default_rng(seed).uniform(-1, 1, (count, 2)).cumsum(0)
    frames = 0.02 * (20 / fps) ** 2 * walk / max(1.0, np.abs(walk).max())
    goals = resample(trajectory(frames, fps), RIG).angles[:, ::-1]
    assert np.all(goals <= frames.max(0) + 1e-12) and np.all(goals >= frames.min(0) - 1e-12)
    assert np.allclose(goals[0], frames[0]) and np.allclose(goals[-1], frames[-1])
    speed = np.abs(np.diff(goals, axis=0)).max(0) / RIG.cycle_s if len(goals) > 1 else np.zeros(2)
    assert np.all(speed <= np.abs(np.diff(frames, axis=0)).max(0, initial=0) * fps + 1e-9)


def test_duration_is_kept_but_for_the_two_ends() -> None:
    goals = resample(trajectory(np.zeros((41, 2))), RIG)
    assert len(goals.angles) * RIG.cycle_s == pytest.approx(2.3, abs=0.02)
    assert goals.deviation == 0


def test_a_motion_that_begins_and_ends_at_speed_still_starts_and_ends_at_rest() -> None:
    frames = np.column_stack([np.linspace(-0.5, 0.5, 41), np.zeros(41)])
    moving = resample(trajectory(frames), RIG).angles[:, 1]
    speed = np.diff(moving) / RIG.cycle_s
    assert speed[0] < 0.01 and speed[-1] < 0.01
    assert speed.max() == pytest.approx(0.5, rel=1e-3)
    assert np.all(speed >= -1e-9)


def test_joints_are_matched_by_name() -> None:
    frames = np.tile([0.3, -0.1], (10, 1))
    assert np.allclose(resample(trajectory(frames), RIG).angles, [-0.1, 0.3])


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
        resample(trajectory(frames), RIG)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("share", "passes"), [(0.99, True), (1.02, False)])
def test_the_speed_limit_holds_to_the_percent(sign: int, share: float, passes: bool) -> None:
    step = sign * share * RIG.velocity[1] / 20.0
    frames = np.column_stack([np.arange(6) * step, np.zeros(6)])
    frames[:, 0] -= frames[:, 0].mean()
    rig = replace(RIG, lower=RIG.lower - 2, upper=RIG.upper + 2, acceleration=RIG.acceleration * 10)
    if passes:
        resample(trajectory(frames), rig)
    else:
        with pytest.raises(UnsafeCommand, match=r"r_el .* speed"):
            resample(trajectory(frames), rig)


@pytest.mark.parametrize(("share", "passes"), [(1.05, True), (0.95, False)])
def test_easing_into_a_motion_at_speed_is_held_to_the_acceleration_limit(share: float, passes: bool) -> None:
    """A straight line has no acceleration of its own; its start and end have: at most 3/2 of the speed over 0.3 s."""
    speed = 0.5
    frames = np.column_stack([np.linspace(-0.5, 0.5, 41), np.zeros(41)])
    rig = replace(RIG, acceleration=np.full(2, share * 1.5 * speed / 0.3))
    if passes:
        resample(trajectory(frames), rig)
    else:
        with pytest.raises(UnsafeCommand, match=r"r_el .* acceleration 2.50"):
            resample(trajectory(frames), rig)


def test_a_missing_joint_is_named() -> None:
    with pytest.raises(ModelMismatch, match="l_knee"):
        resample(trajectory(np.zeros((5, 2))), Rig.of_robot(OP3, only=("l_knee",)))


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
