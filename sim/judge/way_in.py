"""The way from where a robot's servos stand to the first pose of a path, which no verdict can know beforehand."""

import numpy as np

from ros_free_stack.errors import UnsafeCommand
from ros_free_stack.messages import Floats, RobotTrajectory
from ros_free_stack.robot_model import size_scale, standing_qpos
from ros_free_stack.robots import RobotDescription
from ros_free_stack.thresholds import load_thresholds
from sim.judge.checks.contact import self_collision
from sim.model import judging_model
from sim.reference import make_reference

EVERY = 3
"""Of so many goals on the way one is looked at: at the ramp's speed no joint moves by more than a degree or two."""


def check_way_in(robot: RobotDescription, joint_names: tuple[str, ...], goals: Floats) -> None:
    """UnsafeCommand where the robot would run into itself; nothing is known of the floor, since it hangs or is held.

    Args:
        robot: whose servos are about to move.
        joint_names: N names of the joints that move; the others are taken to stand.
        goals: (K, N) rad, from the measured pose to the first of the path.
    """
    model = judging_model(robot)
    limits = load_thresholds("default", scale=size_scale(robot, model))
    seen = np.unique(np.append(np.arange(0, len(goals), EVERY), len(goals) - 1))
    joint_pos = np.tile(robot.standing_pos, (len(seen), 1))
    joint_pos[:, [robot.joint_names.index(name) for name in joint_names]] = goals[seen]
    root = standing_qpos(model, robot)
    way = RobotTrajectory(
        robot=robot.name,
        model_sha256=robot.sha256,
        joint_names=robot.joint_names,
        fps=1.0,
        root_pos=np.tile(root[:3], (len(seen), 1)),
        root_quat=np.tile(root[3:7], (len(seen), 1)),
        joint_pos=joint_pos,
        contacts=np.zeros((len(seen), len(robot.foot_names)), dtype=bool),
        foot_names=robot.foot_names,
    )
    check = self_collision(make_reference(way, robot, model), limits["self_collision"])
    if not check.passed:
        raise UnsafeCommand(
            f"on the way from where the servos stand to the first pose {check.worst_item} would run into each other by "
            f"{1000 * check.value:.0f} mm: move the limbs by hand to where the motion begins"
        )
