"""The metrics of text-to-motion (Guo et al., CVPR 2022, section 5), on embeddings of texts and motions, and MPJPE."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

Floats = NDArray[np.float64]

POOL = 32
"""A motion's own text is looked for among this many texts."""


def r_precision(text: Floats, motion: Floats, *, top: int = 3) -> Floats:
    """(top,) share of the texts whose own motion is among the 1, 2, ... nearest of its pool, by Euclidean distance.

    Args:
        text, motion: (N, E) embeddings of matching pairs, N at least 32; pools are successive rows, and rows that
            do not fill a pool are left out, as in the published protocol.
    """
    places = np.concatenate([_places(text[rows], motion[rows]) for rows in _pools(len(text))])
    return np.array([(places < count).mean() for count in range(1, top + 1)])


def _places(text: Floats, motion: Floats) -> NDArray[np.int64]:
    """(32,) place, from 0, of each text's own motion; one that ties with another comes after it."""
    distance = cdist(text, motion)
    own = np.diag(distance)[:, None]
    return (distance <= own).sum(axis=1) - 1


def _pools(count: int) -> list[slice]:
    return [slice(start, start + POOL) for start in range(0, count - POOL + 1, POOL)]


def matching_distance(text: Floats, motion: Floats) -> float:
    """MM-Dist: mean Euclidean distance of the matching pairs (N, E)."""
    return float(np.linalg.norm(text - motion, axis=1).mean())


def frechet_distance(real: Floats, other: Floats) -> float:
    """FID between two sets of embeddings, (N, E) and (M, E), each taken as a Gaussian.

    |m1 - m2|^2 + tr(C1 + C2 - 2 (C1 C2)^(1/2)). The trace of the root is the sum of the roots of the eigenvalues of
    A C2 A, with A the root of C1, which needs no root of a matrix that is not symmetric.
    """
    mean = real.mean(axis=0) - other.mean(axis=0)
    first, second = np.cov(real, rowvar=False), np.cov(other, rowvar=False)
    values, vectors = np.linalg.eigh(first)
    root = (vectors * np.sqrt(np.maximum(values, 0.0))) @ vectors.T
    mixed = np.linalg.eigvalsh(root @ second @ root)
    distance = mean @ mean + np.trace(first) + np.trace(second) - 2 * np.sqrt(np.maximum(mixed, 0.0)).sum()
    return max(0.0, float(distance))  # equal sets come out a rounding error below zero


def diversity(motion: Floats, pairs: int, rng: np.random.Generator) -> float:
    """Mean distance of `pairs` random pairs of the embeddings (N, E), N at least `pairs`."""
    first, second = (rng.choice(len(motion), pairs, replace=False) for _ in range(2))
    return float(np.linalg.norm(motion[first] - motion[second], axis=1).mean())


def multimodality(motion: Floats, pairs: int, rng: np.random.Generator) -> float:
    """Mean distance of `pairs` random pairs among the motions of one text; (texts, samples, E)."""
    first, second = (rng.choice(motion.shape[1], pairs, replace=False) for _ in range(2))
    return float(np.linalg.norm(motion[:, first] - motion[:, second], axis=2).mean())


def mpjpe(found: Floats, real: Floats) -> float:
    """Mean joint position error in m of two motions (T, J, 3), each seen from its own root (joint 0)."""
    return float(np.linalg.norm((found - found[:, :1]) - (real - real[:, :1]), axis=-1).mean())
