"""Keyed tracks: they pass their keys, rest where told, and do not overshoot."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from generator.corpus.tracks import LinearTrack, Track

TIMES = np.arange(0, 5, 0.01)


def test_rest_to_rest_is_minimum_jerk():
    track = Track(0.0)
    track.move(1.0, (3.0, 2.0))
    s = np.clip((TIMES - 1) / 2, 0, 1)
    np.testing.assert_allclose(track.sample(TIMES)[:, 0], 2 * (10 * s**3 - 15 * s**4 + 6 * s**5), atol=1e-9)


@given(st.lists(st.floats(-2, 2), min_size=1, max_size=6))
def test_track_passes_its_keys_and_stays_near_them(values):
    track = Track(0.0)
    track.move(0.5, *((1.0 + 0.5 * i, value) for i, value in enumerate(values)))
    knots = np.array([1.0 + 0.5 * i for i in range(len(values))])
    np.testing.assert_allclose(track.sample(knots)[:, 0], values, atol=1e-9)
    span = max(0.0, *values) - min(0.0, *values)
    curve = track.sample(TIMES)[:, 0]
    assert curve.max() <= max(0.0, *values) + 0.1 * span + 1e-9
    assert curve.min() >= min(0.0, *values) - 0.1 * span - 1e-9


def test_track_is_constant_before_the_first_and_after_the_last_key():
    track = Track([1.0, -1.0])
    track.move(1.0, (2.0, [0.0, 3.0]))
    np.testing.assert_array_equal(track.sample(np.array([-3.0, 0.0, 1.0, 2.0, 9.0]))[:, 1], [-1, -1, -1, 3, 3])


def test_given_velocity_is_kept():
    track = Track(0.0)
    track.key(1.0, 1.0, velocity=2.5)
    track.key(2.0, 0.0, velocity=0.0)
    before, after = track.sample(np.array([1 - 1e-5, 1 + 1e-5]))[:, 0]
    assert (after - before) / 2e-5 == pytest.approx(2.5, rel=1e-3)


def test_a_later_move_replaces_keys_that_it_cuts_short():
    track = Track(0.0)
    track.move(0.0, (1.0, 5.0), (3.0, 0.0))
    track.move(0.5, (0.8, -1.0))
    assert track.end == pytest.approx(0.8)
    assert track.sample(np.array([4.0]))[0, 0] == pytest.approx(-1.0)


def test_skewed_track_is_reproducible_and_passes_its_keys():
    def make() -> Track:
        track = Track(np.zeros(2), np.random.default_rng(4))
        track.move(0.0, (1.0, [1.0, 1.0]))
        return track

    np.testing.assert_array_equal(make().sample(TIMES), make().sample(TIMES))
    curve = make().sample(TIMES)
    assert np.abs(curve[:, 0] - curve[:, 1]).max() > 1e-3
    np.testing.assert_allclose(make().sample(np.array([0.0, 1.0])), [[0, 0], [1, 1]], atol=1e-9)


def test_linear_track_runs_straight():
    track = LinearTrack(0.5)
    track.key(1.0, 1.0)
    np.testing.assert_allclose(track.sample(np.array([0.0, 0.5, 1.0, 2.0]))[:, 0], [0.5, 0.75, 1.0, 1.0])
