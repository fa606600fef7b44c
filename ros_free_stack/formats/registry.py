"""Every motion file format: which it is, what a file must be told, and who reads and writes it."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.files import load_motion, load_trajectory, save_motion, save_trajectory
from ros_free_stack.formats.detect import detect
from ros_free_stack.formats.rates import check_rate
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.messages import HumanMotion, RobotTrajectory

Kind = Literal["human motion", "robot trajectory"]
Content = HumanMotion | RobotTrajectory


@dataclass(frozen=True)
class Format:
    """One format.

    Attributes:
        name: as given to `--format` and `--to`.
        title: for people.
        suffix: of its files.
        kinds: what its files may hold.
        read, write: "module:function" below this package, or "" where there is none.
        options: fields of `SourceOptions` that its reader takes.
    """

    name: str
    title: str
    suffix: str
    kinds: tuple[Kind, ...]
    read: str = ""
    write: str = ""
    options: tuple[str, ...] = ()


_HUMAN: Final[tuple[Kind, ...]] = ("human motion",)
_ROBOT: Final[tuple[Kind, ...]] = ("robot trajectory",)
_SIZE: Final = ("units", "height", "up")

COMMON: Final = ("start", "end")
"""Options that every format takes."""

FORMATS: Final = {
    item.name: item
    for item in (
        Format(
            name="native",
            title="this project's own",
            suffix=".npz",
            kinds=_HUMAN + _ROBOT,
            read="registry:read_native",
            write="registry:write_native",
        ),
        Format(
            name="bvh",
            title="BVH: CMU, LaFAN1, SOMA/BONES, Xsens, Mixamo, others with a mapping",
            suffix=".bvh",
            kinds=_HUMAN,
            read="bvh_motion:read",
            write="bvh_motion:write",
            options=("source_fps", *_SIZE, "mapping", "clip"),
        ),
        Format(
            name="asf-amc",
            title="Acclaim ASF/AMC",
            suffix=".amc",
            kinds=_HUMAN,
            read="amc_motion:read",
            options=("source_fps", *_SIZE, "skeleton", "mapping"),
        ),
        Format(
            name="amass",
            title="AMASS: SMPL-H or SMPL-X poses",
            suffix=".npz",
            kinds=_HUMAN,
            read="amass:read",
            options=("source_fps", "up", "skeleton"),
        ),
        Format(
            name="humanml3d-joints",
            title="HumanML3D joints (T, 22, 3)",
            suffix=".npy",
            kinds=_HUMAN,
            read="humanml3d:read_joints",
            options=("source_fps", *_SIZE),
        ),
        Format(
            name="humanml3d-features",
            title="HumanML3D features (T, 263)",
            suffix=".npy",
            kinds=_HUMAN,
            read="humanml3d:read_features",
            options=("source_fps",),
        ),
        Format(
            name="deepmimic",
            title="DeepMimic JSON text",
            suffix=".txt",
            kinds=_HUMAN,
            read="deepmimic:read",
            options=("source_fps",),
        ),
        Format(
            name="phc",
            title="PHC, H2O and ASAP pickles",
            suffix=".pkl",
            kinds=_HUMAN + _ROBOT,
            read="phc:read",
            options=("source_fps", "up", "robot", "clip", "skeleton"),
        ),
        Format(
            name="gmr",
            title="GMR pickle",
            suffix=".pkl",
            kinds=_ROBOT,
            read="gmr:read",
            write="gmr:write",
            options=("source_fps", "robot"),
        ),
        Format(
            name="unitree-csv",
            title="Unitree LAFAN1 csv, quaternions xyzw",
            suffix=".csv",
            kinds=_ROBOT,
            read="robot_csv:read_unitree",
            write="robot_csv:write_unitree",
            options=("source_fps", "robot", "quaternion"),
        ),
        Format(
            name="kimodo-csv",
            title="Kimodo csv, quaternions wxyz",
            suffix=".csv",
            kinds=_ROBOT,
            read="robot_csv:read_kimodo",
            write="robot_csv:write_kimodo",
            options=("source_fps", "robot", "quaternion"),
        ),
        Format(
            name="mjlab",
            title="mjlab and BeyondMimic, with velocities",
            suffix=".npz",
            kinds=_ROBOT,
            write="mjlab:write",
        ),
    )
}
"""By name. Of several that write one suffix the first is what a file of that suffix is written as."""

READABLE: Final = tuple(name for name, item in FORMATS.items() if item.read)
WRITABLE: Final = tuple(name for name, item in FORMATS.items() if item.write)


def load(path: Path, options: SourceOptions, format_name: str | None = None) -> Source:
    """What a motion file holds.

    Args:
        path: the file.
        options: what the user says of it; an option that its format has no use for is an error, not ignored.
        format_name: the format; None recognises it by suffix and content.

    Raises:
        UnknownName: no such format.
        InvalidFile: the file is damaged, or of no known format.
        InvalidOption: something has to be said that was not, or was said in vain.
    """
    if format_name is not None and format_name not in READABLE:
        raise UnknownName("format to read", format_name, READABLE)
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    if options.source_fps is not None:
        check_rate("--source-fps", options.source_fps)
    found = FORMATS[format_name or detect(path, options)]
    for item in fields(options):
        if getattr(options, item.name) is not None and item.name not in (*found.options, *COMMON):
            valid = ", ".join(_flag(name) for name in found.options) or "none"
            raise InvalidOption(_flag(item.name), f"{found.title} has no use for it; options of {found.name}: {valid}")
    source: Source = _function(found.read)(path, options)
    return source


def load_human(
    path: Path, options: SourceOptions, format_name: str | None = None
) -> tuple[HumanMotion, tuple[str, ...]]:
    """The human motion in a file and the reader's notes; InvalidFile where it holds a robot's trajectory."""
    if format_name is None and path.is_file():
        same_suffix = [item for item in FORMATS.values() if item.suffix == path.suffix.lower()]
        robots = bool(same_suffix) and all(item.kinds == _ROBOT for item in same_suffix)
        format_name = same_suffix[0].name if robots else detect(path, options)
    robot = InvalidFile(path, "holds a robot trajectory, expected human motion; `launch.py convert` takes it")
    if format_name in FORMATS and FORMATS[format_name].kinds == _ROBOT:
        raise robot
    source = load(path, options, format_name)
    if isinstance(source.content, RobotTrajectory):
        raise robot
    return source.content, source.notes


def save(path: Path, content: Content, format_name: str | None = None) -> tuple[str, ...]:
    """Write a motion file; gives the writer's notes.

    Raises:
        UnknownName: no such format, or none of that suffix.
        InvalidOption: the format does not hold such content, or goes by another suffix.
    """
    target = output_format(path, format_name)
    kind: Kind = "human motion" if isinstance(content, HumanMotion) else "robot trajectory"
    if kind not in target.kinds:
        valid = ", ".join(name for name in WRITABLE if kind in FORMATS[name].kinds)
        hint = "; `launch.py retarget` makes a robot trajectory of a human motion" if kind == "human motion" else ""
        raise InvalidOption("--to", f"{target.name} cannot hold a {kind}; valid: {valid}{hint}")
    return _function(target.write)(path, content)


def output_format(path: Path, format_name: str | None) -> Format:
    """The format to write, by name or by suffix; UnknownName or InvalidOption where that does not work."""
    if format_name is None:
        by_suffix = [FORMATS[name] for name in WRITABLE if FORMATS[name].suffix == path.suffix.lower()]
        if not by_suffix:
            raise UnknownName("suffix to write", path.suffix, {FORMATS[name].suffix for name in WRITABLE})
        return by_suffix[0]
    if format_name not in WRITABLE:
        raise UnknownName("format to write", format_name, WRITABLE)
    target = FORMATS[format_name]
    if path.suffix.lower() != target.suffix:
        raise InvalidOption("--to", f"{format_name} goes into a {target.suffix} file, found {str(path)!r}")
    return target


def read_native(path: Path, options: SourceOptions) -> Source:
    """This project's own file of either kind."""
    try:
        with np.load(path, allow_pickle=False) as archive:
            kind = str(archive["kind"])
    except Exception:  # the reader of motions says what is wrong
        kind = "human_motion"
    return Source(load_trajectory(path) if kind == "robot_trajectory" else load_motion(path))


def write_native(path: Path, content: Content) -> tuple[str, ...]:
    """This project's own file."""
    if isinstance(content, HumanMotion):
        save_motion(path, content)
    else:
        save_trajectory(path, content)
    return ()


def _function(name: str) -> Callable[..., Any]:
    module, _, function = name.partition(":")
    return getattr(importlib.import_module(f"ros_free_stack.formats.{module}"), function)


def _flag(field: str) -> str:
    return "--" + field.replace("_", "-")
