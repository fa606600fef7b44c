"""Which way is up in a file: the way in which the person stands.

Where the person stands clearly along one axis, that is up. Where not (a person lies, crawls or tumbles), up is what it
usually is in such files. A person who lies all the time looks like one who stands in a file with another axis: then the
way counts in which the person stands, unless only lying explains it, and the command says so.
"""

from typing import Final

import numpy as np

from ros_free_stack.formats.source import UpAxis
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import INDEX

_TURNS: Final[dict[UpAxis, tuple[tuple[int, int, int], tuple[int, int, int]]]] = {
    "z": ((0, 1, 2), (1, 1, 1)),
    "y": ((2, 0, 1), (1, 1, 1)),
    "x": ((1, 2, 0), (1, 1, 1)),
    "y-down": ((2, 0, 1), (-1, 1, -1)),
}
"""For each up axis, which axes of the file become x, y and z, and their signs: rotations all of them."""

_LIKELY: Final[tuple[UpAxis, ...]] = ("y", "z", "y-down")

CLEAR: Final = 2.0
"""How much further from ankles to head it must be along the up axis than along any other."""


def turned_up(points: Floats, up: UpAxis) -> Floats:
    """(..., 3) points of a file with that up axis in a z-up world; from y up, what faced z then faces x."""
    axes, signs = _TURNS[up]
    return points[..., axes] * np.array(signs, dtype=np.float64)


def standing_axis(joints: Floats) -> str | None:
    """The axis that (T, 22, 3) joints stand along, such as "y" or "x-down"; None where none is clear."""
    ankles = joints[:, [INDEX["left_ankle"], INDEX["right_ankle"]]].mean(axis=1)
    way = (joints[:, INDEX["head"]] - ankles).mean(axis=0)
    axis = int(np.argmax(np.abs(way)))
    if np.abs(way[axis]) < CLEAR * np.delete(np.abs(way), axis).max():
        return None
    return "xyz"[axis] + ("" if way[axis] > 0 else "-down")


def up_axis(joints: Floats, usual: UpAxis | None) -> tuple[UpAxis | None, bool]:
    """The up axis of (T, 22, 3) joints, None where it has to be asked for, and whether there is a doubt to tell.

    Whoever stands along x lies, in all probability; whoever stands on his head along y was filmed by a camera, whose
    y axis points down.
    """
    stands = standing_axis(joints)
    for axis in _LIKELY:
        if stands == axis:
            return axis, axis != usual and (usual is not None or axis == "y-down")
    return (None if stands == f"{usual}-down" else usual), False
