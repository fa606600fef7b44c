"""Where the robot's points, bodies and feet should be: the human scaled limb by limb onto the robot."""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from retarget import human as hm
from retarget.footsteps import CLEARANCE_M, FootPath, clean_path, plan_contacts
from retarget.geometry import Foot, RobotGeometry
from retarget.human import HumanClip, joint, unit, yaw_rotation
from retarget.timeline import Timeline
from ros_free_stack.messages import Bools, Floats

WIDEST_TOE_OUT = 1.0


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

    def shifted(self, offsets: Floats) -> "Targets":
        """Everything but the feet moved by (N, 2) m over the floor."""
        points = self.points.copy()
        points[..., :2] += offsets[:, None]
        return replace(self, points=points)


def make_targets(clip: HumanClip, geometry: RobotGeometry, timeline: Timeline) -> Targets:
    """Targets of a robot for a clip, from standing to standing."""
    joints, detected = clip.sample(timeline.human_s)
    scale = geometry.hip_height / clip.leg_length
    feet = _foot_paths(clip, geometry, timeline, joints, detected, scale)
    points, rotations = _body(clip, geometry, joints, scale)
    own_points, own_rotations = _standing(geometry, feet, timeline.weight)
    weight = timeline.weight
    points = own_points + weight[:, None, None] * (points - own_points)
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


def _foot_paths(
    clip: HumanClip,
    geometry: RobotGeometry,
    timeline: Timeline,
    joints: Floats,
    detected: Bools,
    scale: float,
) -> list[FootPath]:
    facing = hm.heading(joints)
    left = np.stack([-np.sin(facing), np.cos(facing), np.zeros_like(facing)], axis=1)
    wider = (geometry.length("left_hip", "right_hip") - clip.hip_width * scale) / 2
    ankles: list[Floats] = []
    for foot in geometry.feet:
        ankle = joint(joints, f"{foot.side}_ankle") * scale
        ankle[:, 2] += geometry.ankle_height - clip.ankle_rest * scale
        side = 1.0 if foot.side == "left" else -1.0
        ankles.append(ankle + side * wider * left)
    order = [hm.SIDES.index(foot.side) for foot in geometry.feet]
    heights = np.stack([ankle[:, 2] for ankle in ankles], axis=1)
    contacts = plan_contacts(detected[:, order], heights, timeline.hold, timeline.fps)
    paths: list[FootPath] = []
    for i, foot in enumerate(geometry.feet):
        yaw, pitch = hm.foot_angles(joints, foot.side, clip.foot_pitch_rest)
        away = np.mod(yaw - facing + np.pi, 2 * np.pi) - np.pi
        yaw = facing + np.clip(away, -WIDEST_TOE_OUT, WIDEST_TOE_OUT)
        path = FootPath(ankles[i], yaw, pitch, contacts[:, i])
        paths.append(
            clean_path(
                path,
                ankle_height=geometry.ankle_height,
                clearance=CLEARANCE_M * scale,
                corners=_corners_from_ankle(foot),
            )
        )
    return paths


def _corners_from_ankle(foot: Foot) -> Floats:
    return (foot.corners - foot.ankle) @ foot.reference.T


def _body(clip: HumanClip, geometry: RobotGeometry, joints: Floats, scale: float) -> tuple[Floats, Floats]:
    """(N, P, 3) points and (N, K, 3, 3) rotations of the robot's own proportions in the human's pose."""
    robot, standing = geometry.robot, geometry.points
    pelvis_rotation, torso_rotation = hm.pelvis_rotation(joints), hm.torso_rotation(joints)
    share = np.full(len(joints), robot.torso_lean)
    torso_rotation = _blend(pelvis_rotation[:, None], torso_rotation[:, None], share)[:, 0]
    if "torso" not in geometry.frames:
        pelvis_rotation = torso_rotation
    hips = (joint(joints, "left_hip") + joint(joints, "right_hip")) / 2 * scale
    hips[:, 2] += geometry.ankle_height - clip.ankle_rest * scale
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
    frames, count = second.shape[:2]
    a = Rotation.from_matrix(first.reshape(-1, 3, 3))
    b = Rotation.from_matrix(second.reshape(-1, 3, 3))
    step = (a.inv() * b).as_rotvec() * np.repeat(share, count)[:, None]
    return (a * Rotation.from_rotvec(step)).as_matrix().reshape(frames, count, 3, 3)
