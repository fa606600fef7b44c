"""Trajectories of known character, made from the robots' standing poses."""

from collections.abc import Callable

import numpy as np
import pytest

from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robot_model import kinematic_model, standing_qpos
from ros_free_stack.robots import RobotDescription, load_robot

StandingMaker = Callable[..., RobotTrajectory]


@pytest.fixture(scope="session")
def op3() -> RobotDescription:
    return load_robot("op3")


@pytest.fixture(scope="session")
def g1() -> RobotDescription:
    return load_robot("g1")


@pytest.fixture(scope="session")
def standing() -> StandingMaker:
    """A maker of trajectories that stand still except where told: offsets broadcast over (T, ...) frames."""
    poses: dict[str, np.ndarray] = {}

    def make(
        robot: RobotDescription,
        *,
        frames: int = 50,
        fps: float = 50.0,
        root_offset: object = 0.0,
        joints: dict[str, np.ndarray] | None = None,
        contacts: bool = True,
    ) -> RobotTrajectory:
        if robot.name not in poses:
            poses[robot.name] = standing_qpos(kinematic_model(robot), robot)
        root = poses[robot.name]
        joint_pos = np.tile(robot.standing_pos, (frames, 1))
        for name, values in (joints or {}).items():
            joint_pos[:, robot.joint_names.index(name)] = values
        return RobotTrajectory(
            robot=robot.name,
            model_sha256=robot.sha256,
            joint_names=robot.joint_names,
            fps=fps,
            root_pos=np.tile(root[:3], (frames, 1)) + np.asarray(root_offset),
            root_quat=np.tile(root[3:7], (frames, 1)),
            joint_pos=joint_pos,
            contacts=np.full((frames, len(robot.foot_names)), contacts),
            foot_names=robot.foot_names,
        )

    return make
