"""The reference body: segment lengths, and the geometry of one arm, one leg and one foot.

Joint centres of an adult of 1.70 m (anthropometric shares after Drillis and Contini, in Winter, "Biomechanics and Motor
Control of Human Movement"). All functions are batched over time: points are (T, 3), rotations (T, 3, 3).
World frame: z up, x forward, y left; metres and radians.
"""

from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.transform import Rotation

Floats = NDArray[np.float64]
Side = Literal["left", "right"]

SIDES: Final[tuple[Side, Side]] = ("left", "right")
OTHER: Final[dict[str, Side]] = {"left": "right", "right": "left"}
SIGN: Final[dict[str, float]] = {"left": 1.0, "right": -1.0}

HEIGHT: Final = 1.70
THIGH: Final = 0.232 * HEIGHT
SHANK: Final = 0.240 * HEIGHT
UPPER_ARM: Final = 0.160 * HEIGHT
FOREARM: Final = 0.140 * HEIGHT
LEG: Final = THIGH + SHANK
ARM: Final = UPPER_ARM + FOREARM

# Offsets of the left side; `mirrored` gives the right side's.
ANKLE_TO_BALL: Final = np.array([0.130, 0.0, -0.055])
ANKLE_TO_HEEL: Final = np.array([-0.045, 0.0, -0.075])
HIP: Final = np.array([0.0, 0.085, -0.075])
SPINE: Final = np.array([[-0.02, 0.0, 0.115], [0.005, 0.0, 0.13], [0.01, 0.0, 0.065]])
NECK: Final = np.array([-0.02, 0.0, 0.205])
HEAD: Final = np.array([0.025, 0.0, 0.100])
COLLAR: Final = np.array([-0.01, 0.075, 0.115])
SHOULDER: Final = np.array([-0.015, 0.105, 0.04])
BALL_HEIGHT: Final = 0.02
STANDING_HEIGHT: Final = 0.990 * LEG - HIP[2] - ANKLE_TO_BALL[2] + BALL_HEIGHT
"""Height of the pelvis of an upright stance, knees not quite locked."""

_ELBOW_POLE: Final = np.array([-0.70, 0.60, -0.30])
_ARM_CENTRE: Final = np.array([0.62, 0.50, -0.60]) / np.linalg.norm([0.62, 0.50, -0.60])
_ARM_OUT: Final = np.cross([0.0, 0.0, 1.0], _ARM_CENTRE) / np.linalg.norm(np.cross([0.0, 0.0, 1.0], _ARM_CENTRE))
_ARM_UP: Final = np.cross(_ARM_CENTRE, _ARM_OUT)


def unit(v: Floats) -> Floats:
    """`v` along its last axis with length one; zero stays zero."""
    return v / np.maximum(np.sqrt(np.sum(v * v, -1, keepdims=True)), 1e-9)


def mirrored(v: ArrayLike, side: str) -> Floats:
    """A left-side vector on the given side."""
    return np.asarray(v, dtype=float) * np.array([1.0, SIGN[side], 1.0])


def yaw_matrix(angle: Floats) -> Floats:
    """(T, 3, 3) rotations about the vertical."""
    rotation = np.zeros((len(angle), 3, 3))
    rotation[:, 0, 0] = rotation[:, 1, 1] = np.cos(angle)
    rotation[:, 1, 0] = np.sin(angle)
    rotation[:, 0, 1] = -rotation[:, 1, 0]
    rotation[:, 2, 2] = 1.0
    return rotation


def pitch_matrix(angle: Floats) -> Floats:
    """(T, 3, 3) rotations about the left axis."""
    rotation = np.zeros((len(angle), 3, 3))
    rotation[:, 0, 0] = rotation[:, 2, 2] = np.cos(angle)
    rotation[:, 0, 2] = np.sin(angle)
    rotation[:, 2, 0] = -rotation[:, 0, 2]
    rotation[:, 1, 1] = 1.0
    return rotation


def rotation_matrix(vector: Floats) -> Floats:
    """(T, 3, 3) rotations of (T, 3) rotation vectors."""
    return Rotation.from_rotvec(vector).as_matrix()


def rotate(rotation: Floats, v: ArrayLike) -> Floats:
    """(T, 3): each rotation applied to its own row of `v`, or to one shared vector."""
    return np.matmul(rotation, np.asarray(v, dtype=float)[..., None])[..., 0]


def wrap(angle: Floats) -> Floats:
    """The angle in [-pi, pi)."""
    return np.mod(angle + np.pi, 2 * np.pi) - np.pi


def direction_to_chart(direction: ArrayLike, side: str) -> Floats:
    """Directions (..., 3) of an arm as (..., 2): the logarithmic map of the sphere about a comfortable centre.

    The centre lies forward, outward and down, so that the chart's only singular direction (its antipode, behind the
    neck) is one that no wrist takes; both sides share one chart, hence equal values are mirror images.
    """
    d = unit(mirrored(direction, side))
    along = d @ _ARM_CENTRE
    tangent = unit(d - along[..., None] * _ARM_CENTRE)
    angle = np.arccos(np.clip(along, -1.0, 1.0))
    return np.stack([tangent @ _ARM_OUT, tangent @ _ARM_UP], -1) * angle[..., None]


def chart_to_direction(chart: Floats, side: str) -> Floats:
    """Inverse of `direction_to_chart`."""
    angle = np.linalg.norm(chart, axis=-1, keepdims=True)
    tangent = unit(chart[..., :1] * _ARM_OUT + chart[..., 1:2] * _ARM_UP)
    return mirrored(np.cos(angle) * _ARM_CENTRE + np.sin(angle) * tangent, side)


def aim(forward: float, outward: float, up: float, reach: float = 0.96, swivel: float = 0.0) -> Floats:
    """Arm key (4,): the wrist in a direction from the shoulder; `reach` 1 is a straight arm.

    `swivel` turns the elbow about the line from shoulder to wrist: negative backward and in, positive outward and up.
    """
    return np.append(direction_to_chart([forward, outward, up], "left"), [reach, swivel])


def hand_at(forward: float, outward: float, up: float, swivel: float = 0.0) -> Floats:
    """Arm key (4,): the wrist at a place relative to the middle between the shoulders, in metres."""
    offset = np.array([forward + 0.01, outward - 0.185, up])
    reach = min(float(np.linalg.norm(offset)) / ARM, 0.99)
    return np.append(direction_to_chart(offset, "left"), [reach, swivel])


def elbow_pole(side: str) -> Floats:
    """Direction into which an elbow bends at swivel 0, in the arm frame."""
    return mirrored(_ELBOW_POLE, side)


def _across(axis: Floats, pole: Floats) -> tuple[Floats, Floats]:
    """Two unit vectors that span the plane across `axis`, the first one towards the pole."""
    first = unit(pole - np.sum(pole * axis, -1, keepdims=True) * axis)
    return first, np.cross(axis, first)


def two_bone(
    start: Floats, target: Floats, first: float, second: float, pole: Floats, swivel: Floats
) -> tuple[Floats, Floats]:
    """Middle joint and end of a two-bone chain from `start` to `target`, (T, 3) each; out of reach ends short."""
    line = target - start
    axis = unit(line)
    length = np.clip(np.linalg.norm(line, axis=-1), abs(first - second) + 0.02, (first + second) * 0.9995)
    towards, aside = _across(axis, pole)
    along = (first**2 - second**2 + length**2) / (2 * length)
    height = np.sqrt(np.maximum(first**2 - along**2, 0.0))
    bend = towards * np.cos(swivel)[:, None] + aside * np.sin(swivel)[:, None]
    return start + axis * along[:, None] + bend * height[:, None], start + axis * length[:, None]


def swung(v: Floats, axis: Floats) -> Floats:
    """(T, 3): `v`, level in a frame, after the smallest rotation that takes the frame's downward axis to `axis` (T, 3).

    Where a leg swings, its knee's direction swings along; only a leg along the trunk, upwards, leaves it undefined.
    """
    axis = unit(axis)
    both = axis - [0.0, 0.0, 1.0]
    share = np.sum(axis * v, -1) / np.maximum(1.0 - axis[:, 2], 1e-6)
    return v - share[:, None] * both


def bend(start: Floats, middle: Floats, end: Floats, pole: Floats) -> tuple[Floats, Floats]:
    """How far (T,) the middle joint of a chain lies off its line, towards the pole and aside: m.

    Aside over towards is the tangent of the swivel that `two_bone` takes.
    """
    towards, aside = _across(unit(end - start), pole)
    off = middle - start
    return np.sum(off * towards, -1), np.sum(off * aside, -1)


def ankle_and_ball(foot: Floats, roll: Floats) -> tuple[Floats, Floats]:
    """Ankle and ball (T, 3) of a foot (T, 4: ball when flat, yaw) rolled by (T,).

    A positive roll lifts the heel about the ball, a negative one the ball about the heel.
    """
    yaw = yaw_matrix(foot[:, 3])
    rolled = yaw @ pitch_matrix(roll)
    heel_to_ball = ANKLE_TO_BALL - ANKLE_TO_HEEL
    on_heel = foot[:, :3] - rotate(yaw, heel_to_ball) + rotate(rolled, heel_to_ball)
    ball = np.where(roll[:, None] >= 0, foot[:, :3], on_heel)
    return ball - rotate(rolled, ANKLE_TO_BALL), ball
