"""Mean and standard deviation of features over many rows, exact for any number of them."""

from collections.abc import Callable, Iterable

import numpy as np


def measured(blocks: Callable[[], Iterable[np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    """Two passes over blocks (N, F): the mean, then the deviation from it, so that nothing cancels. Both float32."""
    rows, total = 0, np.zeros(())
    for block in blocks():
        rows, total = rows + len(block), total + block.astype(np.float64).sum(0)
    mean = total / rows
    deviation = np.zeros(())
    for block in blocks():
        deviation = deviation + ((block.astype(np.float64) - mean) ** 2).sum(0)
    return mean.astype(np.float32), np.sqrt(deviation / rows).astype(np.float32)
