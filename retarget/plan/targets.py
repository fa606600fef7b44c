"""Where the robot's points, bodies and feet should be: the human scaled limb by limb onto the robot."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d
from scipy.spatial.transform import Rotation

from retarget.body.geometry import Foot, RobotGeometry
from retarget.clip import human as hm
from retarget.clip.human import HumanClip, joint, unit, yaw_rotation
from retarget.plan.footsteps import (
    CLEARANCE_M,
    FootPath,
    clean_path,
    plan_contacts,
    prolong_double_support,
    spread_footholds,
)
from retarget.plan.pace import double_support_s
from retarget.plan.stride import LANDING_S, LONGEST_LEG
from retarget.plan.timeline import Timeline
from ros_free_stack.messages import Bools, Floats

TRACKING_ERROR_SHARE = 0.1
"""A limb farther from its target than this share of the robot's leg length has a tracking error worth telling."""
WIDEST_TOE_OUT = 0.35
SOLE_GAP = 0.8
"""Least room between soles side by side, in widths of a sole."""
TURNED_GAP = 0.5
"""Least room between a landing sole and a standing one, whichever way they point, in widths of a sole."""


@dataclass(frozen=True)
class Goal:
    """What the robot should do in one frame: one row of `Targets`, and a centre of mass (2,) m to follow, or None."""

    points: Floats
    rotations: Floats
    soles: Floats
    sole_rotations: Floats
    contacts: Bools
    following: float
    com: Floats | None = None


@dataclass(frozen=True)
class Targets:
    """What the robot should do, frame by frame, in its own size.

    Attributes:
        fps: frames a second.
        points: (N, P, 3) m, in the order of `RobotGeometry.followed`.
        rotations: (N, K, 3, 3) world orientations of the bodies of `RobotGeometry.frames`.
        soles: (N, F, 3) positions of the sole centres, m.
        sole_rotations: (N, F, 3, 3) world orientations of the feet's bodies.
        contacts: (N, F) whether each foot stands.
        following: (N,) 0 where the robot stands in its own pose, 1 where it follows the human.
        scale: robot size over human size (of the legs).
    """

    fps: float
    points: Floats
    rotations: Floats
    soles: Floats
    sole_rotations: Floats
    contacts: Bools
    following: Floats
    scale: float

    def __len__(self) -> int:
        return len(self.points)

    def goal(self, k: int, com: Floats | None = None) -> Goal:
        """Frame `k`, with row `k` of a centre of mass (N, 2)."""
        return Goal(
            self.points[k],
            self.rotations[k],
            self.soles[k],
            self.sole_rotations[k],
            self.contacts[k],
            float(self.following[k]),
            None if com is None else com[k],
        )

    def shifted(self, offsets: Floats) -> "Targets":
        """Everything but the feet moved by (N, 2) m over the floor."""
        points = self.points.copy()
        points[..., :2] += offsets[:, None]
        return replace(self, points=points)


def make_targets(clip: HumanClip, geometry: RobotGeometry, timeline: Timeline, stride: float) -> Targets:
    """Targets of a robot for a clip, from standing to standing; `stride` from `stride_share`."""
    joints, detected = clip.sample(timeline.human_s)
    scale = geometry.hip_height / clip.leg_length
    travel = np.array([*[stride * scale] * 2, scale])
    feet = _foot_paths(clip, geometry, timeline, joints, detected, travel)
    points, rotations = body_targets(clip, geometry, joints, travel)
    own_points, own_rotations = _standing(geometry, feet, timeline.weight)
    weight = timeline.weight
    points = own_points + weight[:, None, None] * (points - own_points)
    points = points - _beyond_reach(geometry, points, feet, timeline.fps)[:, None, None] * [0, 0, 1]
    rotations = _blend(own_rotations, rotations, weight)
    return Targets(
        fps=timeline.fps,
        points=points,
        rotations=np.stack(
            [rotations[:, k] @ reference for k, reference in enumerate(geometry.references.values())], axis=1
        ),
        soles=np.stack(
            [
                path.ankle + path.rotation @ (foot.reference @ (foot.centre - foot.ankle))
                for foot, path in zip(geometry.feet, feet, strict=True)
            ],
            axis=1,
        ),
        sole_rotations=np.stack(
            [path.rotation @ foot.reference for foot, path in zip(geometry.feet, feet, strict=True)], axis=1
        ),
        contacts=np.stack([path.contact for path in feet], axis=1),
        following=timeline.weight,
        scale=scale,
    )


def foot_targets(
    clip: HumanClip, geometry: RobotGeometry, joints: Floats, travel: Floats
) -> list[tuple[Floats, Floats, Floats]]:
    """The scaled human's feet, apart from each other: ankle (N, 3) m, yaw (N,) and pitch (N,) rad of each foot."""
    facing = hm.heading(joints)
    left = np.stack([-np.sin(facing), np.cos(facing), np.zeros_like(facing)], axis=1)
    wider = (geometry.length("left_hip", "right_hip") - clip.hip_width * travel[1]) / 2
    ankles: list[Floats] = []
    for foot in geometry.feet:
        ankle = joint(joints, f"{foot.side}_ankle") * travel
        ankle[:, 2] += geometry.ankle_height - clip.ankle_rest * travel[2]
        side = 1.0 if foot.side == "left" else -1.0
        ankles.append(ankle + side * wider * left)
    _keep_apart(geometry, ankles, facing)
    found: list[tuple[Floats, Floats, Floats]] = []
    for foot, ankle in zip(geometry.feet, ankles, strict=True):
        yaw, pitch = hm.foot_angles(joints, foot.side, clip.foot_pitch_rest)
        away = np.mod(yaw - facing + np.pi, 2 * np.pi) - np.pi
        # A foot that points down has no yaw: it fades to the body's heading.
        certain = np.clip(1.6 - np.abs(pitch) / 0.6, 0, 1)
        found.append((ankle, facing + certain * np.clip(away, -WIDEST_TOE_OUT, WIDEST_TOE_OUT), pitch))
    return found


def _foot_paths(
    clip: HumanClip,
    geometry: RobotGeometry,
    timeline: Timeline,
    joints: Floats,
    detected: Bools,
    travel: Floats,
) -> list[FootPath]:
    feet = foot_targets(clip, geometry, joints, travel)
    order = [hm.SIDES.index(foot.side) for foot in geometry.feet]
    heights = np.stack([ankle[:, 2] for ankle, _, _ in feet], axis=1)
    contacts = plan_contacts(detected[:, order], heights, timeline.hold, timeline.fps)
    contacts = prolong_double_support(contacts, timeline.fps, double_support_s(geometry.hip_height))
    paths = [FootPath(*foot, contacts[:, i]) for i, foot in enumerate(feet)]
    corners = [_corners_from_ankle(foot) for foot in geometry.feet]
    paths = spread_footholds(paths, corners, TURNED_GAP * float(np.ptp(corners[0][:, 1])))
    return [
        clean_path(
            path,
            ankle_height=geometry.ankle_height,
            clearance=CLEARANCE_M * travel[2],
            corners=soles,
            fps=timeline.fps,
        )
        for path, soles in zip(paths, corners, strict=True)
    ]


def _keep_apart(geometry: RobotGeometry, ankles: list[Floats], facing: Floats) -> None:
    """Move feet that are side by side outward until their soles have room, toes turned out included."""
    by_side = {foot.side: (foot, ankle) for foot, ankle in zip(geometry.feet, ankles, strict=True)}
    if set(by_side) != set(hm.SIDES):
        return
    (left_foot, left), (right_foot, right) = by_side["left"], by_side["right"]
    corners = _corners_from_ankle(left_foot)
    length, width = np.ptp(corners[:, 0]), np.ptp(corners[:, 1])
    gap = SOLE_GAP * width - corners[:, 1].min() + _corners_from_ankle(right_foot)[:, 1].max()
    forward = np.stack([np.cos(facing), np.sin(facing)], axis=1)
    outward = np.stack([-np.sin(facing), np.cos(facing)], axis=1)
    between = (left - right)[:, :2]
    beside = np.clip(2 - np.abs((between * forward).sum(axis=1)) / length, 0, 1)
    missing = beside * np.maximum(gap - (between * outward).sum(axis=1), 0) / 2
    left[:, :2] += missing[:, None] * outward
    right[:, :2] -= missing[:, None] * outward


def _beyond_reach(geometry: RobotGeometry, points: Floats, feet: list[FootPath], fps: float) -> Floats:
    """(N,) m by which the body must come down so that no standing or landing leg is stretched to its full length.

    A straight leg has no way to move its foot along itself, so its joints jump.
    """
    deficit = np.zeros(len(points))
    for i, path in enumerate(feet):
        needed = reach_deficit(geometry, points, i, path.ankle, path.rotation)
        near = maximum_filter1d(path.contact.astype(float), 2 * round(LANDING_S * fps) + 1)
        deficit = np.maximum(deficit, needed * near)
    width = round(LANDING_S * fps)
    return gaussian_filter1d(maximum_filter1d(deficit, 4 * width + 1), width)


def reach_deficit(geometry: RobotGeometry, points: Floats, i: int, ankle: Floats, rotation: Floats) -> Floats:
    """(N,) m by which the hip above foot `i`, with its `ankle` (N, 3) and `rotation` (N, 3, 3), is out of its reach."""
    foot, pelvis = geometry.feet[i], points[:, geometry.followed.index("pelvis")]
    hip = geometry.points[f"{foot.side}_hip"] - geometry.points["pelvis"]
    across = pelvis + hip[2] * np.array([0, 0, 1]) + rotation @ [0.0, hip[1], 0.0] - ankle
    length = LONGEST_LEG * geometry.length(f"{foot.side}_hip", f"{foot.side}_knee", f"{foot.side}_ankle")
    flat = np.minimum(np.linalg.norm(across[:, :2], axis=1), 0.8 * length)
    return np.maximum(across[:, 2] - np.sqrt(length**2 - flat**2), 0)


def _corners_from_ankle(foot: Foot) -> Floats:
    return (foot.corners - foot.ankle) @ foot.reference.T


def body_targets(clip: HumanClip, geometry: RobotGeometry, joints: Floats, travel: Floats) -> tuple[Floats, Floats]:
    """(N, P, 3) points and (N, K, 3, 3) rotations of the robot's own proportions in the human's pose.

    Rotations are against the standing pose. A head turns and bows as the human's.
    """
    robot, standing = geometry.robot, geometry.points
    pelvis_rotation, torso_rotation = hm.pelvis_rotation(joints), hm.torso_rotation(joints)
    share = np.full(len(joints), robot.torso_lean)
    torso_rotation = _blend(pelvis_rotation[:, None], torso_rotation[:, None], share)[:, 0]
    if "torso" not in geometry.frames:
        pelvis_rotation = torso_rotation
    hips = (joint(joints, "left_hip") + joint(joints, "right_hip")) / 2 * travel
    hips[:, 2] += geometry.ankle_height - clip.ankle_rest * travel[2]
    centre = (standing["left_hip"] + standing["right_hip"]) / 2
    points = {"pelvis": hips + pelvis_rotation @ (standing["pelvis"] - centre)}
    for side in hm.SIDES:
        hip = hips + pelvis_rotation @ (standing[f"{side}_hip"] - centre)
        points[f"{side}_knee"] = hip + _limb(geometry, joints, f"{side}_hip", f"{side}_knee")
        chain = [f"{side}_{name}" for name in ("shoulder", "elbow", "wrist") if f"{side}_{name}" in standing]
        if chain:
            points[chain[0]] = hips + torso_rotation @ (standing[chain[0]] - centre)
        for parent, child in pairwise(chain):
            points[child] = points[parent] + _limb(geometry, joints, parent, child)
    rotations = {"pelvis": pelvis_rotation, "torso": torso_rotation}
    if "head" in geometry.frames:
        rotations["head"] = hm.head_rotation(joints)
    return (
        np.stack([points[name] for name in geometry.followed], axis=1),
        np.stack([rotations[name] for name in geometry.frames], axis=1),
    )


def _limb(geometry: RobotGeometry, joints: Floats, parent: str, child: str) -> Floats:
    """The human limb's direction with the robot limb's length."""
    return unit(joint(joints, child) - joint(joints, parent)) * geometry.length(parent, child)


def _standing(geometry: RobotGeometry, feet: list[FootPath], weight: Floats) -> tuple[Floats, Floats]:
    """The robot's own standing pose between where its feet are: points (N, P, 3) and rotations (N, K, 3, 3).

    The feet are those of the nearer end of the motion; the peak of `weight` divides the two.
    """
    nearer = np.where(np.arange(len(weight)) <= np.argmax(weight), 0, -1)
    places = np.mean([path.ankle for path in feet], axis=0)[nearer]
    yaws = np.mean([path.yaw for path in feet], axis=0)[nearer]
    own = np.stack([geometry.points[name] for name in geometry.followed])
    origin = np.mean([geometry.points[f"{foot.side}_ankle"] for foot in geometry.feet], axis=0)
    turn = yaw_rotation(yaws)
    points = np.einsum("nij,pj->npi", turn, own - origin) + places[:, None]
    return points, np.repeat(turn[:, None], len(geometry.frames), axis=1)


def _blend(first: Floats, second: Floats, share: Floats) -> Floats:
    """Rotations (N, K, 3, 3) `share` (N,) of the way from `first` to `second`, along the shortest turn."""
    if np.all(share == 1):
        return second
    frames, count = second.shape[:2]
    a = Rotation.from_matrix(first.reshape(-1, 3, 3))
    b = Rotation.from_matrix(second.reshape(-1, 3, 3))
    step = (a.inv() * b).as_rotvec() * np.repeat(share, count)[:, None]
    return (a * Rotation.from_rotvec(step)).as_matrix().reshape(frames, count, 3, 3)
