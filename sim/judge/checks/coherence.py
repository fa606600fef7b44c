"""Checks of the coordination between body parts, on the robot's pose laid on a human skeleton."""

import numpy as np

from ros_free_stack import coherence
from ros_free_stack.messages import Check, Floats
from ros_free_stack.skeleton import FPS
from ros_free_stack.thresholds import Threshold
from sim.judge.humanoid import human_joints
from sim.reference import Reference

STILL_LEGS_PER_S = 0.1
"""Parts whose speed varies by less than this many leg lengths a second count as still."""


def temporal_coherence(reference: Reference, threshold: Threshold) -> Check:
    """Temporal coherence (ParTY S1 to S6) at 20 fps, over pairs of parts that both move; 1 where none do."""
    joints = at_20_fps(human_joints(reference), reference.trajectory.fps)
    return threshold.check(
        "temporal_coherence",
        coherence.temporal_coherence(joints, still=STILL_LEGS_PER_S),
        "How well arms, legs and trunk keep time with each other (captured people: 0.2 to 0.7).",
    )


def spatial_coherence(reference: Reference, threshold: Threshold) -> Check:
    """Spatial coherence (ParTY S7 to S10), mean over frames."""
    scores = coherence.spatial_coherence_by_frame(human_joints(reference))
    return threshold.check(
        "spatial_coherence",
        scores.mean(),
        "How natural the places of arms, legs and trunk to each other are (captured people: 0.5 to 0.9).",
        worst_frame=int(np.argmin(scores)),
    )


def at_20_fps(joints: Floats, fps: float) -> Floats:
    """Positions (T, 22, 3) resampled linearly to the rate for which the equations' parameters hold."""
    times = np.arange(len(joints)) / fps
    wanted = np.arange(0.0, times[-1] + 1e-9, 1.0 / FPS)
    flat = joints.reshape(len(joints), -1)
    columns = [np.interp(wanted, times, column) for column in flat.T]
    return np.stack(columns, axis=1).reshape(len(wanted), *joints.shape[1:])
