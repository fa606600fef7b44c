"""Checks of contact in the reference itself: with the own body, with the floor, and of feet that should stand."""

import numpy as np

from ros_free_stack.messages import Check, Floats
from ros_free_stack.thresholds import Threshold
from sim.reference import Reference

LOW_SOLE_M = 0.05
"""A sole lower than this counts as near the floor (for a robot of G1's height)."""


def self_collision(reference: Reference, threshold: Threshold) -> Check:
    """Greatest depth in m by which two of the robot's bodies overlap, between their convex collision shapes.

    Neighbours in the kinematic tree and pairs that overlap in the standing pose do not count: there the shapes,
    not the robot, are at fault.
    """
    depth, frame, pair = max(
        ((value, frame, pair) for frame, pairs in enumerate(reference.pair_depth) for pair, value in pairs.items()),
        default=(0.0, -1, ("", "")),
    )
    return threshold.check(
        "self_collision",
        depth,
        "The deepest that two parts of the robot's body run into each other.",
        worst_frame=frame,
        worst_item=" and ".join(pair) if frame >= 0 else "",
    )


def ground_penetration(reference: Reference, threshold: Threshold) -> Check:
    """Greatest depth in m of any sole corner or collision shape below the floor z = 0."""
    model = reference.model
    bodies = np.zeros((len(reference.qpos), model.nbody))
    for geom, body in enumerate(model.geom_bodyid):
        bodies[:, body] = np.maximum(bodies[:, body], reference.floor_depth[:, geom])
    for foot, sole in reference.robot.soles.items():
        body = model.body(sole.body).id
        bodies[:, body] = np.maximum(bodies[:, body], -reference.soles[foot][..., 2].min(axis=1))
    frame, body = (int(i) for i in np.unravel_index(int(np.argmax(bodies)), bodies.shape))
    sunk = bodies[frame, body] > 0
    return threshold.check(
        "ground_penetration",
        bodies[frame, body],
        "The deepest that any part of the robot goes below the floor.",
        worst_frame=frame if sunk else -1,
        worst_item=model.body(body).name if sunk else "",
    )


def floating(reference: Reference, threshold: Threshold) -> Check:
    """Greatest height in m above the floor z = 0 of a sole that is meant to stand, or of a robot that hovers.

    A reference that floats falls by that much as soon as physics begins (the "float" of PhysDiff, Yuan et al. 2023).
    Contact flags say which foot should stand; `hovering` asks none of them.
    """
    feet = reference.robot.foot_names
    lowest = np.stack([reference.soles[foot][..., 2].min(axis=1) for foot in feet], axis=1)
    heights = np.where(reference.trajectory.contacts, np.maximum(lowest, 0.0), 0.0)
    heights = np.column_stack([heights, hovering(reference, lowest.min(axis=1), threshold.limit)])
    frame, item = (int(i) for i in np.unravel_index(int(np.argmax(heights)), heights.shape))
    above = heights[frame, item] > 0
    return threshold.check(
        "floating",
        heights[frame, item],
        "How far a foot that should stand, or a robot that stays up for longer than a jump, is above the floor.",
        worst_frame=frame if above else -1,
        worst_item=(*feet, reference.robot.root_body)[item] if above else "",
    )


def hovering(reference: Reference, clearance: Floats, tolerance: float) -> Floats:
    """(T,) m by which the robot is too high for a body in flight; 0 where it touches the floor.

    From the first frame a in which it flies to the last one b the centre of mass is g (t - a) (b - t) / 2 above the
    line between its heights then. What it lacks of that would bring it down earlier, by no more than its feet are above
    the floor. At either end of the trajectory the robot is at rest, so it cannot be in flight there.

    Args:
        reference: the trajectory's kinematics.
        clearance: (T,) m, height of the lowest sole.
        tolerance: m, up to which soles count as on the floor.
    """
    touching = (clearance <= tolerance) | (reference.floor_depth > 0).any(axis=1)
    height, gravity = _centre_height(reference), -float(reference.model.opt.gravity[2])
    found = np.zeros(len(clearance))
    edges = np.flatnonzero(np.diff(np.concatenate([[True], touching, [True]]).astype(int)))
    for start, end in edges.reshape(-1, 2):
        flight = slice(start, end)
        if start == 0 or end == len(clearance):
            found[flight] = clearance[flight]
            continue
        since, length = np.arange(end - start), max(end - start - 1, 1)
        line = height[start] + (height[end - 1] - height[start]) * since / length
        arc = line + gravity / 2 * reference.dt**2 * since * (length - since)
        found[flight] = np.clip(arc - height[flight], 0.0, clearance[flight])
    return found


def _centre_height(reference: Reference) -> Floats:
    """(T,) m, height of the centre of mass."""
    model = reference.model
    heights = reference.body_pos[:, :, 2] + np.einsum("tbj,bj->tb", reference.body_rot[:, :, 2], model.body_ipos)
    return heights @ model.body_mass / model.body_mass.sum()


def foot_skate(reference: Reference, threshold: Threshold) -> Check:
    """Mean horizontal speed in m/s of soles while they are meant to stand (contact flag in both frames)."""
    speeds, planted = sole_speeds(reference), planted_intervals(reference)
    frame, foot = _fastest(reference, speeds, planted)
    return threshold.check(
        "foot_skate",
        speeds[planted].mean() if planted.any() else 0.0,
        "How fast feet slide on average while they should stand still.",
        worst_frame=frame,
        worst_item=foot,
    )


def foot_skate_peak(reference: Reference, threshold: Threshold, *, scale: float) -> Check:
    """Highest horizontal speed in m/s of a sole that is near the floor (5 cm on G1) and meant to stand."""
    heights = np.stack([reference.soles[f][..., 2].min(axis=1) for f in reference.robot.foot_names], axis=1)
    low = heights < LOW_SOLE_M * scale
    speeds, planted = sole_speeds(reference), planted_intervals(reference) & low[1:] & low[:-1]
    frame, foot = _fastest(reference, speeds, planted)
    return threshold.check(
        "foot_skate_peak",
        speeds[planted].max() if planted.any() else 0.0,
        "The fastest slide of a foot that should stand still.",
        worst_frame=frame,
        worst_item=foot,
    )


def planted_intervals(reference: Reference) -> np.ndarray:
    """(T-1, F) whether a foot is meant to stand at both ends of each interval between frames."""
    contacts = reference.trajectory.contacts
    return contacts[1:] & contacts[:-1]


def sole_speeds(reference: Reference) -> Floats:
    """(T-1, F) horizontal speed of each sole's lowest corners, m/s.

    A foot that rolls over its heel or toe turns about corners that stand still, so only corners within 5 mm of the
    lowest count.
    """
    speeds: list[Floats] = []
    for foot in reference.robot.foot_names:
        corners = reference.soles[foot]
        moved = np.linalg.norm(np.diff(corners[..., :2], axis=0), axis=-1) / reference.dt
        height = np.minimum(corners[1:, :, 2], corners[:-1, :, 2])
        touching = height <= height.min(axis=1, keepdims=True) + 0.005
        speeds.append((moved * touching).sum(axis=1) / touching.sum(axis=1))
    return np.stack(speeds, axis=1)


def _fastest(reference: Reference, speeds: Floats, planted: np.ndarray) -> tuple[int, str]:
    """Frame and name of the planted foot that slides fastest; (-1, "") where none is planted."""
    if not planted.any():
        return -1, ""
    slid = np.where(planted, speeds, -1.0)
    frame, foot = np.unravel_index(int(np.argmax(slid)), slid.shape)
    return int(frame), reference.robot.foot_names[int(foot)]
