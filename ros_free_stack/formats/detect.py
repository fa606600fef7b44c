"""Which format a motion file has, by its suffix and content."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, cast

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.formats.catalogue import FORMATS, READABLE
from ros_free_stack.formats.source import SourceOptions
from ros_free_stack.formats.tables import read_table

_BVH: Final = "export BVH (Blender: File, Export, Motion Capture)"
_NUMPY: Final = (
    "save its arrays with numpy.savez, e.g. numpy.savez('clip.npz', **{k: v.numpy() for k, v in data.items()})"
)
_ADVICE: Final = (
    dict.fromkeys((".fbx", ".glb", ".gltf", ".dae", ".usd", ".usda", ".blend", ".vmd", ".anim"), _BVH)
    | dict.fromkeys((".pt", ".pth", ".ckpt", ".safetensors"), _NUMPY)
    | dict.fromkeys((".c3d", ".trc"), "they hold markers, not joints: solve them to a skeleton and export BVH")
    | {".asf": "it is a skeleton: name the .amc file that moves it"}
)
"""What to do with files that are often at hand and not read."""


def detect(path: Path, options: SourceOptions) -> str:
    """The name of a file's format.

    Raises:
        InvalidFile: it is none that can be read; the message lists those.
        InvalidOption: a csv without a named order of quaternions.
    """
    suffix = path.suffix.lower()
    if suffix in _ADVICE:
        raise InvalidFile(path, f"{suffix} files are not read: {_ADVICE[suffix]}")
    if suffix not in _DETECTORS:
        raise _unknown(path, f"suffix {suffix!r}")
    return _DETECTORS[suffix](path, options)


def _unknown(path: Path, seen: str) -> InvalidFile:
    lines = "".join(f"\n  {name:20s}{FORMATS[name].suffix:6s}{FORMATS[name].title}" for name in READABLE)
    return InvalidFile(path, f"of no known format ({seen}); name one with --format:{lines}")


def _npz(path: Path, options: SourceOptions) -> str:
    from ros_free_stack.formats.archives import load_npz
    from ros_free_stack.formats.joint_arrays import has_joints
    from ros_free_stack.formats.robot_arrays import has_robot
    from ros_free_stack.formats.smpl_poses import has_poses

    entries = load_npz(path)
    if "kind" in entries:
        return "native"
    if has_poses(entries):
        return "amass"
    if has_robot(entries):
        return "robot-arrays"
    if has_joints(entries):
        return "humanml3d-joints"
    raise _unknown(path, f"holds {', '.join(sorted(entries)) or 'nothing'}")


def _npy(path: Path, options: SourceOptions) -> str:
    from ros_free_stack.formats.archives import load_npy

    features = np.shape(cast(Any, load_npy(path)))[1:] == (263,)
    return "humanml3d-features" if features else "humanml3d-joints"


def _pkl(path: Path, options: SourceOptions) -> str:
    from ros_free_stack.formats import gmr, mimickit
    from ros_free_stack.formats.phc import clips_of
    from ros_free_stack.formats.robot_arrays import has_robot
    from ros_free_stack.formats.safe_pickle import read_pickle

    data = read_pickle(path)
    entries: dict[Any, Any] = cast(Any, data) if isinstance(data, dict) else {}
    if entries.keys() >= set(gmr.KEYS):
        return "gmr"
    if entries.keys() >= set(mimickit.KEYS):
        return "mimickit"
    if has_robot(entries):
        return "robot-arrays"
    if clips_of(cast(object, data)):
        return "phc"
    raise _unknown(path, f"a pickle of {', '.join(map(str, list(entries)[:20])) or 'no dictionary'}")


def _csv(path: Path, options: SourceOptions) -> str:
    if read_table(path).names:
        return "csv-names"
    if options.quaternion is None:
        raise InvalidOption(
            "--quaternion",
            f"name the order of quaternions in {path}: xyzw (as Unitree writes them) or wxyz (Kimodo, MuJoCo); "
            "nothing in a csv without names of columns tells them apart",
        )
    return "unitree-csv" if options.quaternion == "xyzw" else "kimodo-csv"


def _text(path: Path, options: SourceOptions) -> str:
    try:
        if "Frames" in json.loads(path.read_text(encoding="utf-8")):
            return "deepmimic"
    except (OSError, ValueError, TypeError):
        pass
    raise _unknown(path, "no JSON object with 'Frames'")


_DETECTORS: Final[dict[str, Callable[[Path, SourceOptions], str]]] = {
    ".npz": _npz,
    ".npy": _npy,
    ".bvh": lambda path, options: "bvh",
    ".amc": lambda path, options: "asf-amc",
    ".pkl": _pkl,
    ".csv": _csv,
    ".txt": _text,
    ".json": _text,
}
