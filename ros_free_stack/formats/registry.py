"""Reading and writing a motion file of any format."""

import importlib
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

from ros_free_stack.errors import InvalidFile, InvalidOption, UnknownName
from ros_free_stack.formats.catalogue import COMMON, FORMATS, READABLE, ROBOT, WRITABLE, Format, Kind
from ros_free_stack.formats.detect import detect
from ros_free_stack.formats.rates import check_rate
from ros_free_stack.formats.source import Source, SourceOptions
from ros_free_stack.messages import HumanMotion, RobotTrajectory

Content = HumanMotion | RobotTrajectory


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
        robots = bool(same_suffix) and all(item.kinds == ROBOT for item in same_suffix)
        format_name = same_suffix[0].name if robots else detect(path, options)
    robot = InvalidFile(path, "holds a robot trajectory, expected human motion; `launch.py convert` takes it")
    if format_name in FORMATS and FORMATS[format_name].kinds == ROBOT:
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


def _function(name: str) -> Callable[..., Any]:
    module, _, function = name.partition(":")
    return getattr(importlib.import_module(f"ros_free_stack.formats.{module}"), function)


def _flag(field: str) -> str:
    return "--" + field.replace("_", "-")
