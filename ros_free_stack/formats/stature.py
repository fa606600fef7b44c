"""How large a person is, and thereby in which unit a file measures.

The unit is judged by the whole body: legs, arms and trunk each say how tall the person would be, and the middle one
counts, so that long legs or a short trunk alone mislead nobody.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.asf_amc import INCH
from ros_free_stack.formats.source import SourceOptions, Units
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import INDEX

METRES: Final[dict[Units, float]] = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": INCH, "cmu": INCH / 0.45}
"""Metres a unit; `cmu` is the length unit of CMU's skeletons."""

TALL_M: Final = (1.25, 2.15)
"""Statures of people from a child of eight on, m. The units lie too far apart for two of them to fit."""

AVERAGE_M: Final = 1.7
"""Stature of a person of whom nothing is known."""

_SHARES: Final[tuple[tuple[float, tuple[tuple[str, ...], ...]], ...]] = (
    (0.466, tuple(tuple(f"{side}_{name}" for name in ("hip", "knee", "ankle")) for side in ("left", "right"))),
    (0.29, tuple(tuple(f"{side}_{name}" for name in ("shoulder", "elbow", "wrist")) for side in ("left", "right"))),
    (0.30, (("pelvis", "neck"),)),
)
"""Shares of the stature in legs, arms and trunk, and the chains of joints that measure them (SMPL's mean body)."""


def stature(joints: Floats) -> float:
    """How tall a person of average proportions with these (T, 22, 3) joints is, in the joints' unit."""
    return float(np.median([np.mean([_length(joints, c) for c in chains]) / share for share, chains in _SHARES]))


def metres_a_unit(joints: Floats, options: SourceOptions, usual: Units | None) -> tuple[float, str, tuple[str, ...]]:
    """Metres a unit of (T, 22, 3) joints, in words what that unit is, and what has to be said of doubts.

    Args:
        joints: in the file's unit.
        options: `units` and `height` overrule the guess.
        usual: the unit of such files; counts where it gives a person.

    Raises:
        InvalidOption: the person has no size at all, or both options are given.
    """
    tall = stature(joints)
    if not tall > 0:
        raise InvalidOption("--units", "cannot be told: the person's limbs have no length")
    if options.height is not None:
        if options.units is not None or not 0.3 <= options.height <= 3.0:
            raise InvalidOption("--height", "expected 0.3 to 3 m, and no --units beside it")
        return options.height / tall, f"units of {100 * options.height / tall:.3g} cm", ()
    if options.units is not None:
        return METRES[options.units], options.units, ()
    fits: list[Units] = [unit for unit, metres in METRES.items() if TALL_M[0] <= metres * tall <= TALL_M[1]]
    if usual is not None and (usual in fits or not fits):
        return METRES[usual], usual, () if usual in fits else (_doubt(tall, usual),)
    if fits:
        return METRES[fits[0]], fits[0], ()
    metres = AVERAGE_M / tall
    sizes = ", ".join(f"{size * tall:.3g} m in {unit}" for unit, size in METRES.items() if 0.1 < size * tall < 10)
    note = f"no unit gives a person's size ({sizes}): scaled to {AVERAGE_M:g} m; --height or --units settles it"
    return metres, f"units of {100 * metres:.3g} cm", (note,)


def _doubt(tall: float, unit: Units) -> str:
    return f"the person is {METRES[unit] * tall:.3g} m tall if lengths are in {unit}; --height or --units settles it"


def _length(joints: Floats, chain: Sequence[str]) -> float:
    bones = [np.linalg.norm(joints[:, INDEX[b]] - joints[:, INDEX[a]], axis=1) for a, b in pairwise(chain)]
    return float(np.median(np.sum(bones, axis=0)))
