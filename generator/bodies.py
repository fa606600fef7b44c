"""The whole body and parts of it, as features of a frame: what has tokens of its own, or an evaluator of its own."""

from collections.abc import Sequence
from typing import Final

from ros_free_stack.errors import InvalidOption, UnknownName
from ros_free_stack.formats.features import CHANNELS

WHOLE: Final = "whole"

_ROOT: Final = ("root", "pelvis")
_LEG: Final = ("hip", "knee", "ankle", "foot")
_ARM: Final = ("collar", "shoulder", "elbow", "wrist")
_TRUNK: Final = ("spine1", "spine2", "spine3", "neck", "head")


def _sided(side: str, joints: Sequence[str]) -> tuple[str, ...]:
    return tuple(f"{side}_{joint}" for joint in joints)


PARTS: Final[dict[str, tuple[str, ...]]] = {
    "arms": (*_sided("left", _ARM), *_sided("right", _ARM)),
    "legs": (*_ROOT, *_sided("left", _LEG), *_sided("right", _LEG)),
    "trunk": _TRUNK,
    "left_arm": _sided("left", _ARM),
    "right_arm": _sided("right", _ARM),
    "left_leg": _sided("left", _LEG),
    "right_leg": _sided("right", _LEG),
    "backbone": _TRUNK,
    "root": _ROOT,
}
"""Joints of each part. The root's path belongs to the legs, which make it, and so do the contacts of the feet."""


def channels(body: str, features: int = len(CHANNELS)) -> tuple[int, ...]:
    """The features of a body, by their index.

    Raises:
        UnknownName: there is no such part.
        InvalidOption: the parts of a skeleton other than HumanML3D's are not known.
    """
    if body == WHOLE:
        return tuple(range(features))
    if body not in PARTS:
        raise UnknownName("part of the body", body, (WHOLE, *PARTS))
    if features != len(CHANNELS):
        raise InvalidOption("body", f"parts are known of {len(CHANNELS)} features, found {features} in the data set")
    names = tuple(f"{joint}_" for joint in PARTS[body])
    return tuple(i for i, name in enumerate(CHANNELS) if name.startswith(names))
