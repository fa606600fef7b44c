"""The 263-feature motion encoding of HumanML3D (Guo et al., CVPR 2022), and the 251 of KIT-ML, with its inverse.

One row a frame, for J joints: root yaw velocity (1), root velocity in the floor plane (2), root height (1),
joint positions about the root (3(J-1)), joint rotations in 6-D (6(J-1)), joint velocities (3J), foot contacts (4).
Inside the encoding y is up and the body faces z+, so x points left; positions and velocities are seen from a
heading that turns with the body. Velocities are per frame, and the yaw velocity is HumanML3D's: the arcsine of
the y component of the quaternion that turns the world to the next heading, which is minus half the angle in rad.

Two choices follow the published features rather than taste, so that both mix in one training set: the
heading after smoothing comes from the shoulder line minus the hip line, and arm chains start their rotations
from the root. One does not: where the heading crosses 180 degrees the published yaw velocity changes sign for
one frame and the published positions bend there; here the angle is unwrapped and the inverse is exact.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import gaussian_filter1d  # pyright: ignore[reportMissingTypeStubs, reportUnknownVariableType]
from scipy.spatial.transform import Rotation  # pyright: ignore[reportMissingTypeStubs]

from ros_free_stack.errors import InvalidMessage
from ros_free_stack.skeleton import CHAINS, INDEX, JOINT_NAMES

Floats = NDArray[np.float64]

HEADING_SMOOTHING: Final = 20.0
"""Standard deviation, in frames, of the Gaussian that smooths the heading (HumanML3D's value)."""

_TO_Y_UP: Final = (1, 2, 0)
_TO_Z_UP: Final = (2, 0, 1)


@dataclass(frozen=True)
class Skeleton:
    """What the encoding has to know of a skeleton.

    Attributes:
        joints: J names, the root first.
        chains: kinematic chains of joint indices.
        directions: for each joint the direction of its bone in the rest pose: one of "left", "right", "up",
            "down", "forward" ("" for the root).
        hips, shoulders: (right, left) joint indices that define the heading.
        feet: four joints with a contact channel: left ankle, left foot, right ankle, right foot.
        contact_step: a foot that moves less than this between two frames (m) is in contact.
    """

    joints: tuple[str, ...]
    chains: tuple[tuple[int, ...], ...]
    directions: tuple[str, ...]
    hips: tuple[int, int]
    shoulders: tuple[int, int]
    feet: tuple[int, int, int, int]
    contact_step: float

    @property
    def width(self) -> int:
        """Number of features."""
        return 12 * len(self.joints) - 1

    @property
    def parents(self) -> list[int]:
        """Parent of each joint but the root."""
        parent = {child: start for chain in self.chains for start, child in pairwise(chain)}
        return [parent[joint] for joint in range(1, len(self.joints))]

    @property
    def rotation_parents(self) -> list[int]:
        """Joint that the rotation of each joint but the root is relative to: every chain starts from the root."""
        parent = {chain[1]: 0 for chain in self.chains}
        parent |= {child: start for chain in self.chains for start, child in pairwise(chain[1:])}
        return [parent[joint] for joint in range(1, len(self.joints))]

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the features, in order."""
        axes = ("left", "up", "forward")
        return (
            "root_yaw_velocity",
            "root_left_velocity",
            "root_forward_velocity",
            "root_height",
            *(f"{joint}_position_{axis}" for joint in self.joints[1:] for axis in axes),
            *(f"{joint}_rotation_{i}" for joint in self.joints[1:] for i in range(6)),
            *(f"{joint}_velocity_{axis}" for joint in self.joints for axis in axes),
            *(f"{self.joints[foot]}_contact" for foot in self.feet),
        )


HUMANML3D: Final = Skeleton(
    joints=JOINT_NAMES,
    chains=CHAINS,
    directions=(
        "", "left", "right", "up", "down", "down", "up", "down", "down", "up", "forward", "forward",
        "up", "left", "right", "forward", "down", "down", "down", "down", "down", "down",
    ),
    hips=(INDEX["right_hip"], INDEX["left_hip"]),
    shoulders=(INDEX["right_shoulder"], INDEX["left_shoulder"]),
    feet=(INDEX["left_ankle"], INDEX["left_foot"], INDEX["right_ankle"], INDEX["right_foot"]),
    contact_step=0.002**0.5,
)  # fmt: skip
"""The 22 joints of HumanML3D: 263 features at 20 fps."""

KIT: Final = Skeleton(
    joints=(
        "root", "BP", "BT", "BLN", "BUN", "LS", "LE", "LW", "RS", "RE", "RW",
        "LH", "LK", "LA", "LMrot", "LF", "RH", "RK", "RA", "RMrot", "RF",
    ),
    chains=((0, 11, 12, 13, 14, 15), (0, 16, 17, 18, 19, 20), (0, 1, 2, 3, 4), (3, 5, 6, 7), (3, 8, 9, 10)),
    directions=(
        "", "up", "up", "up", "up", "left", "down", "down", "right", "down", "down",
        "left", "down", "down", "forward", "forward", "right", "down", "down", "forward", "forward",
    ),
    hips=(16, 11),
    shoulders=(8, 5),
    feet=(14, 15, 19, 20),
    contact_step=0.05**0.5 / 1000,
)  # fmt: skip
"""The 21 joints of KIT-ML (names of the Master Motor Map): 251 features at 12.5 fps."""

CHANNELS: Final[tuple[str, ...]] = HUMANML3D.channels


def encode(joints: ArrayLike, skeleton: Skeleton = HUMANML3D) -> Floats:
    """Features of a motion.

    Args:
        joints: (T, J, 3) positions in m, z up, at the data set's frame rate, on the floor z = 0; T >= 2.
        skeleton: which joints they are.

    Returns:
        (T - 1, 12 J - 1): the last frame only closes the last velocity.

    Raises:
        InvalidMessage: wrong shape, fewer than two frames, or values that are not finite.
    """
    points = _checked(joints, "joints", (len(skeleton.joints), 3), frames=2)[..., _TO_Y_UP]
    points = _face_forward(points, skeleton)
    yaw = _smooth_heading(points, skeleton)
    to_local = _turn(-yaw)
    moved = np.diff(points, axis=0)
    root_step = _rotate(to_local[1:], moved[:, :1])[:, 0]
    local = _rotate(to_local, points - points[:, :1] * (1, 0, 1))
    steps = np.linalg.norm(moved[:, skeleton.feet], axis=-1)
    blocks = (
        -_wrapped(np.diff(yaw))[:, None] / 2,
        root_step[:, (0, 2)],
        points[:-1, 0, 1:2],
        local[:-1, 1:],
        _rotations(points, yaw, skeleton)[:-1],
        _rotate(to_local[:-1], moved),
        steps < skeleton.contact_step,
    )
    return np.concatenate([block.reshape(len(moved), -1) for block in blocks], axis=1)


def decode(features: ArrayLike, skeleton: Skeleton = HUMANML3D) -> Floats:
    """Joint positions of a motion from its root velocities and local positions.

    Args:
        features: (T, 12 J - 1) rows as `encode` gives them, in any float type.
        skeleton: which joints they describe.

    Returns:
        (T, J, 3) in m, z up; the root starts above the origin and faces x+.

    Raises:
        InvalidMessage: wrong shape, no frames, or values that are not finite.
    """
    rows = _checked(features, "features", (skeleton.width,), frames=1)
    start = np.zeros((1, 3))
    yaw = -2 * np.concatenate([[0.0], np.cumsum(rows[:-1, 0])])
    to_world = _turn(yaw)
    step = np.zeros((len(rows) - 1, 1, 3))
    step[:, 0, (0, 2)] = rows[:-1, 1:3]
    root = np.concatenate([start, np.cumsum(_rotate(to_world[1:], step)[:, 0], axis=0)])
    local = rows[:, 4 : 4 + 3 * (len(skeleton.joints) - 1)].reshape(len(rows), -1, 3)
    points = np.concatenate([root[:, None], _rotate(to_world, local) + root[:, None]], axis=1)
    points[:, 0, 1] = rows[:, 3]
    return points[..., _TO_Z_UP]


def to_float16(features: ArrayLike) -> NDArray[np.float16]:
    """Round features to half precision without drift.

    The three velocities that `decode` integrates carry their rounding error to the next frame, so that their
    sums stay within one rounding step of the exact ones however long the motion is.
    """
    rows = np.array(features, dtype=np.float64)
    stored = rows.astype(np.float16)
    carry = np.zeros(3)
    for row, exact in zip(stored, rows[:, :3], strict=True):
        row[:3] = exact + carry
        carry += exact - row[:3]
    return stored


def _checked(array: ArrayLike, name: str, tail: tuple[int, ...], frames: int) -> Floats:
    values = np.asarray(array, dtype=np.float64)
    if values.ndim != len(tail) + 1 or values.shape[1:] != tail or len(values) < frames:
        expected = ", ".join(map(str, ("T", *tail)))
        raise InvalidMessage("motion", name, f"expected ({expected}) with T >= {frames}, found {values.shape}")
    if not np.isfinite(values).all():
        frame = int(np.argwhere(~np.isfinite(values))[0, 0])
        raise InvalidMessage("motion", name, f"value that is not finite at frame {frame}")
    return values


def _turn(angle: Floats) -> Floats:
    """(T, 3, 3) rotations about y by (T,) angles in rad."""
    turn = np.zeros((*angle.shape, 3, 3))
    turn[..., 0, 0] = turn[..., 2, 2] = np.cos(angle)
    turn[..., 0, 2] = np.sin(angle)
    turn[..., 2, 0] = -turn[..., 0, 2]
    turn[..., 1, 1] = 1
    return turn


def _rotate(turn: Floats, points: Floats) -> Floats:
    """Apply (T, 3, 3) rotations to (T, K, 3) points."""
    return points @ turn.swapaxes(-1, -2)


def _wrapped(angle: Floats) -> Floats:
    return (angle + np.pi) % (2 * np.pi) - np.pi


def _unit(vectors: Floats, otherwise: Floats) -> Floats:
    """Vectors of length one; those of length zero become `otherwise`."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(length > 1e-9, vectors / np.maximum(length, 1e-9), otherwise)


def _forward(across: Floats) -> Floats:
    """Horizontal direction (..., 3) that a body with the given right-pointing line faces."""
    across = _unit(across, np.array([-1.0, 0.0, 0.0]))
    return np.cross([0.0, 1.0, 0.0], across)


def _yaw(forward: Floats) -> Floats:
    return np.arctan2(forward[..., 0], forward[..., 2])


def _face_forward(points: Floats, skeleton: Skeleton) -> Floats:
    """The motion moved and turned so that its first frame stands at the origin and faces z+."""
    (right_hip, left_hip), (right_shoulder, left_shoulder) = skeleton.hips, skeleton.shoulders
    first = points[0]
    across = first[right_hip] - first[left_hip] + first[right_shoulder] - first[left_shoulder]
    turn = _turn(-_yaw(_forward(across)))
    return (points - first[0] * (1, 0, 1)) @ turn.T


def _smooth_heading(points: Floats, skeleton: Skeleton) -> Floats:
    """(T,) smoothed heading in rad, 0 along z+; counts the hip line backwards as the published features do."""
    (right_hip, left_hip), (right_shoulder, left_shoulder) = skeleton.hips, skeleton.shoulders
    shoulders = points[:, right_shoulder] - points[:, left_shoulder]
    hips = points[:, right_hip] - points[:, left_hip]
    forward = _forward(shoulders - hips)
    return _yaw(np.asarray(gaussian_filter1d(forward, HEADING_SMOOTHING, axis=0, mode="nearest"), dtype=np.float64))


def _rotations(points: Floats, yaw: Floats, skeleton: Skeleton) -> Floats:
    """(T, J - 1, 6) first two columns of each joint's rotation relative to the one before it on its chain.

    The rotation of a joint is the shortest one from its bone in the rest pose to its bone in the frame.
    """
    axes = {"left": (1, 0, 0), "right": (-1, 0, 0), "up": (0, 1, 0), "down": (0, -1, 0), "forward": (0, 0, 1)}
    rest = np.array([axes[name] for name in skeleton.directions[1:]], dtype=np.float64)
    bones = _unit(points[:, 1:] - points[:, skeleton.parents], rest)
    turns = np.zeros((*points.shape[:2], 4))
    turns[:, 0, 0], turns[:, 0, 2] = np.cos(yaw / 2), -np.sin(yaw / 2)
    turns[:, 1:, 0] = 1 + (rest * bones).sum(-1)
    turns[:, 1:, 1:] = np.cross(rest, bones)
    # A bone opposite to its rest direction has no shortest rotation: turn it half around any axis across.
    opposite = np.linalg.norm(turns[:, 1:], axis=-1) < 1e-9
    turns[:, 1:, 1:][opposite] = np.broadcast_to(np.roll(rest, 1, axis=-1), bones.shape)[opposite]
    before = Rotation.from_quat(turns[:, skeleton.rotation_parents].reshape(-1, 4), scalar_first=True)
    after = Rotation.from_quat(turns[:, 1:].reshape(-1, 4), scalar_first=True)
    matrices = (before.inv() * after).as_matrix()
    return matrices[..., :2].swapaxes(-1, -2).reshape(*bones.shape[:2], 6)
