"""Frames a second of the video renderer for each robot, by the wall and by the processor time of this process alone.

    python benchmarks/rendering.py
    taskset -c 1 python benchmarks/rendering.py --robots op3 g1

"alone" is the robot at 640x480, "beside" the robot next to the human at 800x480; a video adds x264 in a process of its
own. Where other processes share the core, processor time says what an idle one would do.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from time import perf_counter, process_time

import mujoco
import numpy as np
import tyro

from ros_free_stack.console import print_table, progress
from ros_free_stack.messages import HumanMotion, RobotTrajectory
from ros_free_stack.robot_model import kinematic_model, standing_qpos
from ros_free_stack.robots import RobotDescription, load_robot, robot_names
from ros_free_stack.skeleton import JOINT_COUNT
from sim.draw.appearance import visual_model
from sim.draw.playback_frames import make_film
from sim.draw.render import FPS, draw_film

WARM_UP = 3


@dataclass(frozen=True)
class Arguments:
    """Draw a swaying robot and count frames."""

    robots: tuple[str, ...] = ()
    """Robots by name; all without."""
    frames: int = 100
    """Frames to draw of each."""


def swaying(robot: RobotDescription, frames: int) -> RobotTrajectory:
    """Every joint swings a quarter of its range about the standing pose."""
    root = standing_qpos(kinematic_model(robot), robot)
    swing = 0.25 * np.minimum(robot.upper - robot.standing_pos, robot.standing_pos - robot.lower)
    phase = np.sin(np.arange(frames) / FPS * 2 * np.pi)[:, None]
    return RobotTrajectory(
        robot=robot.name,
        model_sha256=robot.sha256,
        joint_names=robot.joint_names,
        fps=FPS,
        root_pos=np.tile(root[:3], (frames, 1)),
        root_quat=np.tile(root[3:7], (frames, 1)),
        joint_pos=robot.standing_pos + phase * swing,
        contacts=np.ones((frames, len(robot.foot_names)), bool),
        foot_names=robot.foot_names,
    )


def rates(images: Iterator[np.ndarray]) -> tuple[float, float]:
    """Frames a second by the wall and by processor time, after a warm-up."""
    list(islice(images, WARM_UP))
    wall, processor = perf_counter(), process_time()
    count = sum(1 for _ in images)
    return count / (perf_counter() - wall), count / (process_time() - processor)


def row(name: str, frames: int) -> list[str]:
    """One robot's line of the table."""
    robot = load_robot(name)
    model: mujoco.MjModel = visual_model(robot)
    trajectory = swaying(robot, frames)
    person = np.random.default_rng(0).uniform(0, 1.7, (JOINT_COUNT, 3)) * [0.3, 0.3, 1]
    motion = HumanMotion(np.tile(person, (frames, 1, 1)), FPS)
    alone = rates(draw_film(make_film(trajectory, robot, model, fps=FPS), model, robot))
    beside = rates(draw_film(make_film(trajectory, robot, model, fps=FPS, motion=motion), model, robot))
    return [name, str(int(model.nmeshface)), *(f"{rate:.0f}" for rate in (*alone, *beside))]


def main(arguments: Arguments) -> None:
    """Print the table."""
    names = arguments.robots or robot_names()
    rows = [row(name, arguments.frames) for name in progress(names, "drawing")]
    heads = ("robot", "faces", "alone, wall", "alone, processor", "beside, wall", "beside, processor")
    print_table(heads, rows)


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
