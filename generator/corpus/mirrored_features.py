"""Reflection of a motion's features left to right, without the trip to joints and back."""

from functools import cache
from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.formats.features import HUMANML3D, Skeleton

Real = TypeVar("Real", bound=np.floating)

_NEGATED: Final = ("yaw_velocity", "_left", "left_velocity", "rotation_1", "rotation_2", "rotation_3")
"""Ends of the names of channels that change their sign: what points left, and of a rotation's first two columns the
elements that couple the left axis with another one."""


def mirror_features(features: NDArray[Real], skeleton: Skeleton = HUMANML3D) -> NDArray[Real]:
    """Features (T, F) of the reflected motion, in the same type."""
    source, sign = _reflection(skeleton)
    return (features[:, source] * sign).astype(features.dtype)


@cache
def _reflection(skeleton: Skeleton) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """(F,) channel that each channel comes from, and its sign."""
    channels = skeleton.channels
    source = np.array([channels.index(_opposite(channel, skeleton)) for channel in channels])
    return source, np.array([-1 if channel.endswith(_NEGATED) else 1 for channel in channels], np.float32)


def _opposite(channel: str, skeleton: Skeleton) -> str:
    """The same channel of the other side's joint: left_knee and right_knee, or in KIT-ML LK and RK."""
    for side, other in (("left_", "right_"), ("right_", "left_")):
        if channel.startswith(side):
            return other + channel.removeprefix(side)
    for side, other in (("L", "R"), ("R", "L")):
        if channel.startswith(side) and other + channel.partition("_")[0][1:] in skeleton.joints:
            return other + channel[1:]
    return channel
