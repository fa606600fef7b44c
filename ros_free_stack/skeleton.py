"""The human skeleton: HumanML3D's 22 joints (SMPL order) and the body parts that metrics and models use.

World frame: z up, x forward, y left; metres.
"""

from typing import Final

FPS: Final = 20.0
"""Frame rate of HumanML3D, and of every human motion in this project, in Hz."""

JOINT_NAMES: Final[tuple[str, ...]] = (
    "pelvis",
    "left_hip",
    "right_hip",
    "spine1",
    "left_knee",
    "right_knee",
    "spine2",
    "left_ankle",
    "right_ankle",
    "spine3",
    "left_foot",
    "right_foot",
    "neck",
    "left_collar",
    "right_collar",
    "head",
    "left_shoulder",
    "right_shoulder",
    "left_elbow",
    "right_elbow",
    "left_wrist",
    "right_wrist",
)
JOINT_COUNT: Final = len(JOINT_NAMES)
INDEX: Final[dict[str, int]] = {name: i for i, name in enumerate(JOINT_NAMES)}

PARENTS: Final[tuple[int, ...]] = (
    -1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19,
)  # fmt: skip
"""Parent of each joint; -1 for the root."""

BONES: Final[tuple[tuple[int, int], ...]] = tuple(
    (parent, child) for child, parent in enumerate(PARENTS) if parent >= 0
)

CHAINS: Final[tuple[tuple[int, ...], ...]] = (
    (0, 2, 5, 8, 11),
    (0, 1, 4, 7, 10),
    (0, 3, 6, 9, 12, 15),
    (9, 14, 17, 19, 21),
    (9, 13, 16, 18, 20),
)
"""Kinematic chains in HumanML3D's order: right leg, left leg, trunk, right arm, left arm."""

MIRRORED: Final[tuple[int, ...]] = (
    0, 2, 1, 3, 5, 4, 6, 8, 7, 9, 11, 10, 12, 14, 13, 15, 17, 16, 19, 18, 21, 20,
)  # fmt: skip
"""`joints[:, MIRRORED] * (1, -1, 1)` reflects a motion left to right."""

PARTS: Final[dict[str, tuple[int, ...]]] = {
    "left_arm": (13, 16, 18, 20),
    "right_arm": (14, 17, 19, 21),
    "left_leg": (1, 4, 7, 10),
    "right_leg": (2, 5, 8, 11),
    "backbone": (0, 3, 6, 9, 12, 15),
}
"""The five body parts of ParTY (section S.2)."""
