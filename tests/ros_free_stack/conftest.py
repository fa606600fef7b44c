"""A person of 1.7 m whose joints turn at random but smoothly, and trajectories of robots."""

from collections.abc import Callable

import numpy as np
import pytest

from ros_free_stack.formats.frames import from_y_up, stand
from ros_free_stack.formats.smpl import posed_joints
from ros_free_stack.messages import Floats, HumanMotion, RobotTrajectory
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import JOINT_NAMES

MIDDLE = {
    "pelvis": (0.0, 0.94, 0.0),
    "spine1": (0.0, 1.055, -0.02),
    "spine2": (0.0, 1.185, -0.015),
    "spine3": (0.0, 1.25, -0.005),
    "neck": (0.0, 1.455, -0.02),
    "head": (0.0, 1.555, 0.0),
}
LEFT = {
    "hip": (0.085, 0.865, 0.0),
    "knee": (0.085, 0.47, 0.02),
    "ankle": (0.085, 0.075, -0.02),
    "foot": (0.085, 0.02, 0.11),
    "collar": (0.075, 1.365, -0.015),
    "shoulder": (0.18, 1.40, -0.02),
    "elbow": (0.43, 1.39, -0.03),
    "wrist": (0.67, 1.39, -0.02),
}


@pytest.fixture(scope="session")
def rest() -> Floats:
    """(22, 3) T-pose, y up and z forward, as SMPL has it."""
    places = MIDDLE | {f"left_{name}": place for name, place in LEFT.items()}
    places |= {f"right_{name}": (-x, y, z) for name, (x, y, z) in LEFT.items()}
    return np.array([places[name] for name in JOINT_NAMES])


@pytest.fixture(scope="session")
def person(rest: Floats) -> Callable[..., HumanMotion]:
    """Make a motion: rigid bones, all joints turning, walking along a line."""

    def make(frames: int = 20, *, fps: float = 20.0, seed: int = 0, size: float = 0.4) -> HumanMotion:
        rng = np.random.default_rng(seed)
        phase = np.arange(frames)[:, None, None] / 20 * 2 * np.pi * rng.uniform(0.2, 0.8, (22, 3))
        turns = size * rng.uniform(-1, 1, (22, 3)) * np.sin(phase + rng.uniform(0, 6, (22, 3)))
        turns[:, 0] *= 0.3
        along = np.linspace(0, 1, frames)[:, None] * (0.1, 0.0, 0.8)
        joints = stand(from_y_up(posed_joints(rest, turns, along)))
        return HumanMotion(joints, fps, source="test")

    return make


@pytest.fixture(scope="session")
def trajectory() -> Callable[..., RobotTrajectory]:
    """Make a trajectory of a robot: every joint a sine inside its range, the root moving and turning."""

    def make(name: str = "op3", frames: int = 31, fps: float = 30.0) -> RobotTrajectory:
        robot = load_robot(name)
        rng = np.random.default_rng(7)
        time = np.arange(frames)[:, None] / fps
        middle, reach = (robot.lower + robot.upper) / 2, 0.3 * (robot.upper - robot.lower)
        axis = np.array([0.2, -0.3, 0.9]) / np.linalg.norm([0.2, -0.3, 0.9])
        half = 0.6 * time
        return RobotTrajectory(
            robot=name,
            model_sha256=robot.sha256,
            joint_names=robot.joint_names,
            fps=fps,
            root_pos=np.concatenate([0.3 * time, 0.1 * np.sin(time), 0.4 + 0.05 * np.cos(time)], axis=1),
            root_quat=np.concatenate([np.cos(half), np.sin(half) * axis], axis=1),
            joint_pos=middle + reach * np.sin(time * rng.uniform(1, 3, len(middle)) + rng.uniform(0, 6, len(middle))),
            contacts=np.zeros((frames, len(robot.foot_names)), dtype=bool),
            foot_names=robot.foot_names,
        )

    return make


@pytest.fixture
def before(trajectory) -> RobotTrajectory:
    return trajectory("g1", frames=31, fps=50.0)
