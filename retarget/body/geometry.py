"""What the retargeter needs to know of a robot's body, measured once on its standing pose."""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import mujoco
import numpy as np

from ros_free_stack.errors import UnsupportedModel
from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import joint_addresses, kinematic_model, standing_qpos
from ros_free_stack.robots import RobotDescription

POINTS = (
    "pelvis",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
    "left_knee",
    "right_knee",
)
"""Human joints whose positions a robot follows where its description attaches them.

Feet are followed as frames. Shoulders follow from the pelvis and the torso, and on some robots wander as an arm turns.
"""

LIMBS = tuple(
    tuple(f"{side}_{joint}" for joint in joints)
    for joints in (("hip", "knee", "ankle"), ("shoulder", "elbow", "wrist"))
    for side in ("left", "right")
)
"""Chains of human joints; a robot must have at least one."""


@dataclass(frozen=True)
class Foot:
    """A foot: its body, sole corners (4, 3) and ankle (3,) in the body's frame, and the body's standing orientation."""

    name: str
    side: str
    body: int
    corners: Floats
    ankle: Floats
    reference: Floats

    @property
    def centre(self) -> Floats:
        """(3,) middle of the sole in the body's frame."""
        return self.corners.mean(axis=0)


@dataclass(frozen=True)
class RobotGeometry:
    """A robot standing upright at the origin, facing x.

    Attributes:
        robot: the description.
        model: compiled model without meshes.
        qpos_index, dof_index: (J,) where the description's joints are in `qpos` and in tangent vectors.
        standing: (nq,) the standing pose.
        bodies: body id of each followed point, keyed by human joint.
        offsets: (3,) of each followed point in its body's frame.
        points: (3,) world position of every attachment in the standing pose.
        frames: body id of the bodies whose orientation is followed: "pelvis", "torso" where it is another body, and
            "head" where it is attached.
        references: (3, 3) standing orientation of each of `frames`.
        feet: the feet, in the description's order.
    """

    robot: RobotDescription
    model: mujoco.MjModel
    qpos_index: np.ndarray
    dof_index: np.ndarray
    standing: Floats
    bodies: dict[str, int]
    offsets: dict[str, Floats]
    points: dict[str, Floats]
    frames: dict[str, int]
    references: dict[str, Floats]
    feet: tuple[Foot, ...]

    @property
    def held(self) -> bool:
        """Whether the root never moves: the robot is mounted by it."""
        return self.robot.mount == "fixed"

    @property
    def followed(self) -> tuple[str, ...]:
        """Human joints whose positions are followed, in the order of every point array."""
        return tuple(self.bodies)

    @cached_property
    def ankle_height(self) -> float:
        """Height of the ankles above the floor in the standing pose, m; 0 without feet."""
        return float(np.mean([self.points[f"{foot.side}_ankle"][2] for foot in self.feet])) if self.feet else 0.0

    @cached_property
    def hip_height(self) -> float:
        """Height of the hips above the ankles in the standing pose, m; the length by which legs are scaled."""
        hips = np.mean([self.points[f"{side}_hip"][2] for side in ("left", "right")])
        return float(hips) - self.ankle_height

    @cached_property
    def limb_length(self) -> float:
        """Length of a leg, or of an arm where the robot has no legs, m: what weights and thresholds are scaled by."""
        return self.length(*next(limb for limb in LIMBS if self.points.keys() >= set(limb)))

    def length(self, *chain: str) -> float:
        """Sum of the distances along attachments, m."""
        return sum(math.dist(self.points[a], self.points[b]) for a, b in pairwise(chain))


def measure(robot: RobotDescription) -> RobotGeometry:
    """Compile the robot's model and measure it.

    Raises:
        InvalidFile: the model is damaged, or lacks what the description names.
        UnsupportedModel: an attachment that retargeting needs is missing.
    """
    _require_attachments(robot)
    model = kinematic_model(robot)
    data = mujoco.MjData(model)
    standing = standing_qpos(model, robot)
    data.qpos[:] = standing
    mujoco.mj_kinematics(model, data)
    qpos_index, dof_index = joint_addresses(model, robot)
    pelvis = robot.attachments["pelvis"].body
    frames = {"pelvis": model.body(pelvis).id}
    if robot.torso_body != pelvis:
        frames["torso"] = model.body(robot.torso_body).id
    if "head" in robot.attachments:
        frames["head"] = model.body(robot.attachments["head"].body).id
    followed = [joint for joint in POINTS if joint in robot.attachments]
    return RobotGeometry(
        robot=robot,
        model=model,
        qpos_index=qpos_index,
        dof_index=dof_index,
        standing=standing,
        bodies={joint: model.body(robot.attachments[joint].body).id for joint in followed},
        offsets={joint: np.array(robot.attachments[joint].offset) for joint in followed},
        points={joint: _world_point(data, robot, joint) for joint in robot.attachments},
        frames=frames,
        references={name: _rotation(data, body) for name, body in frames.items()},
        feet=tuple(_foot(model, data, robot, name) for name in robot.foot_names),
    )


def _require_attachments(robot: RobotDescription) -> None:
    legs = (f"{side}_{joint}" for side in ("left", "right") for joint in ("hip", "knee", "ankle"))
    needed = {"pelvis", *legs} if robot.mount == "free" else {"pelvis"}
    missing = sorted(needed - robot.attachments.keys())
    if missing:
        raise UnsupportedModel(f"robot {robot.name}: its description attaches no {', '.join(missing)}")
    if robot.mount == "free" and not robot.soles:
        raise UnsupportedModel(f"robot {robot.name}: it has no soles to stand on; valid: soles, or mount: fixed")
    if not any(robot.attachments.keys() >= set(limb) for limb in LIMBS):
        limbs = "; ".join(", ".join(limb) for limb in LIMBS)
        raise UnsupportedModel(f"robot {robot.name}: its description attaches no whole limb; valid: {limbs}")


def _rotation(data: mujoco.MjData, body: int) -> Floats:
    return data.xmat[body].reshape(3, 3).copy()


def _world_point(data: mujoco.MjData, robot: RobotDescription, joint: str) -> Floats:
    attachment = robot.attachments[joint]
    body = data.body(attachment.body)
    return body.xpos + body.xmat.reshape(3, 3) @ np.array(attachment.offset)


def _foot(model: mujoco.MjModel, data: mujoco.MjData, robot: RobotDescription, name: str) -> Foot:
    sole = robot.soles[name]
    body = model.body(sole.body).id
    rotation = _rotation(data, body)
    return Foot(
        name=name,
        side=sole.ankle.removesuffix("_ankle"),
        body=body,
        corners=np.array(sole.corners),
        ankle=rotation.T @ (_world_point(data, robot, sole.ankle) - data.xpos[body]),
        reference=rotation,
    )
