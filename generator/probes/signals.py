"""What probes look at: signals of a motion over time, from joint positions alone.

Lengths are relative to the person: hands in arm lengths in the frame of the chest, the pelvis relative to standing,
feet in leg lengths. Angles are in degrees, positive forward (pitch) and to the left (yaw, roll).
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d

from ros_free_stack.skeleton import FPS, INDEX

Floats = NDArray[np.float64]
SIDES: Final = ("left", "right")
SIGN: Final = {"left": 1.0, "right": -1.0}
REST: Final = np.array([0.08, 0.12, -0.95])
"""Where a hanging hand is: forward, outward and up from its shoulder, in arm lengths."""
_SMOOTHING = 0.7  # frames


@dataclass(frozen=True)
class Hand:
    """One hand over T frames.

    Attributes:
        place: (T, 3) from the shoulder, forward, outward and up along the chest, in arm lengths.
        lift: (T,) height over the shoulder, in arm lengths.
        away: (T,) distance from where it hangs, in arm lengths.
        speed: (T,) in the frame of the chest, arm lengths a second.
        to_head: (T,) distance to the head, in arm lengths.
        to_hip: (T,) distance to the hip of the same side, in arm lengths.
        to_chest: (T,) distance to the upper chest, in arm lengths.
        across: (T,) distance to the elbow of the other arm, in arm lengths.
        floor: (T,) height over the floor, in arm lengths.
    """

    place: Floats
    lift: Floats
    away: Floats
    speed: Floats
    to_head: Floats
    to_hip: Floats
    to_chest: Floats
    across: Floats
    floor: Floats

    @property
    def extension(self) -> Floats:
        """(T,) distance from the shoulder; 1 is a straight arm."""
        return np.linalg.norm(self.place, axis=-1)


@dataclass(frozen=True)
class Foot:
    """One foot over T frames.

    Attributes:
        place: (T, 3) ankle from its hip, forward, outward and up in the frame of the pelvis' heading, leg lengths.
        toe, heel: (T,) heights of ball and ankle over where they are when standing, leg lengths.
        knee: (T,) bend of the knee, deg.
        knee_height: (T,) over the floor, leg lengths.
        thigh: (T,) angle of the thigh forward from hanging, deg.
        speed: (T,) of the ankle, leg lengths a second.
        ground: (T, 2) place on the floor, m.
    """

    place: Floats
    toe: Floats
    heel: Floats
    knee: Floats
    knee_height: Floats
    thigh: Floats
    speed: Floats
    ground: Floats


@dataclass(frozen=True)
class Signals:
    """All signals of one motion of T frames.

    Attributes:
        hands, feet: by side.
        root: (T, 2) pelvis on the floor, m.
        heading: (T,) of the hips, deg, unwrapped.
        pelvis: (T,) height of the pelvis, 1 when standing.
        pitch, roll: (T,) of the trunk from the vertical: forward, to the left.
        twist: (T,) of the shoulders against the hips.
        head_pitch, head_yaw: (T,) of the head against the chest, from the place of the head over the neck.
        shoulders: (T,) height of both shoulders against the neck, in arm lengths.
        gap: (T,) between the hands, in arm lengths.
        stance: (T,) sideways distance of the feet, in leg lengths.
    """

    hands: dict[str, Hand]
    feet: dict[str, Foot]
    root: Floats
    heading: Floats
    pelvis: Floats
    pitch: Floats
    roll: Floats
    twist: Floats
    head_pitch: Floats
    head_yaw: Floats
    shoulders: Floats
    gap: Floats
    stance: Floats

    def __len__(self) -> int:
        return len(self.pelvis)

    @classmethod
    def of(cls, joints: ArrayLike) -> "Signals":
        """The signals of joints (T, 22, 3) in m at 20 fps, z up."""
        return _Body(np.asarray(joints, dtype=np.float64)).signals()


class _Body:
    """The joints of one motion with their frames and lengths."""

    def __init__(self, joints: Floats) -> None:
        self.joints = gaussian_filter1d(joints, _SMOOTHING, axis=0) if len(joints) > 1 else joints
        self.arm = np.mean([self._bone(f"{s}_shoulder", f"{s}_elbow", f"{s}_wrist") for s in SIDES])
        self.leg = np.mean([self._bone(f"{s}_hip", f"{s}_knee", f"{s}_ankle") for s in SIDES])
        self.floor = float(np.percentile(joints[:, [INDEX["left_foot"], INDEX["right_foot"]], 2], 2))
        self.ankle = self._ankle_height()
        across = self.at("left_hip") - self.at("right_hip")
        self.heading = _heading(across)
        self.forward = np.stack([np.cos(self.heading), np.sin(self.heading), np.zeros_like(self.heading)], -1)
        self.left = np.stack([-np.sin(self.heading), np.cos(self.heading), np.zeros_like(self.heading)], -1)
        self.chest = self._chest()

    def at(self, name: str) -> Floats:
        return self.joints[:, INDEX[name]]

    def _bone(self, *names: str) -> float:
        places = [self.joints[:, INDEX[name]] for name in names]
        return float(sum(np.linalg.norm(b - a, axis=-1).mean() for a, b in pairwise(places)))

    def _ankle_height(self) -> float:
        """Of a flat foot: the lowest that the ankles get while the toes are down."""
        return float(np.percentile(self.joints[:, [INDEX["left_ankle"], INDEX["right_ankle"]], 2], 5)) - self.floor

    def _chest(self) -> Floats:
        """(T, 3, 3) rows forward, left and up of the chest."""
        up = _unit(self.at("neck") - self.at("spine1"))
        left = self.at("left_shoulder") - self.at("right_shoulder")
        left = _unit(left - np.sum(left * up, -1, keepdims=True) * up)
        return np.stack([np.cross(left, up), left, up], axis=1)

    def in_chest(self, vectors: Floats) -> Floats:
        return np.einsum("tij,tj->ti", self.chest, vectors)

    def signals(self) -> Signals:
        trunk = _unit(self.at("neck") - self.at("pelvis"))
        head = self.in_chest(self.at("head") - self.at("neck"))
        chest_yaw = _heading(self.at("left_shoulder") - self.at("right_shoulder"))
        shoulders = [self.in_chest(self.at(f"{s}_shoulder") - self.at("neck"))[:, 2] for s in SIDES]
        feet = self.at("left_ankle") - self.at("right_ankle")
        hip = float(np.mean(np.abs(self.at("left_hip")[:, 2] - self.at("pelvis")[:, 2])))
        return Signals(
            hands={side: self.hand(side) for side in SIDES},
            feet={side: self.foot(side) for side in SIDES},
            root=self.at("pelvis")[:, :2],
            heading=np.degrees(self.heading),
            pelvis=(self.at("pelvis")[:, 2] - self.floor) / (self.leg + hip + self.ankle),
            pitch=np.degrees(np.arctan2(_dot(trunk, self.forward), trunk[:, 2])),
            roll=np.degrees(np.arctan2(_dot(trunk, self.left), trunk[:, 2])),
            twist=np.degrees(np.angle(np.exp(1j * (chest_yaw - self.heading)))),
            head_pitch=np.degrees(np.arctan2(head[:, 0], head[:, 2])),
            head_yaw=np.degrees(np.arctan2(head[:, 1], np.linalg.norm(head, axis=-1))),
            shoulders=np.mean(shoulders, axis=0) / self.arm,
            gap=np.linalg.norm(self.at("left_wrist") - self.at("right_wrist"), axis=-1) / self.arm,
            stance=_dot(feet, self.left) / self.leg,
        )

    def hand(self, side: str) -> Hand:
        wrist, shoulder = self.at(f"{side}_wrist"), self.at(f"{side}_shoulder")
        other = "right" if side == "left" else "left"
        place = self.in_chest(wrist - shoulder) * [1, SIGN[side], 1] / self.arm

        def distance(joint: str) -> Floats:
            return np.linalg.norm(wrist - self.at(joint), axis=-1) / self.arm

        return Hand(
            place=place,
            lift=(wrist - shoulder)[:, 2] / self.arm,
            away=np.linalg.norm(place - REST, axis=-1),
            speed=_speed(place),
            to_head=distance("head"),
            to_hip=distance(f"{side}_hip"),
            to_chest=distance("spine3"),
            across=distance(f"{other}_elbow"),
            floor=(wrist[:, 2] - self.floor) / self.arm,
        )

    def foot(self, side: str) -> Foot:
        hip, knee, ankle = (self.at(f"{side}_{joint}") for joint in ("hip", "knee", "ankle"))
        thigh, shank, whole = knee - hip, ankle - knee, ankle - hip
        place = np.stack([_dot(whole, self.forward), SIGN[side] * _dot(whole, self.left), whole[:, 2]], -1)
        cosine = np.sum(_unit(thigh) * _unit(shank), -1)
        return Foot(
            place=place / self.leg,
            toe=(self.at(f"{side}_foot")[:, 2] - self.floor) / self.leg,
            heel=(ankle[:, 2] - self.floor - self.ankle) / self.leg,
            knee=np.degrees(np.arccos(np.clip(cosine, -1, 1))),
            knee_height=(knee[:, 2] - self.floor) / self.leg,
            thigh=np.degrees(np.arctan2(_dot(thigh, self.forward), -thigh[:, 2])),
            speed=_speed(ankle) / self.leg,
            ground=ankle[:, :2],
        )


def _dot(a: Floats, b: Floats) -> Floats:
    return np.sum(a * b, axis=-1)


def _unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)


def _heading(across: Floats) -> Floats:
    """(T,) angle in rad that a line from right to left faces, unwrapped."""
    return np.unwrap(np.arctan2(-across[:, 0], across[:, 1]))


def _speed(places: Floats) -> Floats:
    """(T,) per second."""
    if len(places) < 2:
        return np.zeros(len(places))
    return np.linalg.norm(np.gradient(places, axis=0), axis=-1) * FPS
