"""Arrays of joints' places as models and data sets save them, in `.npy`, `.npz` and `.pkl`.

HumanML3D's (T, 22, 3); joints of SMPL and its successors, of which the first 22 are the same (24, 52, 55 and more);
KIT-ML's (T, 21, 3); flattened (T, 66); with an axis of clips before (`--clip` names one of several); in the order
(J, 3, T) of MDM, whose `results.npy` holds a dictionary with motion, lengths and text.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.archives import load_npy, load_npz
from ros_free_stack.formats.features import KIT
from ros_free_stack.formats.person import Habits, person_source
from ros_free_stack.formats.skeleton_map import KIT_ML, select
from ros_free_stack.formats.smpl_poses import numbers, stated_rate
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import FPS, JOINT_COUNT

SMPL_COUNTS: Final = (22, 24, 45, 49, 52, 55, 73, 76, 118, 127, 137, 144, 165)
"""Numbers of joints that begin with SMPL's: the models and what programs add to them."""

KEYS: Final = ("joints", "joints3d", "joints_3d", "keypoints3d", "positions", "joint_positions", "motion", "xyz")
"""Names of such arrays in archives and dictionaries."""

_OTHERS: Final = {
    17: "joints of COCO or Human3.6M, which lack feet or trunk",
    19: "joints of a pose estimator, which lack feet or trunk",
    25: "joints of OpenPose or NTU, whose order is another one",
    31: "joints of an ASF skeleton",
    251: "features of KIT-ML",
    263: "features of HumanML3D, for the format humanml3d-features",
}


def read(path: Path, options: SourceOptions) -> Source:
    """The human motion in a file of joints' places: usually m, y up, 20 fps.

    Raises:
        InvalidFile: the array has another shape, or is no person.
        InvalidOption: there are several clips and none was named.
    """
    data = load_npz(path) if path.suffix.lower() == ".npz" else load_npy(path)
    return joints_source(path, cast(dict[str, Any], data) if isinstance(data, Mapping) else {"joints": data}, options)


def has_joints(entries: Mapping[str, Any]) -> bool:
    """Whether one of these entries may be joints' places."""
    return any(name in entries and np.ndim(entries[name]) in (3, 4) for name in KEYS)


def joints_source(path: Path, entries: Mapping[str, Any], options: SourceOptions) -> Source:
    """The human motion in entries that `has_joints`."""
    name = next((name for name in KEYS if name in entries), None)
    if name is None:
        raise InvalidFile(path, f"holds {', '.join(map(str, entries)) or 'nothing'}; expected one of {', '.join(KEYS)}")
    clips = _clips(path, numbers(path, entries, name))
    index, notes = _chosen(path, entries, len(clips), options.clip)
    joints = clips[index]
    if "lengths" in entries:
        lengths = numbers(path, entries, "lengths").ravel()
        joints = joints[: int(lengths[index])] if index < len(lengths) else joints
    fps = stated_rate(path, entries)
    if joints.shape[1] == len(KIT.joints):
        habits = Habits(title="KIT-ML joint", up="y", units="mm", fps=12.5)
        return person_source(path, select(KIT.joints, joints, KIT_ML), options, habits, fps=fps, notes=notes)
    habits = Habits(
        title="HumanML3D joint" if joints.shape[1] == JOINT_COUNT else "SMPL joint", up="y", units="m", fps=FPS
    )
    return person_source(path, joints[:, :JOINT_COUNT], options, habits, fps=fps, notes=notes)


def _clips(path: Path, values: Floats) -> Floats:
    """(B, T, J, 3) of an array in any of the known orders of axes; J is 21 or begins with SMPL's 22."""
    counts = (*SMPL_COUNTS, len(KIT.joints))
    shape = values.shape
    if values.ndim in (2, 3) and shape[-1] == 3 * JOINT_COUNT:
        values = values.reshape(*shape[:-1], JOINT_COUNT, 3)
    elif values.ndim in (3, 4) and shape[-2] == 3 and shape[-3] in counts and shape[-1] != 3:
        values = np.moveaxis(values, -1, -3)  # (..., J, 3, T)
    elif values.ndim in (3, 4) and shape[-2] == 3 and shape[-1] in counts:
        values = values.swapaxes(-1, -2)  # (..., T, 3, J)
    if values.ndim == 3:
        values = values[None]
    if values.ndim != 4 or values.shape[-1] != 3 or values.shape[-2] not in counts or not values.size:
        raise InvalidFile(path, f"joints of shape {shape}: {_advice(shape)}")
    return values


def _advice(shape: tuple[int, ...]) -> str:
    known = next((_OTHERS[size] for size in shape[::-1] if size in _OTHERS), None)
    wanted = "expected (T, 22, 3), more joints of SMPL, (T, 21, 3) of KIT-ML, or several such clips"
    return f"these are {known}; {wanted}" if known else wanted


def _chosen(path: Path, entries: Mapping[str, Any], count: int, clip: str | None) -> tuple[int, tuple[str, ...]]:
    """The clip that the user names by its number, and what its text says."""
    if count > 1 and clip is None:
        raise InvalidOption("--clip", f"name one of the {count} clips of {path} by its number: 0 to {count - 1}")
    if clip is not None and clip not in [str(number) for number in range(count)]:
        raise UnknownName(f"clip in {path}", clip, [str(number) for number in range(min(count, 20))])
    index = int(clip or 0)
    texts: Any = entries.get("text", ())
    if isinstance(texts, list | tuple | np.ndarray) and index < len(cast(list[Any], texts)):
        return index, (f"the clip's text: {cast(list[Any], texts)[index]}",)
    return index, ()
