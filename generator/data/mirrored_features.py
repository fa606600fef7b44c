"""Reflection of a motion's features left to right, without the trip to joints and back."""

from typing import Final, TypeVar

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.formats.features import CHANNELS

Real = TypeVar("Real", bound=np.floating)

_NEGATED: Final = ("yaw_velocity", "_left", "left_velocity", "rotation_1", "rotation_2", "rotation_3")
"""Ends of the names of channels that change their sign: what points left, and of a rotation's first two columns the
elements that couple the left axis with another one."""


def mirror_features(features: NDArray[Real]) -> NDArray[Real]:
    """Features (T, 263) of the reflected motion, in the same type."""
    return (features[:, _SOURCE] * _SIGN).astype(features.dtype)


def _opposite(channel: str) -> str:
    for side, other in (("left_", "right_"), ("right_", "left_")):
        if channel.startswith(side):
            return other + channel.removeprefix(side)
    return channel


_SOURCE: Final = np.array([CHANNELS.index(_opposite(channel)) for channel in CHANNELS])
_SIGN: Final = np.array([-1 if channel.endswith(_NEGATED) else 1 for channel in CHANNELS], np.float32)
