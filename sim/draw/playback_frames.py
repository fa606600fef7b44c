"""What a video shows at each of its frames: poses, the human beside them, contacts, ZMP, joints at their limits."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ros_free_stack.messages import Bools, Floats, HumanMotion, RobotTrajectory
from ros_free_stack.robot_model import kinematic_model
from ros_free_stack.robots import RobotDescription
from sim.draw.synchrony import human_at, lead_in_s
from sim.judge.verdict import Judgement
from sim.judge.zmp import zero_moment_point
from sim.reference import in_robot_order, poses

AT_LIMIT = 0.01
"""A joint is at its limit within this of an end of its range (rad), or within this share of its speed limit."""


@dataclass(frozen=True)
class Film:
    """N frames of a robot's motion.

    Attributes:
        fps: frames a second.
        qpos: (N, nq) poses of a model with a free base.
        planned: (N, nq) what it should do where `qpos` is what it did in physics, or None.
        standing: (N, F) whether each foot should stand.
        force: (N, F) N with which the floor pressed on each foot in physics, or None where nothing was simulated.
        zmp: (N, 2) m, in physics where the floor's forces act (their centre of pressure), in a plan where they would
            have to; NaN in flight and for a robot without soles.
        at_limit: (N, J) whether each joint is at an end of its range, at its speed limit, or its servo out of torque.
        human: (N, 22, 3) m, or None.
        texts: N captions, the segment that is on; "" between segments.
        fell_at_s: when the robot fell in physics, or None.
        title: the robot's name, and whether it was simulated.
    """

    fps: float
    qpos: Floats
    planned: Floats | None
    standing: Bools
    force: Floats | None
    zmp: Floats
    at_limit: Bools
    human: Floats | None
    texts: tuple[str, ...]
    fell_at_s: float | None
    title: str

    def __len__(self) -> int:
        return len(self.qpos)


def make_film(
    trajectory: RobotTrajectory,
    robot: RobotDescription,
    model: mujoco.MjModel,
    *,
    fps: float,
    judgement: Judgement | None = None,
    motion: HumanMotion | None = None,
) -> Film:
    """A film of a trajectory, as simulated where the judgement has a playback of a free base, as planned otherwise.

    Args:
        trajectory: what the robot should do.
        robot: the robot.
        model: with the robot's joints and a free base; poses are its `qpos`.
        fps: frames a second of the film.
        judgement: the trajectory's judgement, or None; with one, the path that was judged is shown.
        motion: the human motion that it follows, or None.
    """
    trajectory = in_robot_order(trajectory if judgement is None else judgement.reference.trajectory, robot)
    planned = qpos = poses(trajectory, robot, model)
    joint_pos = trajectory.joint_pos
    joint_vel = np.gradient(joint_pos, axis=0) * trajectory.fps if len(joint_pos) > 1 else np.zeros_like(joint_pos)
    playback = None if judgement is None else judgement.playback
    if playback is not None and playback.qpos.shape[1] != model.nq:
        playback = None  # a robot on a stand: its plan looks the same
    out_of_torque = np.zeros_like(joint_pos, dtype=bool)
    if playback is not None:
        qpos, joint_pos, joint_vel = playback.qpos, playback.joint_pos, playback.joint_vel
        out_of_torque = playback.saturated > 0
    frames = np.rint(np.arange(0, len(qpos) - 0.5, trajectory.fps / fps)).astype(int).clip(0, len(qpos) - 1)
    times = frames / trajectory.fps
    if playback is not None:
        zmp = playback.pressure
    elif robot.soles:
        zmp = zero_moment_point(kinematic_model(robot), qpos, trajectory.fps)
    else:
        zmp = np.full((len(qpos), 2), np.nan)
    ends = (joint_pos < robot.lower + AT_LIMIT) | (joint_pos > robot.upper - AT_LIMIT)
    at_limit = ends | out_of_torque | (np.abs(joint_vel) > (1 - AT_LIMIT) * robot.velocity)
    return Film(
        fps=fps,
        qpos=qpos[frames],
        planned=None if playback is None else planned[frames],
        standing=trajectory.contacts[frames],
        force=None if playback is None else playback.contact_force[frames],
        zmp=zmp[frames],
        at_limit=at_limit[frames],
        human=None if motion is None else human_at(motion, trajectory, times),
        texts=_texts(motion, trajectory, times),
        fell_at_s=None if playback is None else playback.fell_at_s,
        title=f"{robot.title}, {'planned' if playback is None else 'simulated'}",
    )


def segment_at(motion: HumanMotion, time_s: float) -> str:
    """The text of the segment that is on at a time of the human motion, or ""."""
    return next((item.text for item in motion.segments if item.start_s <= time_s < item.end_s), "")


def _texts(motion: HumanMotion | None, trajectory: RobotTrajectory, times_s: Floats) -> tuple[str, ...]:
    if motion is None:
        return ("",) * len(times_s)
    lead = lead_in_s(motion, trajectory)
    return tuple(segment_at(motion, time - lead) for time in times_s)
