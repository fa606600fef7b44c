"""What the user says about a robot that is being described: some keys of a description, for what stays open."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, get_args

import yaml

from ros_free_stack.errors import InvalidFile, UnknownName
from ros_free_stack.messages import Mount
from ros_free_stack.robots import Attachment
from ros_free_stack.skeleton import INDEX

KEYS = ("root_body", "torso_body", "mount", "attachments")


@dataclass(frozen=True)
class Given:
    """Keys of a description that are not to be proposed."""

    root_body: str | None = None
    torso_body: str | None = None
    mount: Mount | None = None
    attachments: dict[str, Attachment] = field(default_factory=dict[str, Attachment])

    def answers(self, key: str) -> bool:
        """Whether a question about a key of the description has its answer here."""
        section, _, joint = key.partition(".")
        if section != "attachments":
            return getattr(self, section, None) is not None
        return joint in self.attachments if joint else bool(self.attachments)


def read_given(path: Path) -> Given:
    """Read a YAML file with some of a description's keys.

    Raises:
        InvalidFile: it is no such file.
        UnknownName: it has another key, or attaches an unknown human joint.
    """
    try:
        data: dict[str, Any] = yaml.safe_load(path.read_text(encoding="utf-8")) or {}
        for key in data:
            if key not in KEYS:
                raise UnknownName("key", str(key), KEYS)
        mount = data.get("mount")
        if mount is not None and mount not in get_args(Mount):
            raise UnknownName("mount", str(mount), get_args(Mount))
        attachments: dict[str, Attachment] = {}
        for joint, item in data.get("attachments", {}).items():
            if joint not in INDEX:
                raise UnknownName("human joint", str(joint), INDEX)
            x, y, z = (float(value) for value in item.get("offset", (0, 0, 0)))
            attachments[joint] = Attachment(str(item["body"]), (x, y, z))
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InvalidFile(path, f"not a part of a robot description ({type(error).__name__}: {error})") from None
    return Given(data.get("root_body"), data.get("torso_body"), mount, attachments)
