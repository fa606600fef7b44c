"""Arm poses that are clear while the way between them is not: does the judge refuse them all?

python benchmarks/between_frames.py              # 100 such trajectories of OP3
"""

from itertools import count

import numpy as np
import tyro

from ros_free_stack.console import progress
from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robot_model import kinematic_model, standing_qpos
from ros_free_stack.robots import RobotDescription, load_robot
from ros_free_stack.servo_path import servo_path
from ros_free_stack.thresholds import load_thresholds
from sim.judge.checks.contact import self_collision
from sim.judge.verdict import judge
from sim.model import judging_model
from sim.reference import make_reference

POSES = 6
FPS = 2.0
LARGEST_STEP = 1.4


def arm_poses(robot: RobotDescription, root: np.ndarray, seed: int) -> RobotTrajectory:
    """Six random poses of both arms, half a second apart, from the stance."""
    rng = np.random.default_rng(seed)
    joint_pos = np.tile(robot.standing_pos, (POSES, 1))
    for joint, name in enumerate(robot.joint_names):
        if "sho" in name or name.endswith("_el"):
            for k in range(1, POSES):
                further = joint_pos[k - 1, joint] + rng.uniform(-LARGEST_STEP, LARGEST_STEP)
                joint_pos[k, joint] = np.clip(further, robot.joints[name].lower, robot.joints[name].upper)
    return RobotTrajectory(
        robot=robot.name,
        model_sha256=robot.sha256,
        joint_names=robot.joint_names,
        fps=FPS,
        root_pos=np.tile(root[:3], (POSES, 1)),
        root_quat=np.tile(root[3:7], (POSES, 1)),
        joint_pos=joint_pos,
        contacts=np.ones((POSES, len(robot.foot_names)), dtype=bool),
        foot_names=robot.foot_names,
    )


def main(wanted: int = 100) -> None:
    """Count verdicts on trajectories whose frames pass and whose path collides.

    Args:
        wanted: how many such trajectories.
    """
    robot = load_robot("op3")
    model, limit = judging_model(robot), load_thresholds("default", scale=1.0)["self_collision"]
    root = standing_qpos(kinematic_model(robot), robot)
    seeds, clear, refused, depths = count(), 0, 0, list[float]()
    for _ in progress(range(wanted), "colliding paths"):
        while True:
            trajectory = arm_poses(robot, root, next(seeds))
            if not self_collision(make_reference(trajectory, robot, model), limit).passed:
                continue
            clear += 1
            path = self_collision(make_reference(servo_path(trajectory, robot), robot, model), limit)
            if not path.passed:
                break
        depths.append(path.value)
        refused += not judge(trajectory, robot, physics=False).passed
    least, middle, most = (1e3 * float(np.quantile(depths, share)) for share in (0.0, 0.5, 1.0))
    print(f"{clear} trajectories with clear frames; {wanted} of them collide between frames:")
    print(f"by {least:.0f} to {most:.0f} mm, median {middle:.0f}; {refused} of {wanted} refused")


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
