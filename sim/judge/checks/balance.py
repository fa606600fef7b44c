"""Check of the balance that the reference's own dynamics ask for, before any simulation."""

import numpy as np
from scipy.ndimage import uniform_filter1d

from ros_free_stack.messages import Check, Floats
from ros_free_stack.thresholds import Threshold
from sim.judge.zmp import zero_moment_point
from sim.reference import Reference

WINDOW_S = 0.2
"""A zero moment point that is outside for less is one that a robot may survive: its ankles catch up."""

_DIRECTIONS = 64


def zmp_outside(reference: Reference, threshold: Threshold) -> Check:
    """Greatest mean over 0.2 s of the distance in m of the zero moment point from the standing soles; 0 inside.

    The zero moment point (Vukobratovic and Borovac 2004, "Zero-moment point: thirty five years of its life") is where
    the floor's force must act for the motion to be possible; the floor can only push where the soles' convex hull is.
    Frames without a standing foot do not count: there is no floor force to place.
    """
    outside = np.maximum(zmp_distance(reference), 0.0)
    width = max(1, round(WINDOW_S / reference.dt))
    mean = uniform_filter1d(outside, width, mode="nearest")
    return threshold.check(
        "zmp_outside",
        mean.max(),
        "How far beyond its soles the robot would have to push the floor in order not to tip over.",
        worst_frame=int(np.argmax(mean)) if mean.max() > 0 else -1,
    )


def zmp_distance(reference: Reference) -> Floats:
    """(T,) signed distance in m from the soles' hull, negative inside; 0 where no foot stands or the motion flies.

    The distance is measured in 64 directions, which makes it at most 0.2 % too short.
    """
    zmp = zero_moment_point(reference.model, reference.qpos, reference.trajectory.fps)
    contacts = reference.trajectory.contacts
    angles = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    reach = np.full((len(zmp), _DIRECTIONS), -np.inf)
    for foot, stands in zip(reference.robot.foot_names, contacts.T, strict=True):
        extent = (reference.soles[foot][..., :2] @ directions.T).max(axis=1)
        reach = np.where(stands[:, None], np.maximum(reach, extent), reach)
    counted = contacts.any(axis=1) & np.isfinite(zmp[:, 0])
    distance = (np.nan_to_num(zmp) @ directions.T - np.where(counted[:, None], reach, 0.0)).max(axis=1)
    return np.where(counted, distance, 0.0)
