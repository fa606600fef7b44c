"""Joining of motions: exact on motion that fits, smooth where it does not, rigid on what is given."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.postprocess.stitch import BLEND, Floats, placed, stitch


def smooth_motion(frames: int, seed: int) -> Floats:
    rng = np.random.default_rng(seed)
    times = np.arange(frames)[:, None, None] / 20
    return rng.normal(size=(1, 22, 3)) + 0.1 * np.sin(2 * times + rng.uniform(0, 6, (1, 22, 3)))


@settings(max_examples=30, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(-5, 5), st.floats(-5, 5))
def test_placing_undoes_a_move_over_the_floor(angle: float, x: float, y: float) -> None:
    motion = smooth_motion(30, 0)
    c, s = np.cos(angle), np.sin(angle)
    moved = motion.copy()
    moved[..., :2] = motion[..., :2] @ np.array([[c, s], [-s, c]]) + [x, y]
    np.testing.assert_allclose(placed(moved, moved[:8], motion[:8]), motion, atol=1e-9)


def test_a_window_that_fits_stays_as_it_is() -> None:
    motion = smooth_motion(60, 1)
    middle, after = stitch(motion[:20], motion, motion[40:])
    np.testing.assert_allclose(middle, motion[20:40], atol=1e-9)
    np.testing.assert_allclose(after, motion[40:], atol=1e-9)


@pytest.mark.parametrize("frames", [4, 8, 40])
def test_place_and_velocity_are_continuous_at_both_joints(frames: int) -> None:
    """A window of other poses: at the joints no step exceeds the steps of the motions by more than its easing."""
    given_motion, window = smooth_motion(40 + frames, 2), smooth_motion(40 + frames, 2) + 0.03
    window += 0.02 * np.sin(np.arange(len(window)) / 9)[:, None, None]
    middle, after = stitch(given_motion[:20], window, given_motion[-20:])
    whole = np.concatenate([given_motion[:20], middle, after])
    steps = np.linalg.norm(np.diff(whole, axis=0), axis=-1).max(axis=1)
    smooth = np.linalg.norm(np.diff(given_motion, axis=0), axis=-1).max()
    assert steps.max() < smooth + 0.04
    bends = np.abs(np.diff(whole, n=2, axis=0)).max(axis=(1, 2))
    assert bends[[18, 18 + frames]].max() < 0.03


def test_only_the_blend_differs_from_the_window() -> None:
    before, window = smooth_motion(20, 3), smooth_motion(60, 4)
    middle, _ = stitch(before, window, window[:0])
    expected = placed(window, window[:20], before)
    np.testing.assert_allclose(middle[BLEND:], expected[20 + BLEND :], atol=1e-12)
