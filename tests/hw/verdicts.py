"""A motion of one elbow and the verdict of a judge who found nothing, for tests of what comes behind the gate."""

import numpy as np

from hw.gate import DRIVEN
from ros_free_stack.criteria import limits_of, required_checks
from ros_free_stack.messages import Level, Mount, RobotTrajectory, Verdict
from ros_free_stack.robots import RobotDescription, load_robot
from ros_free_stack.servo_path import servo_path
from ros_free_stack.thresholds import limits_sha256


def motion(robot: RobotDescription, *, seconds: float = 2.0, fps: float = 50.0) -> RobotTrajectory:
    """The right elbow swings by 0.6 rad, four times in 2 s at most."""
    times = np.arange(round(seconds * fps)) / fps
    joints = np.tile(robot.standing_pos, (len(times), 1))
    moved = robot.joint_names.index("r_el" if "r_el" in robot.joint_names else robot.joint_names[0])
    joints[:, moved] -= 0.3 * (1 - np.cos(2 * np.pi * times))
    return RobotTrajectory(
        robot=robot.name,
        model_sha256=robot.sha256,
        joint_names=robot.joint_names,
        fps=fps,
        root_pos=np.zeros((len(times), 3)),
        root_quat=np.tile([1.0, 0, 0, 0], (len(times), 1)),
        joint_pos=joints,
        contacts=np.ones((len(times), 2), dtype=bool),
        foot_names=robot.foot_names,
    )


def judged(trajectory: RobotTrajectory, *, mount: Mount = "free", level: Level = "default") -> Verdict:
    """A passing verdict with every check at its limit."""
    robot = load_robot(trajectory.robot)
    mount = robot.mounted(mount)
    limits = limits_of(robot, level)
    return Verdict(
        robot=robot.name,
        model_sha256=robot.sha256,
        trajectory_digest=trajectory.digest,
        checks=tuple(limits[name].check(name, limits[name].limit, "") for name in required_checks(robot, mount)),
        physics=True,
        mount=mount,
        controller=DRIVEN,
        level=level,
        limits_sha256=limits_sha256(limits),
        path_digest=servo_path(trajectory, robot).digest,
    )
