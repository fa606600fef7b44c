"""Reads a description from YAML: what is missing, unknown or contradictory is refused by name."""

import hashlib
from collections.abc import Collection
from importlib import resources
from pathlib import Path
from typing import Any, get_args

import yaml

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.menagerie import menagerie_folder
from ros_free_stack.messages import Mount
from ros_free_stack.robots.description import Attachment, Capsule, JointLimits, RobotDescription, Sole
from ros_free_stack.robots.servos import read_servos
from ros_free_stack.skeleton import INDEX


def read_description(path: Path) -> RobotDescription:
    """Read a description file; InvalidFile where a field is missing or wrong."""
    try:
        text = path.read_text(encoding="utf-8")
        data = yaml.safe_load(text)
        model_path = _model_path(data["model"], path)
        capsules = _capsules(data.get("capsules", {}))
        mount: Mount = data.get("mount", "free")
        if mount not in get_args(Mount):
            raise UnknownName("mount", str(mount), get_args(Mount))
        soles = _soles(data.get("soles", {}))
        _check_support(mount, soles)
        return RobotDescription(
            name=data["name"],
            title=data["title"],
            path=path,
            model_path=model_path,
            mount=mount,
            root_body=data["root_body"],
            torso_body=data["torso_body"],
            torso_lean=float(data["torso_lean"]),
            attachments=_attachments(data["attachments"]),
            soles=soles,
            capsules=capsules,
            collision_pairs=_collision_pairs(data.get("collision_pairs", {}), capsules),
            joints=_joints(data["joints"]),
            locked=_angles(data.get("locked", {})),
            limits_source=data["limits_source"],
            standing=_angles(data.get("standing", {})),
            servos=read_servos(data, data["joints"]),
            sha256=hashlib.sha256(model_path.read_bytes() + text.encode()).hexdigest(),
        )
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InvalidFile(path, f"not a valid robot description ({_problem(error)})") from None


def _problem(error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return f"no such file: {error.filename}"
    if isinstance(error, KeyError):
        return f"the entry {error} is missing"
    if isinstance(error, yaml.MarkedYAMLError):
        line = "" if error.problem_mark is None else f" in line {error.problem_mark.line + 1}"
        return f"not YAML: {error.problem}{line}"
    return f"{type(error).__name__}: {error}".splitlines()[0]


def _check_support(mount: Mount, soles: dict[str, Sole]) -> None:
    if mount == "free" and not soles:
        raise ValueError("a robot without soles cannot stand: describe its soles, or say mount: fixed")
    if mount == "fixed" and soles:
        raise ValueError("a robot with mount: fixed is held by its root and has no soles: leave them out")


def _model_path(model: dict[str, str], description: Path) -> Path:
    if "package" in model:
        return Path(str(resources.files(model["package"]))) / model["file"]
    if "menagerie" in model:
        return menagerie_folder(model["menagerie"]) / model["file"]
    return (description.parent / model["file"]).resolve()


def _triple(values: list[Any]) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in values)
    return x, y, z


def _angles(data: dict[str, Any]) -> dict[str, float]:
    return {joint: float(value) for joint, value in data.items()}


def _attachments(data: dict[str, Any]) -> dict[str, Attachment]:
    for joint in data:
        if joint not in INDEX:
            raise UnknownName("human joint", joint, INDEX)
    return {joint: Attachment(item["body"], _triple(item.get("offset", [0, 0, 0]))) for joint, item in data.items()}


def _soles(data: dict[str, Any]) -> dict[str, Sole]:
    return {
        foot: Sole(item["body"], tuple(_triple(corner) for corner in item["corners"]), item["ankle"])
        for foot, item in data.items()
    }


def _capsules(data: dict[str, Any]) -> dict[str, tuple[Capsule, ...]]:
    return {
        body: tuple(Capsule(_triple(item["start"]), _triple(item["end"]), float(item["radius"])) for item in items)
        for body, items in data.items()
    }


def _collision_pairs(data: dict[str, Any], bodies: Collection[str]) -> tuple[tuple[str, str], ...]:
    pairs = tuple((first, second) for first, others in data.items() for second in others)
    for body in dict.fromkeys(name for pair in pairs for name in pair):
        if body not in bodies:
            raise UnknownName("body with capsules", body, tuple(bodies))
    return pairs


def _joints(data: dict[str, Any]) -> dict[str, JointLimits]:
    return {
        joint: JointLimits(
            lower=float(item["range"][0]),
            upper=float(item["range"][1]),
            velocity=float(item["velocity"]),
            acceleration=float(item["acceleration"]),
            effort=float(item["effort"]),
        )
        for joint, item in data.items()
    }
