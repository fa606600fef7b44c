"""What a robot description holds, as values: attachments, soles, capsules, joint limits, standing pose, servos."""

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Final

import numpy as np

from ros_free_stack.messages import Floats, Mount
from ros_free_stack.robots.servos import ServoMap

LIMBS: Final = tuple(
    f"{side}_{name}" for side in ("left", "right") for name in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist")
)
"""Attachments of a whole body."""


@dataclass(frozen=True)
class Attachment:
    """A point fixed to a robot body: `offset` (3,) m in the body's frame."""

    body: str
    offset: tuple[float, float, float]


@dataclass(frozen=True)
class Sole:
    """The flat underside of a foot: `corners` (4, 3) m in the foot body's frame, and the human `ankle` above it."""

    body: str
    corners: tuple[tuple[float, float, float], ...]
    ankle: str


@dataclass(frozen=True)
class Capsule:
    """All points within `radius` of the segment from `start` to `end`, (3,) m each in a body's frame."""

    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float


@dataclass(frozen=True)
class JointLimits:
    """Limits of one joint: position range in rad, speed in rad/s, acceleration in rad/s^2, torque in N m.

    A slide has metres and newtons in their place.
    """

    lower: float
    upper: float
    velocity: float
    acceleration: float
    effort: float


@dataclass(frozen=True)
class RobotDescription:
    """One robot.

    Attributes:
        name: short name, as given to `--robot`.
        title: name for people.
        path: the description's own file.
        model_path: MJCF file.
        mount: `free` for a robot on its feet, `fixed` for one whose root is held (arms on a stand).
        root_body: the floating base; where the model fixes it to the world, the body that is fixed.
        torso_body: the body that carries the shoulders.
        torso_lean: share of the human torso's rotation against the pelvis that the torso body follows (1 for a
            robot with a waist, less for one whose torso and pelvis are one body).
        attachments: human joint name to the robot point that plays its part; limbs that the robot lacks are absent.
        soles: foot name to sole; none where the mount is fixed.
        capsules: body name to capsules that together cover the body's collision shapes.
        collision_pairs: pairs of bodies, each with capsules, that a motion must keep apart.
        joints: actuated joint name to limits, in the model's order.
        locked: joints of the model that are held at an angle in rad.
        limits_source: where limits that the model lacks come from.
        standing: joint positions in rad of a stable standing pose; joints not named are 0.
        servos: the Dynamixel bus, or None.
        sha256: hash of the model file and of this description; trajectories and verdicts carry it.
    """

    name: str
    title: str
    path: Path
    model_path: Path
    mount: Mount
    root_body: str
    torso_body: str
    torso_lean: float
    attachments: dict[str, Attachment]
    soles: dict[str, Sole]
    capsules: dict[str, tuple[Capsule, ...]]
    collision_pairs: tuple[tuple[str, str], ...]
    joints: dict[str, JointLimits]
    locked: dict[str, float]
    limits_source: str
    standing: dict[str, float]
    servos: ServoMap | None
    sha256: str

    @property
    def joint_names(self) -> tuple[str, ...]:
        """J actuated joints, in the model's order; the order of every joint array."""
        return tuple(self.joints)

    def mounted(self, mount: Mount) -> Mount:
        """The mount that applies where `mount` is asked for: a robot without legs to stand on never is free."""
        return "fixed" if self.mount == "fixed" else mount

    @property
    def has_all_limbs(self) -> bool:
        """Whether it can be laid on a human skeleton: one without arms or legs cannot."""
        return self.attachments.keys() >= set(LIMBS)

    @property
    def foot_names(self) -> tuple[str, ...]:
        return tuple(self.soles)

    @cached_property
    def lower(self) -> Floats:
        """(J,) lower joint limits, rad."""
        return np.array([limits.lower for limits in self.joints.values()])

    @cached_property
    def upper(self) -> Floats:
        """(J,) upper joint limits, rad."""
        return np.array([limits.upper for limits in self.joints.values()])

    @cached_property
    def velocity(self) -> Floats:
        """(J,) joint speed limits, rad/s."""
        return np.array([limits.velocity for limits in self.joints.values()])

    @cached_property
    def acceleration(self) -> Floats:
        """(J,) joint acceleration limits, rad/s^2."""
        return np.array([limits.acceleration for limits in self.joints.values()])

    @cached_property
    def effort(self) -> Floats:
        """(J,) joint torque limits, N m."""
        return np.array([limits.effort for limits in self.joints.values()])

    @cached_property
    def standing_pos(self) -> Floats:
        """(J,) standing pose, rad."""
        return np.array([self.standing.get(name, 0.0) for name in self.joints])
