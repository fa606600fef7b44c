"""The body in parts that have codes of their own.

One code for the whole body has to be learned for every combination of what arms and legs do; codes of parts combine
freely (ParTY, section 3.2, gives arms and legs their own tokens beside holistic ones).
"""

from typing import Final

from generator.models.segmo.config import PartsKind
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import CHANNELS

_JOINTS: Final[dict[str, tuple[str, ...]]] = {
    "legs": (
        "root",
        "pelvis",
        *(f"{side}_{j}" for side in ("left", "right") for j in ("hip", "knee", "ankle", "foot")),
    ),
    "trunk": ("spine1", "spine2", "spine3"),
    "head": ("neck", "head"),
    "left arm": ("left_collar", "left_shoulder", "left_elbow", "left_wrist"),
    "right arm": ("right_collar", "right_shoulder", "right_elbow", "right_wrist"),
}


def part_channels(kind: PartsKind, features: int = len(CHANNELS)) -> tuple[tuple[int, ...], ...]:
    """The features of each part; every one belongs to one part.

    The root's path and the contacts of the feet belong to the legs, which make them.

    Raises:
        InvalidOption: the parts of a skeleton other than HumanML3D's are not known.
    """
    if kind == "whole":
        return (tuple(range(features)),)
    if features != len(CHANNELS):
        raise InvalidOption(
            "tokenizer.model.parts", f"limbs are known of {len(CHANNELS)} features, found {features}; take whole"
        )
    return tuple(
        tuple(i for i, name in enumerate(CHANNELS) if name.startswith(tuple(f"{joint}_" for joint in joints)))
        for joints in _JOINTS.values()
    )


def part_count(kind: PartsKind) -> int:
    """How many parts there are."""
    return len(part_channels(kind))
