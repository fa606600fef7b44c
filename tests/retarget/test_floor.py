import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from retarget.clip.floor import put_on_level_floor
from retarget.clip.human import SIDES, align, joint
from ros_free_stack.messages import HumanMotion

ABOVE = 0.7


def walk(heights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Toes (T, 2, 3) that stand in turn at `heights` (K,), 0.6 m apart, and (T, 2) whether they are still."""
    steps, frames = len(heights), 8
    toes = np.zeros((steps * frames, 2, 3))
    still = np.zeros((steps * frames, 2), dtype=bool)
    for k, height in enumerate(heights):
        now = slice(k * frames, (k + 1) * frames)
        toes[now, k % 2] = 0.6 * k, 0.1 - 0.2 * (k % 2), height
        toes[now, 1 - k % 2] = 0.6 * k, 0.2 * (k % 2) - 0.1, height + 0.15
        still[now, k % 2] = True
    return toes, still


@given(st.floats(-1.5, 1.5), st.floats(-1.5, 1.5), st.integers(0, 100))
def test_a_walk_over_a_tilted_floor_is_levelled(pitch, roll, seed):
    toes, still = walk(np.random.default_rng(seed).normal(0, 0.003, 8))
    tilt = Rotation.from_euler("xy", [roll, pitch], degrees=True).as_matrix()
    found = put_on_level_floor(toes @ tilt.T + [0, 0, ABOVE], toes @ tilt.T + [0, 0, ABOVE], still)
    np.testing.assert_allclose(found[still][:, 2], 0, atol=0.012)


def test_steps_and_what_stands_on_an_object_do_not_tilt_the_floor():
    for heights in (np.array([0, 0, 0, 0.2, 0.4, 0.6]), np.array([0, 0, 0.3, 0, 0, 0])):
        toes, still = walk(heights)
        np.testing.assert_allclose(put_on_level_floor(toes, toes, still), toes, atol=0.01)


def test_nothing_stands_under_the_floor():
    toes, still = walk(np.array([0.0, 0.5, 0.5, 0.5, 0.5, 0.5]))
    assert put_on_level_floor(toes, toes, still)[still][:, 2].min() > -0.01


def test_two_feet_in_one_place_say_nothing_of_the_slope():
    toes = np.tile([[0.0, 0.1, 0.0], [0.0, -0.1, 0.01]], (40, 1, 1))
    found = put_on_level_floor(toes, toes, np.ones((40, 2), dtype=bool))
    np.testing.assert_allclose(found, toes, atol=1e-9)


def test_a_motion_without_rest_stands_on_its_lowest_toes():
    toes, still = walk(np.full(6, 0.4))
    found = put_on_level_floor(toes, toes, np.zeros_like(still))
    np.testing.assert_allclose(found[still][:, 2], 0, atol=1e-9)


@pytest.mark.parametrize("degrees", [-1.2, 1.2])
def test_contacts_are_those_of_the_level_motion(motions, degrees):
    level = motions["steps"]
    tilt = Rotation.from_euler("y", degrees, degrees=True).as_matrix()
    joints = np.array(level.joints)
    # Far enough to climb by more than a toe may be above the floor.
    joints[..., 0] *= 4
    tilted, plain = (align(HumanMotion(points, level.fps)) for points in (joints @ tilt.T, joints))
    np.testing.assert_allclose(tilted.contacts, plain.contacts)
    for side in SIDES:
        stands = joint(tilted.joints, f"{side}_foot")[tilted.contacts[:, SIDES.index(side)], 2]
        assert np.abs(stands).max() < 0.035
