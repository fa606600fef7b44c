"""The human side: a clip aligned to floor and heading, sampled at any time, with body frames and foot contacts."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import binary_closing, binary_opening

from retarget.clip.floor import put_on_level_floor
from ros_free_stack.messages import Bools, Floats, HumanMotion
from ros_free_stack.skeleton import INDEX

SIDES = ("left", "right")

PELVIS_REST_TILT = -0.105
TORSO_REST_TILT = -0.025
"""Forward lean, in rad, of the lines from hips to spine1 and from spine1 to neck of an upright person (SMPL's rest)."""

HEAD_REST_TILT = 0.25
"""Forward lean of the line from neck to head of a person who looks straight ahead."""

SHORTEST_CONTACT_S = 0.08
TOUCH_M = 0.02
"""Height above its rest below which a toe or an ankle touches the floor, still or not."""


@dataclass(frozen=True)
class ContactThresholds:
    """When a foot stands: toe and ankle heights above their own rest heights (m) and toe speed (m/s), (start, end)."""

    toe_height: tuple[float, float] = (0.035, 0.06)
    ankle_height: tuple[float, float] = (0.05, 0.10)
    speed: tuple[float, float] = (0.25, 0.5)

    def stands(self, toe: Floats, ankle: Floats, speed: Floats) -> tuple[Bools, Bools]:
        """(T,) whether a foot may begin to stand, and whether one that stands still does."""
        low, high = (
            (toe < self.toe_height[k]) & (ankle < self.ankle_height[k]) & (speed < self.speed[k]) for k in range(2)
        )
        return low, high


def unit(vectors: Floats) -> Floats:
    """Vectors of length 1 along the last axis; zero stays zero."""
    length = np.sqrt(np.einsum("...i,...i->...", vectors, vectors))
    return vectors / np.maximum(length, 1e-9)[..., None]


def yaw_rotation(angles: Floats) -> Floats:
    """(..., 3, 3) rotations about z."""
    angles = np.asarray(angles, dtype=float)
    rotation = np.zeros((*angles.shape, 3, 3))
    rotation[..., 0, 0] = rotation[..., 1, 1] = np.cos(angles)
    rotation[..., 1, 0], rotation[..., 0, 1] = np.sin(angles), -np.sin(angles)
    rotation[..., 2, 2] = 1.0
    return rotation


def pitch_rotation(angles: Floats) -> Floats:
    """(..., 3, 3) rotations about y; positive leans forward."""
    angles = np.asarray(angles, dtype=float)
    rotation = np.zeros((*angles.shape, 3, 3))
    rotation[..., 0, 0] = rotation[..., 2, 2] = np.cos(angles)
    rotation[..., 0, 2], rotation[..., 2, 0] = np.sin(angles), -np.sin(angles)
    rotation[..., 1, 1] = 1.0
    return rotation


@dataclass(frozen=True)
class HumanClip:
    """An aligned clip on its own frames.

    Attributes:
        joints: (T, 22, 3) m; the floor at z = 0, at the first frame the hips above the origin and facing x.
        fps: frames a second.
        ankle_rest: height of a standing ankle above the floor, m.
        foot_pitch_rest: pitch of the line from ankle to toe of a flat foot, rad.
        contacts: (T, 2) whether the left and the right foot stand.
    """

    joints: Floats
    fps: float
    ankle_rest: float
    foot_pitch_rest: float
    contacts: Bools

    @property
    def duration_s(self) -> float:
        return (len(self.joints) - 1) / self.fps

    @property
    def leg_length(self) -> float:
        """Thigh and shin, mean of the sides and frames, m."""
        return self.length("left_hip", "left_knee", "left_ankle")

    @property
    def hip_width(self) -> float:
        """Mean distance between the hip joints, m."""
        across = joint(self.joints, "left_hip") - joint(self.joints, "right_hip")
        return float(np.linalg.norm(across, axis=1).mean())

    def length(self, *chain: str) -> float:
        """Mean length of a chain of left-side joints and of its mirror image, m."""
        chains = (chain, tuple(name.replace("left", "right") for name in chain))
        bones = [
            np.linalg.norm(joint(self.joints, b) - joint(self.joints, a), axis=1).mean()
            for names in chains
            for a, b in pairwise(names)
        ]
        return float(sum(bones)) / 2

    def sample(self, times_s: Floats) -> tuple[Floats, Bools]:
        """Joints (N, 22, 3) by cubic splines and contacts (N, 2) of the nearest frame, at the given times."""
        frames = np.clip(times_s * self.fps, 0, len(self.joints) - 1)
        if len(self.joints) == 1:
            joints = np.repeat(self.joints, len(frames), axis=0)
        else:
            joints = CubicSpline(np.arange(len(self.joints)), self.joints)(frames)
        return joints, self.contacts[np.round(frames).astype(int)]


def joint(joints: Floats, name: str) -> Floats:
    """(T, 3) of one named joint."""
    return joints[:, INDEX[name]]


def align(motion: HumanMotion, thresholds: ContactThresholds | None = None) -> HumanClip:
    """Put a motion on a level floor at the origin, facing x, and find its foot contacts."""
    thresholds = thresholds or ContactThresholds()
    toes = _toes(motion.joints)
    still = np.stack([_speed(toes[:, i], motion.fps) < thresholds.speed[0] for i in range(len(SIDES))], axis=1)
    joints = put_on_level_floor(motion.joints, toes, still)
    hips = _mid(joints[:1], "left_hip", "right_hip")[0]
    turn = yaw_rotation(-heading(joints[:1]))[0]
    joints = (joints - np.array([hips[0], hips[1], 0.0])) @ turn.T
    ankles = np.stack([joint(joints, f"{side}_ankle") for side in SIDES], axis=1)
    ankle_rest = float(np.clip(np.percentile(ankles[..., 2].min(axis=1), 10), 0.02, 0.15))
    contacts = find_contacts(joints, motion.fps, ankle_rest, thresholds)
    pitches = np.stack([_pitch(foot_vectors(joints, side)) for side in SIDES], axis=1)
    rest = float(np.median(pitches[contacts])) if contacts.any() else float(np.median(pitches))
    return HumanClip(joints, motion.fps, ankle_rest, rest, contacts)


def find_contacts(joints: Floats, fps: float, ankle_rest: float, thresholds: ContactThresholds) -> Bools:
    """(T, 2) contacts by toe height, ankle height and toe speed, each with hysteresis.

    Height alone takes a low swing for a stance, toe height alone a foot that drags its toes: the ankle must be low too.
    Where neither foot is still, those stand whose toe or heel is on the floor: a person who walks briskly rolls from
    toes to heel, one who runs only slows his feet down, and captured feet slide.
    """
    contacts, touching = np.zeros((len(joints), 2), dtype=bool), np.zeros((len(joints), 2), dtype=bool)
    shortest = round(SHORTEST_CONTACT_S * fps)
    for i, side in enumerate(SIDES):
        toe, ankle = foot_heights(joints, side, ankle_rest)
        start, hold = thresholds.stands(toe, ankle, _speed(joint(joints, f"{side}_foot"), fps))
        contacts[:, i] = _without_blips(_hysteresis(start, hold), shortest)
        touching[:, i] = np.minimum(toe, ankle) < TOUCH_M
    contacts |= touching & ~contacts.any(axis=1, keepdims=True)
    return np.stack([_without_blips(foot, shortest) for foot in contacts.T], axis=1)


def foot_heights(joints: Floats, side: str, ankle_rest: float) -> tuple[Floats, Floats]:
    """(T,) heights of the toe and of the ankle above where they are when the foot stands, m."""
    return joint(joints, f"{side}_foot")[:, 2], joint(joints, f"{side}_ankle")[:, 2] - ankle_rest


def heading(joints: Floats) -> Floats:
    """(T,) yaw of the body in rad, unwrapped: across the hips."""
    across = joint(joints, "left_hip") - joint(joints, "right_hip")
    return np.unwrap(np.arctan2(-across[:, 0], across[:, 1]))


def pelvis_rotation(joints: Floats) -> Floats:
    """(T, 3, 3) orientation of the pelvis; the identity for a person who stands upright and faces x."""
    up = joint(joints, "spine1") - _mid(joints, "left_hip", "right_hip")
    across = joint(joints, "left_hip") - joint(joints, "right_hip")
    return _upright_frame(up, across, PELVIS_REST_TILT)


def torso_rotation(joints: Floats) -> Floats:
    """(T, 3, 3) orientation of the chest; across the collars, because shoulders move with the arms."""
    up = joint(joints, "neck") - joint(joints, "spine1")
    across = joint(joints, "left_collar") - joint(joints, "right_collar")
    return _upright_frame(up, across, TORSO_REST_TILT)


def head_rotation(joints: Floats) -> Floats:
    """(T, 3, 3) orientation of the head: bowed and tilted as neck and head show, turned as the collars.

    The skeleton has no face, so a head that turns on the neck cannot be seen.
    """
    up = joint(joints, "head") - joint(joints, "neck")
    across = joint(joints, "left_collar") - joint(joints, "right_collar")
    return _upright_frame(up, across, HEAD_REST_TILT)


def foot_vectors(joints: Floats, side: str) -> Floats:
    """(T, 3) from ankle to toe."""
    return joint(joints, f"{side}_foot") - joint(joints, f"{side}_ankle")


def foot_angles(joints: Floats, side: str, pitch_rest: float) -> tuple[Floats, Floats]:
    """(T,) yaw, unwrapped, and (T,) pitch (toes down positive) of a foot in rad."""
    vectors = foot_vectors(joints, side)
    return np.unwrap(np.arctan2(vectors[:, 1], vectors[:, 0])), _pitch(vectors) - pitch_rest


def _pitch(vectors: Floats) -> Floats:
    return np.arctan2(-vectors[:, 2], np.hypot(vectors[:, 0], vectors[:, 1]))


def _upright_frame(up: Floats, across: Floats, tilt: float) -> Floats:
    z = unit(up)
    y = unit(across - np.einsum("ti,ti->t", across, z)[:, None] * z)
    frame = np.empty((len(z), 3, 3))
    frame[..., 1], frame[..., 2] = y, z
    for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
        frame[:, i, 0] = y[:, j] * z[:, k] - y[:, k] * z[:, j]
    return frame @ pitch_rotation(np.array(-tilt))


def _toes(joints: Floats) -> Floats:
    """(T, 2, 3) of the left and the right foot."""
    return np.stack([joint(joints, f"{side}_foot") for side in SIDES], axis=1)


def _mid(joints: Floats, first: str, second: str) -> Floats:
    return (joint(joints, first) + joint(joints, second)) / 2


def _speed(points: Floats, fps: float) -> Floats:
    if len(points) == 1:
        return np.zeros(1)
    return np.linalg.norm(np.gradient(points, axis=0), axis=1) * fps


def _hysteresis(start: Bools, hold: Bools) -> Bools:
    """On from a frame where `start` holds until `hold` no longer does, in both directions of time."""
    out = np.zeros(len(start), dtype=bool)
    for order in (range(len(start)), range(len(start) - 1, -1, -1)):
        state = False
        for k in order:
            state = bool(hold[k]) and (state or bool(start[k]))
            out[k] |= state
    return out


def _without_blips(contact: Bools, frames: int) -> Bools:
    """Gaps and contacts of up to `frames` frames removed."""
    size = np.ones(max(frames, 1) + 1, dtype=bool)
    if len(contact) <= len(size):
        return contact
    pad = len(size)
    padded = np.pad(contact, pad, mode="edge")
    return np.asarray(binary_opening(binary_closing(padded, size), size), dtype=bool)[pad:-pad]
