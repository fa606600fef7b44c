"""The path at the servos' rate: inside the bounds of its frames, from rest to rest, the same each time."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robots import load_robot
from ros_free_stack.servo_path import EASE_S, servo_path, smoothing_error

OP3, G1 = load_robot("op3"), load_robot("g1")
SERVOS = OP3.servos
assert SERVOS is not None
CYCLE_S = SERVOS.cycle_s


def trajectory(frames: np.ndarray, fps: float = 20.0, **changes: object) -> RobotTrajectory:
    count = len(frames)
    made = RobotTrajectory(
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
    return replace(made, **changes)  # pyright: ignore[reportArgumentType]


@settings(deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 60), st.sampled_from([20.0, 30.0, 50.0, 120.0, 400.0]))
def test_bounds_of_the_frames_hold_between_them(seed: int, count: int, fps: float) -> None:
    """Range and speed; and the acceleration of the frames, with that of the easing where there is one."""
    frames = 0.02 * np.random.default_rng(seed).uniform(-1, 1, (count, 2)).cumsum(0)
    path = servo_path(trajectory(frames, fps), OP3).joint_pos
    assert np.all(path <= frames.max(0) + 1e-12) and np.all(path >= frames.min(0) - 1e-12)
    assert np.allclose(path[0], frames[0]) and np.allclose(path[-1], frames[-1])
    speed = np.abs(np.diff(path, axis=0)).max(0, initial=0) / CYCLE_S
    assert np.all(speed <= np.abs(np.diff(frames, axis=0)).max(0, initial=0) * fps + 1e-9)


@pytest.mark.parametrize("fps", [20.0, 50.0, 125.0])
def test_a_motion_that_rests_at_its_ends_keeps_its_time(fps: float) -> None:
    times = np.arange(round(2 * fps) + 1) / fps
    frames = np.outer(0.25 * (1 - np.cos(np.pi * times)), [1.0, -1.0])
    path = servo_path(trajectory(frames, fps), OP3)
    assert path.fps == pytest.approx(1 / CYCLE_S)
    assert (len(path.joint_pos) - 1) * CYCLE_S == pytest.approx(2.0)
    expected = 0.25 * (1 - np.cos(np.pi * np.arange(251) * CYCLE_S))
    assert np.abs(path.joint_pos[:, 0] - expected).max() <= smoothing_error(trajectory(frames, fps)) + 1e-4


def test_a_motion_that_begins_and_ends_at_speed_still_starts_and_ends_at_rest() -> None:
    frames = np.column_stack([np.linspace(-0.5, 0.5, 41), np.zeros(41)])
    path = servo_path(trajectory(frames), OP3).joint_pos[:, 0]
    speed = np.diff(path) / CYCLE_S
    assert speed[0] < 0.01 and speed[-1] < 0.01 and np.all(speed >= -1e-9)
    assert speed.max() == pytest.approx(0.5, rel=1e-3)
    assert (len(path) - 1) * CYCLE_S == pytest.approx(2.0 + EASE_S, abs=CYCLE_S)


@pytest.mark.parametrize("reverse", [False, True])
def test_one_end_at_speed_is_enough_to_ease(reverse: bool) -> None:
    angles = 0.25 * np.linspace(0, 1, 41) ** 2
    frames = np.column_stack([angles[::-1] if reverse else angles, np.zeros(41)])
    path = servo_path(trajectory(frames), OP3).joint_pos[:, 0]
    speed = np.abs(np.diff(path)) / CYCLE_S
    assert speed[0] < 0.01 and speed[-1] < 0.01


def test_root_and_contacts_go_along() -> None:
    turn = np.linspace(0, 3.0, 41) + 2.0
    quaternions = Rotation.from_rotvec(np.outer(turn, [0, 0, 1])).as_quat(scalar_first=True)
    quaternions[::3] *= -1  # the same rotations
    given = trajectory(
        np.zeros((41, 2)),
        root_pos=np.outer(np.linspace(0, 1, 41), [1.0, 0.5, 0.0]),
        root_quat=quaternions,
        contacts=np.column_stack([np.arange(41) < 20, np.arange(41) >= 20]),
    )
    path = servo_path(given, OP3)
    share = path.root_pos[:, 0]
    assert np.all(np.diff(share) >= -1e-12) and np.allclose(path.root_pos[:, 1], share / 2)
    angles = np.unwrap(Rotation.from_quat(path.root_quat, scalar_first=True).as_euler("zyx")[:, 0])
    assert np.allclose(angles - angles[0], 3.0 * share, atol=2e-3)
    assert np.array_equal(path.contacts[:, 0], ~path.contacts[:, 1]) and path.contacts[0, 0] and path.contacts[-1, 1]


def test_the_path_is_the_same_each_time_and_sees_every_frame() -> None:
    frames = np.outer(0.1 * np.sin(np.linspace(0, 6, 40)), [1.0, -1.0])
    first = servo_path(trajectory(frames), OP3)
    assert first.digest == servo_path(trajectory(frames.copy()), OP3).digest
    changed = frames.copy()
    changed[20, 0] += 1e-6
    assert servo_path(trajectory(changed), OP3).digest != first.digest


def test_a_single_frame_is_a_path_of_one() -> None:
    path = servo_path(trajectory(np.array([[0.1, 0.2]])), OP3)
    assert np.allclose(path.joint_pos, [[0.1, 0.2]], atol=1e-15) and path.fps == pytest.approx(1 / CYCLE_S)


def test_a_robot_without_a_servo_bus_is_judged_as_it_is() -> None:
    given = replace(trajectory(np.zeros((5, 2))), joint_names=G1.joint_names[:2])
    assert servo_path(given, G1) is given


def test_smoothing_error_is_the_distance_of_the_frames_from_the_path() -> None:
    frames = np.zeros((51, 2))
    frames[25, 0] = 0.06
    path = servo_path(trajectory(frames, fps=25.0), OP3).joint_pos
    assert smoothing_error(trajectory(frames)) == pytest.approx(0.02)
    assert 0.06 - path[25 * 5, 0] == pytest.approx(0.02)
