"""Cutting a motion into as many segments as its text has (SegMo, section 3.4), and how far a cut is from the truth.

All methods give the tokens of each segment. "uniform" shares them out evenly; "exact" takes labelled boundaries (past
the paper, whose data have none). "change-point" and "clustering" look at the true motion at the rate of the tokens, so
that they do not depend on a model.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from generator.datasets.layout import layout_of
from generator.models.segmo.config import TOKEN_FRAMES
from generator.training.reconstruction import positions

CLUSTER_STEPS = 10
MIN_CHANGE_TOKENS = 2


def pose_signal(standardised: np.ndarray) -> np.ndarray:
    """(n, D) poses at the rate of the tokens, means of four frames, from standardised features (T, F).

    The D features are root velocities, height and joint positions. Rotations and joint velocities follow from them,
    and with those included the cuts lie further from the truth.
    """
    tokens, poses = len(standardised) // TOKEN_FRAMES, positions(layout_of(standardised.shape[1]).skeleton).stop
    return standardised[: tokens * TOKEN_FRAMES, :poses].reshape(tokens, TOKEN_FRAMES, -1).mean(1).astype(np.float64)


def change_points(signal: np.ndarray, count: int) -> np.ndarray:
    """(A,) lengths of the segments of a signal (n, D) between its `count` - 1 best change points.

    Exact least cost of a Gaussian kernel whose width is the median distance (Celisse et al. 2018, by dynamic
    programming).
    """
    from ruptures import KernelCPD

    shortest = MIN_CHANGE_TOKENS if len(signal) >= MIN_CHANGE_TOKENS * count else 1
    ends = KernelCPD(kernel="rbf", min_size=shortest).fit(signal).predict(n_bkps=count - 1)
    return np.diff(np.array(ends), prepend=0)


def clusters(signal: np.ndarray, count: int) -> np.ndarray:
    """(A,) lengths of contiguous segments of a signal (n, D) after k-means (Lloyd 1982) of its points.

    k-means starts from the means of equal shares. Its clusters follow each other by their mean time, and the cuts are
    those that leave most points in the segment of their own cluster.
    """
    edges = np.arange(count + 1) * len(signal) // count
    centres = np.add.reduceat(signal, edges[:-1]) / np.diff(edges)[:, None]
    label = np.zeros(len(signal), dtype=np.int64)
    for _ in range(CLUSTER_STEPS):
        distance = (centres**2).sum(1) - 2 * signal @ centres.T
        label = distance.argmin(1)
        member = (label[:, None] == np.arange(count)).astype(np.float64)
        size = member.sum(0)[:, None]
        centres = np.where(size > 0, member.T @ signal / np.maximum(size, 1), centres)
    times = np.array([np.flatnonzero(label == j).mean() if (label == j).any() else np.inf for j in range(count)])
    return _contiguous(label, np.argsort(times, kind="stable"))


def _contiguous(label: np.ndarray, order: np.ndarray) -> np.ndarray:
    """(A,) lengths of segments in the `order` of labels that agree with most of the labels (n,); none is empty."""
    tokens, count = len(label), len(order)
    agreeing = np.zeros((count, tokens + 1))
    agreeing[:, 1:] = np.cumsum(label == order[:, None], axis=1)
    best = np.full(tokens + 1, -np.inf)
    best[0] = 0
    cuts = []
    for row in agreeing:
        gain = best - row  # of a segment that starts there
        highest = np.maximum.accumulate(gain)
        first = np.maximum.accumulate(np.where(gain == highest, np.arange(tokens + 1), 0))
        cuts.append(np.concatenate([[0], first[:-1]]))
        best = np.concatenate([[-np.inf], highest[:-1] + row[1:]])
    edges = [tokens]
    for cut in reversed(cuts):
        edges.append(int(cut[edges[-1]]))
    return np.diff(edges[::-1])


METHODS: Final[dict[str, Callable[[np.ndarray, int], np.ndarray]]] = {
    "change-point": change_points,
    "clustering": clusters,
}
"""Segmentations that are searched for in the motion: from a signal (n, D) and the number of segments, 2 to n."""


def boundary_iou(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """(N, A) intersection over union in time of each segment with its true one, from lengths (N, A); 0 on padding."""
    found_ends, true_ends = found.cumsum(1), true.cumsum(1)
    found_starts, true_starts = found_ends - found, true_ends - true
    shared = np.minimum(found_ends, true_ends) - np.maximum(found_starts, true_starts)
    spanned = np.maximum(found_ends, true_ends) - np.minimum(found_starts, true_starts)
    return np.where(true > 0, shared.clip(0) / np.maximum(spanned, 1), 0.0)


def boundary_errors(found: np.ndarray, true: np.ndarray) -> np.ndarray:
    """(M,) distances in tokens of all inner boundaries from the true ones, from lengths (N, A)."""
    inner = true[:, 1:] > 0
    return np.abs(found.cumsum(1) - true.cumsum(1))[:, :-1][inner]
