"""Stretches of frames in which something holds."""

import numpy as np

from ros_free_stack.messages import Bools


def runs(mask: Bools) -> list[tuple[int, int]]:
    """(start, end) of every run of True."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(int)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
