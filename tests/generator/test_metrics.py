"""The metrics against closed forms: Gaussians with a known distance, perfect, useless and tied embeddings."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import sqrtm
from scipy.special import gamma

from generator.evaluation.metrics import (
    POOL,
    diversity,
    frechet_distance,
    matching_distance,
    mpjpe,
    multimodality,
    r_precision,
)


def spread(points: np.ndarray, mean: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Points with exactly this mean and these standard deviations along the axes, uncorrelated."""
    centred = points - points.mean(axis=0)
    values, vectors = np.linalg.eigh(np.cov(centred, rowvar=False))
    return centred @ vectors / np.sqrt(values) * scale + mean


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10_000), st.floats(0.1, 5.0), st.floats(0.1, 5.0), st.floats(-3.0, 3.0))
def test_frechet_distance_of_gaussians_is_the_closed_form(seed: int, a: float, b: float, shift: float) -> None:
    rng = np.random.default_rng(seed)
    first = spread(rng.normal(size=(60, 4)), np.zeros(4), np.full(4, a))
    second = spread(rng.normal(size=(80, 4)), np.full(4, shift), np.full(4, b))
    assert frechet_distance(first, second) == pytest.approx(4 * shift**2 + 4 * (a - b) ** 2, rel=1e-6, abs=1e-8)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10_000))
def test_frechet_distance_is_the_one_with_the_root_of_the_product(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mix = rng.normal(size=(5, 5))
    first, second = rng.normal(size=(50, 5)), rng.normal(size=(70, 5)) @ mix + rng.normal(size=5)
    covariances = [np.cov(points, rowvar=False) for points in (first, second)]
    root = np.real(sqrtm(covariances[0] @ covariances[1]))
    expected = ((first.mean(0) - second.mean(0)) ** 2).sum() + np.trace(sum(covariances) - 2 * root)
    assert frechet_distance(first, second) == pytest.approx(expected, rel=1e-6)
    assert frechet_distance(second, first) == pytest.approx(expected, rel=1e-6)


def test_equal_sets_have_no_distance_even_where_they_are_flat() -> None:
    points = np.random.default_rng(0).normal(size=(20, 40))  # fewer points than dimensions: a singular covariance
    assert 0 <= frechet_distance(points, points) < 1e-5


def test_perfect_embeddings_are_always_found_and_useless_ones_by_chance() -> None:
    rng = np.random.default_rng(0)
    text = rng.normal(size=(100 * POOL, 8))
    assert r_precision(text, text + 1e-6).tolist() == [1, 1, 1]
    assert r_precision(text, rng.normal(size=text.shape)) == pytest.approx(np.arange(1, 4) / POOL, abs=0.015)


def test_motions_that_are_all_the_same_are_found_by_no_text() -> None:
    text = np.random.default_rng(0).normal(size=(POOL, 8))
    assert r_precision(text, np.zeros((POOL, 8))).tolist() == [0, 0, 0]


def test_two_motions_that_changed_places_are_found_second() -> None:
    text = np.linspace(0, 10 * (2 * POOL - 1), 2 * POOL)[:, None].astype(np.float64)
    motion = text.copy()
    motion[[0, 1]] = motion[[1, 0]] + [[0.1], [0.2]]
    assert r_precision(text, motion)[:2].tolist() == [1 - 2 / (2 * POOL), 1.0]


def test_rows_that_fill_no_pool_do_not_count() -> None:
    text = np.linspace(0, 10 * (POOL + 4), POOL + 5)[:, None].astype(np.float64)
    motion = text.copy()
    motion[POOL:] = -1e6
    assert r_precision(text, motion).tolist() == [1, 1, 1]


def test_distances_of_pairs() -> None:
    rng = np.random.default_rng(0)
    text = rng.normal(size=(50, 4))
    assert matching_distance(text, text + np.array([3, 0, 4, 0])) == pytest.approx(5)
    assert diversity(np.ones((50, 4)), 50, rng) == 0
    assert multimodality(np.repeat(text[:, None], 30, axis=1), 10, rng) == 0
    wide = rng.normal(size=(4000, 16))
    # Two independent standard normal vectors differ by sqrt(2) times a chi variable of 16 degrees of freedom.
    expected = np.sqrt(2) * np.sqrt(2) * gamma(8.5) / gamma(8)
    assert diversity(wide, 4000, rng) == pytest.approx(expected, rel=0.02)


def test_joint_error_is_seen_from_the_root() -> None:
    real = np.random.default_rng(0).normal(size=(10, 22, 3))
    found = real + np.array([5.0, 0, 0])
    assert mpjpe(found, real) == pytest.approx(0)
    found[:, 1:] += [0, 0.022, 0]
    assert mpjpe(found, real) == pytest.approx(0.021)
