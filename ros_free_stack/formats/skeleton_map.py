"""From the joints of other skeletons to HumanML3D's 22.

Each target joint is a weighted mean of named source points, because some have no counterpart: a collar lies
between the upper spine and the shoulder, and CMU's forearm is split at the point where it twists.
"""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.errors import StackError
from ros_free_stack.skeleton import JOINT_NAMES

Floats = NDArray[np.float64]
Weights = Mapping[str, Mapping[str, float]]


class UnknownSkeleton(StackError):
    """The joints of a file belong to no skeleton that the readers know."""


def weights(**sources: str | Mapping[str, float]) -> Weights:
    """Expand `joint="name"` to a single weight, and `left_x`/`right_x` joints from `x` with `{s}` in the name."""
    table: dict[str, Mapping[str, float]] = {}
    for joint, source in sources.items():
        blend = {source: 1.0} if isinstance(source, str) else source
        if joint in JOINT_NAMES:
            table[joint] = blend
            continue
        for side in ("left", "right"):
            forms = {"s": side[0], "S": side[0].upper(), "side": side.capitalize(), "lower": side}
            table[f"{side}_{joint}"] = {name.format(**forms): weight for name, weight in blend.items()}
    return table


ASF: Final = weights(
    pelvis="root",
    spine1="lowerback",
    spine2="upperback",
    spine3="thorax",
    neck="upperneck",
    head="head",
    hip="{s}hipjoint",
    knee="{s}femur",
    ankle="{s}tibia",
    foot="{s}foot",
    collar={"thorax": 0.55, "{s}clavicle": 0.45},
    shoulder="{s}clavicle",
    elbow="{s}humerus",
    wrist={"{s}radius": 0.4, "{s}wrist": 0.6},
)
"""CMU's ASF skeleton, by the bone that ends at the joint. The bone `wrist` continues `radius` in a straight line
(it only twists) and is always half as long; 0.6 of it gives the forearm a human length."""

DAZ: Final = weights(
    pelvis="hip",
    spine1="abdomen",
    spine2={"abdomen": 0.5, "chest": 0.5},
    spine3="chest",
    neck="neck",
    head="head",
    hip="{s}Thigh",
    knee="{s}Shin",
    ankle="{s}Foot",
    foot="{s}Foot_end",
    collar="{s}Collar",
    shoulder="{s}Shldr",
    elbow="{s}ForeArm",
    wrist="{s}Hand",
)
"""The DAZ-friendly BVH conversion of the CMU archive, one figure for all subjects, in cm."""

SUBJECT_131: Final = weights(
    pelvis="Hips",
    spine1="Chest",
    spine2={"Chest": 0.5, "Chest2": 0.5},
    spine3="Chest2",
    neck="Head",
    head="Head_end",
    hip="{side}Hip",
    knee="{side}Knee",
    ankle="{side}Ankle",
    foot="{side}Toe",
    collar={"Chest2": 0.55, "{side}Shoulder": 0.45},
    shoulder="{side}Shoulder",
    elbow="{side}Elbow",
    wrist={"{side}Elbow": -0.3, "{side}Wrist": 1.3},
)
"""The BVH files of CMU's subject 131: an ASF skeleton whose joints are named by where a bone starts, without the
bone of the thorax; the forearm is lengthened as above."""


KIT_ML: Final = weights(
    pelvis="root",
    spine1="BP",
    spine2={"BP": 0.5, "BT": 0.5},
    spine3="BT",
    neck="BLN",
    head="BUN",
    hip="{S}H",
    knee="{S}K",
    ankle="{S}A",
    foot="{S}F",
    collar={"BT": 0.55, "{S}S": 0.45},
    shoulder="{S}S",
    elbow="{S}E",
    wrist="{S}W",
)
"""The 21 joints of KIT-ML, by their names in the Master Motor Map."""


def select(names: Sequence[str], points: Floats, weights: Weights) -> Floats:
    """(T, S, 3) named points as (T, 22, 3) joints.

    Raises:
        UnknownSkeleton: a source point is missing.
    """
    place = {name: i for i, name in enumerate(names)}
    matrix = np.zeros((len(JOINT_NAMES), len(names)))
    for row, joint in zip(matrix, JOINT_NAMES, strict=True):
        for name, weight in weights[joint].items():
            if name not in place:
                raise UnknownSkeleton(f"no joint {name!r} (for {joint}) among {', '.join(names)}")
            row[place[name]] = weight
    return matrix @ points
