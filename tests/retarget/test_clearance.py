import numpy as np
import pytest

from retarget.clearance import Clearance
from retarget.collision import Collision
from retarget.differences import moved
from retarget.geometry import measure
from ros_free_stack.robots import load_robot

STEP = 1e-6


@pytest.fixture(scope="module")
def geometry():
    return measure(load_robot("op3"))


def test_distances_of_all_frames_and_their_derivatives(geometry):
    rng, clearance, collision = np.random.default_rng(0), Clearance(geometry), Collision(geometry)
    qpos = np.tile(geometry.standing, (70, 1))
    qpos[:, geometry.qpos_index] += rng.uniform(-0.4, 0.4, (70, len(geometry.qpos_index)))
    found = clearance(qpos)
    assert len(found.frame) > 100 and (np.diff(found.frame) >= 0).all()
    increments = rng.normal(size=(70, geometry.model.nv))
    ahead, behind = (moved(qpos, sign * STEP * increments) for sign in (1, -1))
    for k in np.unique(found.frame):
        here = found.frame == k
        excess = collision.distances(qpos[k]) - collision.margins
        assert set(found.excess[here].round(9)) <= set(excess.round(9))
        pairs = [int(np.argmin(np.abs(excess - value))) for value in found.excess[here]]
        rate = (collision.distances(ahead[k]) - collision.distances(behind[k])) / (2 * STEP)
        np.testing.assert_allclose(found.jacobian[here] @ increments[k], rate[pairs], atol=1e-4)
