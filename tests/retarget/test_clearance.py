import numpy as np
import pytest

from retarget.body.clearance import NEAR, Clearance
from retarget.body.collision import Collision, capsule_limbs
from retarget.body.geometry import measure
from retarget.solve.differences import moved
from ros_free_stack.robots import load_robot

STEP = 1e-6


@pytest.fixture(scope="module")
def geometry():
    return measure(load_robot("op3"))


def test_distances_of_all_frames_and_their_derivatives(geometry):
    rng, collision = np.random.default_rng(0), Collision(geometry)
    clearance = Clearance(geometry, collision)
    qpos = np.tile(geometry.standing, (70, 1))
    qpos[:, geometry.qpos_index] += rng.uniform(-0.4, 0.4, (70, len(geometry.qpos_index)))
    found = clearance(qpos)
    assert len(found.frame) > 100 and (np.diff(found.frame) >= 0).all()
    increments = rng.normal(size=(70, geometry.model.nv))
    ahead, behind = (moved(qpos, sign * STEP * increments) for sign in (1, -1))
    for k in np.unique(found.frame):
        here = found.frame == k
        distances = collision.distances(qpos[k])
        rates = (collision.distances(ahead[k]) - collision.distances(behind[k])) / (2 * STEP)
        left, limbs = distances - collision.margins, capsule_limbs(geometry)
        each = [np.flatnonzero(limbs == limb) for limb in range(limbs[-1] + 1)]
        nearest = np.array([pairs[left[pairs].argmin()] for pairs in each])
        near = nearest[distances[nearest] < NEAR * geometry.limb_length]
        assert here.sum() == len(near)
        room = [
            distance - margin if distance > margin else min(distance, 0.0)
            for distance, margin in zip(distances[near], collision.margins[near], strict=True)
        ]
        np.testing.assert_allclose(found.room[here], room, atol=1e-9)
        np.testing.assert_allclose(found.jacobian[here] @ increments[k], rates[near], atol=1e-4)
