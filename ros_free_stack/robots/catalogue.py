"""Which robots there are: those described here, and the user's own in a folder."""

import os
from importlib import resources
from pathlib import Path

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.robots.description import RobotDescription
from ros_free_stack.robots.reader import read_description

FOLDER = "robots"
FOLDER_VARIABLE = "RFS_ROBOTS"


def user_folder() -> Path:
    """Where the user's own descriptions are: the folder that RFS_ROBOTS names, else `robots` where one works."""
    return Path(os.environ.get(FOLDER_VARIABLE) or FOLDER)


def robot_files() -> dict[str, Path]:
    """Name to description file of every robot, by name.

    Raises:
        InvalidFile: a file of the user has the name of a robot that is described here.
    """
    own = _described(Path(str(resources.files("ros_free_stack") / "robots")))
    users = _described(user_folder())
    for name in own.keys() & users.keys():
        raise InvalidFile(users[name], f"a robot named {name} is described already: rename the file")
    return dict(sorted((own | users).items()))


def robot_names() -> tuple[str, ...]:
    """Names of all robots, described here or by the user."""
    return tuple(robot_files())


def load_robot(name: str) -> RobotDescription:
    """The description of a robot by name, or by the path of its file (.yaml).

    Raises:
        UnknownName: no such robot; lists the known ones.
        InvalidFile: its description or model file is damaged, or the file is named otherwise than the robot.
    """
    if name.endswith((".yaml", ".yml")):
        return read_description(Path(name))
    files = robot_files()
    if name not in files:
        raise UnknownName("robot", name, files)
    robot = read_description(files[name])
    if robot.name != name:
        raise InvalidFile(files[name], f"describes a robot named {robot.name!r}: file and robot must have one name")
    return robot


def _described(folder: Path) -> dict[str, Path]:
    return {path.stem: path for path in folder.glob("*.yaml")} if folder.is_dir() else {}
