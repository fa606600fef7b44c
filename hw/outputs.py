"""Files that a command will write, checked before anything moves."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from ros_free_stack.errors import InvalidFile, InvalidOption


def check_output(option: str, path: Path, *, inputs: Mapping[str, Path | None], size: int = 0) -> None:
    """See to it that a file can be written where `path` says, and is none that was read.

    Args:
        option: that names it, for messages.
        path: of the file to be.
        inputs: name and path of each file that the command reads.
        size: bytes that it will take at most.

    Raises:
        InvalidOption: it is one of the inputs.
        InvalidFile: it is a folder, or its folder takes no file of that size.
    """
    for name, other in inputs.items():
        if other is not None and (path.absolute() == other.absolute() or (path.exists() and path.samefile(other))):
            raise InvalidOption(option, f"{path} is the {name.removeprefix('--')} that is read: name another file")
    if path.is_dir():
        raise InvalidFile(path, "is a folder, expected the name of a file")
    if path.exists() and not os.access(path, os.W_OK):
        raise InvalidFile(path, "cannot be written: Permission denied")
    try:
        with tempfile.TemporaryFile(dir=path.parent) as file:
            if size and hasattr(os, "posix_fallocate"):
                os.posix_fallocate(file.fileno(), 0, size)
    except OSError as error:
        raise InvalidFile(path, f"cannot be written ({size} bytes): {error.strerror}") from None
