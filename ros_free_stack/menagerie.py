"""MuJoCo Menagerie's robots by name, through its own package, which downloads a model on first use."""

from pathlib import Path
from typing import Any

from ros_free_stack.errors import InvalidFile, MissingDependency, UnknownName

PREFIX = "menagerie:"


def menagerie_names() -> tuple[str, ...]:
    """Names of all robots of MuJoCo Menagerie; needs its package, not the network."""
    return tuple(_package().names())


def menagerie_folder(name: str) -> Path:
    """The folder of a robot's model, downloaded where it is not in the cache.

    Raises:
        MissingDependency: the package is not installed.
        UnknownName: no such robot; lists the known ones.
        InvalidFile: it is neither in the cache nor can be downloaded.
    """
    package = _package()
    if name not in package.names():
        raise UnknownName("Menagerie robot", name, package.names())
    try:
        return Path(package.get(name).path(progress=None))
    except (package.MenagerieError, OSError) as error:
        reason = " ".join(str(error).split())
        raise InvalidFile(
            f"{PREFIX}{name}", f"not in the cache and cannot be downloaded ({reason}): give the path of its MJCF file"
        ) from None


def menagerie_model(name: str) -> Path:
    """The MJCF file of a robot's own model, without a scene around it; errors as of `menagerie_folder`."""
    folder = menagerie_folder(name)
    robot = _package().get(name)
    return folder / robot.entry(robot.default_model).file


def _package() -> Any:
    try:
        import mujoco_menagerie  # pyright: ignore[reportMissingImports, reportMissingTypeStubs]
    except ImportError:
        raise MissingDependency(
            "the package mujoco-menagerie", "pip install 'ros-free-stack[menagerie]', or give the path of an MJCF file"
        ) from None
    return mujoco_menagerie
