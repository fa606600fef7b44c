"""This project's own files of human motion and of robot trajectories, as formats among the others."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import load_motion, load_trajectory, save_motion, save_trajectory
from ros_free_stack.formats.rates import FASTEST_FPS, SLOWEST_FPS
from ros_free_stack.formats.robot_floor import on_floor
from ros_free_stack.formats.robot_resample import part_of_trajectory
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.formats.span import frames_between
from ros_free_stack.messages import HumanMotion, RobotTrajectory, Segment


def read(path: Path, options: SourceOptions) -> Source:
    """This project's own file of either kind."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            kind = str(archive["kind"])
    except Exception:  # the reader of motions says what is wrong
        kind = "human_motion"
    if kind != "robot_trajectory":
        motion = load_motion(path)
        _check_rate(path, motion.fps)
        if options.floor:
            raise InvalidOption("--floor", "is for robot trajectories: human motion is put on the floor anyway")
        return Source(_part_of_motion(motion, frames_between(path, len(motion.joints), motion.fps, options)))
    trajectory = load_trajectory(path)
    _check_rate(path, trajectory.fps)
    span = frames_between(path, len(trajectory.joint_pos), trajectory.fps, options)
    trajectory = part_of_trajectory(trajectory, span)
    return Source(*on_floor(trajectory, lower=True)) if options.floor else Source(trajectory)


def write(path: Path, content: HumanMotion | RobotTrajectory) -> tuple[str, ...]:
    """This project's own file."""
    if isinstance(content, HumanMotion):
        save_motion(path, content)
    else:
        save_trajectory(path, content)
    return ()


def _check_rate(path: Path, fps: float) -> None:
    if not SLOWEST_FPS <= fps <= FASTEST_FPS:
        raise InvalidFile(path, f"states {fps:g} frames a second, expected {SLOWEST_FPS:g} to {FASTEST_FPS:g}")


def _part_of_motion(motion: HumanMotion, frames: slice) -> HumanMotion:
    """The given frames of a motion, with the segments that lie in them."""
    if frames == slice(0, len(motion.joints)):
        return motion
    start, end = frames.start / motion.fps, (frames.stop - 1) / motion.fps
    segments = tuple(
        Segment(item.text, max(item.start_s, start) - start, min(item.end_s, end) - start)
        for item in motion.segments
        if item.end_s > start and item.start_s < end
    )
    return replace(motion, joints=motion.joints[frames], segments=segments)
