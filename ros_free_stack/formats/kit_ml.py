"""KIT-ML (Plappert et al., 2016) in HumanML3D's layout: 21 joints, 251 features, 12.5 fps, lengths in mm.

The joints are those of the Master Motor Map; their names say which side is left. Published conversions disagree
with the names by a reflection or by facing backwards, so the side is checked against the toes.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.features import KIT
from ros_free_stack.formats.frames import face_forward, put_on_floor, resample
from ros_free_stack.formats.humanml3d import PublishedDataset, open_published
from ros_free_stack.formats.skeleton_map import KIT_ML, select
from ros_free_stack.skeleton import FPS

Floats = NDArray[np.float64]

KIT_FPS = 12.5
MILLIMETRE = 0.001


def open_kit_ml(folder: Path) -> PublishedDataset:
    """The data set in a folder; its features and joints come in the files' mm and 12.5 fps.

    Raises:
        InvalidFile: the folder lacks a part of the layout.
    """
    return open_published(folder, KIT)


def read_joints(dataset: PublishedDataset, clip: str) -> Floats:
    """A clip of KIT-ML as HumanML3D's 22 joints.

    Returns:
        (T, 22, 3) in m at 20 fps, z up, the first frame above the origin and facing x, on the floor z = 0.

    Raises:
        InvalidFile: a file is missing or malformed, or its lengths are not in mm.
    """
    points = dataset.joints(clip)
    height = float(np.median(np.ptp(points[..., 2], axis=1)))
    if not 200 < height < 3000:
        path = dataset.folder / "new_joints" / f"{clip}.npy"
        raise InvalidFile(path, f"the body is {height:.3g} units tall, expected a person in mm")
    joints = select(KIT.joints, MILLIMETRE * _upright(points), KIT_ML)
    return put_on_floor(resample(joints, fps=KIT_FPS, to=FPS))


def _upright(points: Floats) -> Floats:
    """Reflected where left and right do not fit the toes; moved and turned to start at the origin facing x."""
    place = {name: i for i, name in enumerate(KIT.joints)}
    left = points[:, place["LH"]] - points[:, place["RH"]]
    feet, ankles = ([place[f"{side}{joint}"] for side in "LR"] for joint in "FA")
    toes = (points[:, feet] - points[:, ankles]).sum(axis=1)
    if np.sum(toes[:, 0] * left[:, 1] - toes[:, 1] * left[:, 0]) < 0:
        points = points * (1, -1, 1)
    return face_forward(points, left=[place["LH"], place["LS"]], right=[place["RH"], place["RS"]])
