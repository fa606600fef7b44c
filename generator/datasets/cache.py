"""Where what is computed of a data set is kept: in its folder, or in the user's cache where that is read-only."""

import hashlib
import os
from pathlib import Path

from platformdirs import user_cache_path


def cache_path(folder: Path, name: str) -> Path:
    """The file of that name that belongs to a data set's folder; it need not exist yet."""
    if (folder / name).exists() or os.access(folder, os.W_OK):
        return folder / name
    place = hashlib.sha256(str(folder.resolve()).encode()).hexdigest()[:16]
    path = user_cache_path("ros-free-stack") / "datasets" / place
    path.mkdir(parents=True, exist_ok=True)
    return path / name
