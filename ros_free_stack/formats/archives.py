"""Arrays of `.npy` and `.npz` files, nothing of which is run."""

from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats.safe_pickle import read_pickle

Array = NDArray[Any]


def load_npz(path: Path) -> dict[str, Array]:
    """The plain arrays of an archive by name; those that hold objects are left out.

    Raises:
        InvalidFile: it is missing, damaged or no archive.
    """
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    found: dict[str, Array] = {}
    try:
        with np.load(path, allow_pickle=False) as archive:
            for name in archive.files:
                try:
                    found[name] = archive[name]
                except ValueError as error:
                    if "Object arrays" not in str(error):
                        raise
    except Exception as error:  # damaged archives raise a dozen kinds of error
        raise InvalidFile(path, f"not a readable .npz ({error})") from None
    return found


def load_npy(path: Path) -> object:
    """The array of a `.npy` file, or the plain data that was saved in one as an object.

    Raises:
        UnsafePickle: the object is no plain data.
        InvalidFile: it is missing, damaged or no array.
    """
    if not path.is_file():
        raise InvalidFile(path, "no such file")
    try:
        with path.open("rb") as stream:
            version = np.lib.format.read_magic(stream)
            read_header = {1: np.lib.format.read_array_header_1_0}.get(version[0], np.lib.format.read_array_header_2_0)
            _, _, dtype = read_header(stream)
            start = stream.tell()
        if not dtype.hasobject:
            return cast(object, np.load(path, allow_pickle=False))
    except Exception as error:  # so do damaged headers
        raise InvalidFile(path, f"not a readable .npy ({error})") from None
    data: Any = read_pickle(path, skip=start)
    return cast(object, data.item()) if isinstance(data, np.ndarray) and data.size == 1 else cast(object, data)
