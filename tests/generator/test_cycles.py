"""Turning points of a signal, held against scipy's."""

import numpy as np
from hypothesis import example, given
from hypothesis import strategies as st
from scipy.signal import find_peaks

from generator.probes.cycles import cycles, peaks, rises

LEVELS = st.lists(st.integers(-4, 4), min_size=0, max_size=40)


@given(LEVELS, st.sampled_from([0.0, 0.5, 1.0, 2.0, 3.0]), st.sampled_from([-np.inf, -1.0, 0.0, 2.0]))
@example([0, 1, 1, 0], 1.0, -np.inf)
@example([0, 2, 1, 1, 2, 0], 1.0, -np.inf)
@example([3, 3, 3], 0.0, -np.inf)
def test_peaks_are_scipys_where_values_repeat(levels, prominence, least):
    signal = np.array(levels, float)
    expected = find_peaks(signal, prominence=prominence, height=least)[0]
    np.testing.assert_array_equal(peaks(signal, prominence, least=least), expected)


@given(st.integers(0, 2**32 - 1), st.integers(3, 300), st.floats(0.0, 3.0))
def test_peaks_are_scipys_on_noise(seed, count, prominence):
    signal = np.cumsum(np.random.default_rng(seed).normal(size=count))
    np.testing.assert_array_equal(peaks(signal, prominence), find_peaks(signal, prominence=prominence)[0])


def test_rises_and_cycles_of_a_sine():
    time = np.linspace(0, 3, 301)
    wave = np.sin(2 * np.pi * time)
    assert cycles(wave, 0.5) == 3 and rises(wave, 0.5) == 4, "it ends on its way up"
    assert rises(np.array([2.0, 0.0, 2.0]), 1.0) == 2, "those at the edges count too"
    assert cycles(wave, 3.0) == 0
