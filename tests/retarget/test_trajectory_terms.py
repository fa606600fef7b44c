import mujoco
import numpy as np
import pytest

from retarget.body.frame_batch import CHUNK, BatchFunction
from retarget.body.geometry import measure
from retarget.solve.differences import moved
from retarget.solve.trajectory_terms import trajectory_terms
from ros_free_stack.robots import load_robot

COUNT = CHUNK + 6
STEP = 1e-6


@pytest.fixture(scope="module")
def geometry():
    return measure(load_robot("op3"))


@pytest.fixture(scope="module")
def problem(geometry):
    rng = np.random.default_rng(0)
    qpos = np.tile(geometry.standing, (COUNT, 1))
    qpos[:, geometry.qpos_index] += rng.uniform(-0.5, 0.5, (COUNT, len(geometry.qpos_index)))
    feet, followed, frames = len(geometry.feet), len(geometry.followed), len(geometry.frames)
    inputs = {
        "points": rng.normal(size=(COUNT, followed, 3)),
        "rotations": np.tile(np.eye(3).ravel(), (COUNT, frames, 1)),
        "soles": rng.normal(size=(COUNT, feet, 3)),
        "sole_rotations": np.tile(np.eye(3).ravel(), (COUNT, feet, 1)),
        "com": rng.normal(size=(COUNT, 1, 2)),
        "sole_weights": rng.uniform(1, 3, (COUNT, feet, 2)),
        "com_weight": np.full((COUNT, 1, 1), 2.0),
    }
    return BatchFunction(trajectory_terms(geometry)), qpos, inputs


def test_the_gradient_is_the_slope_of_the_cost(problem, geometry):
    function, qpos, inputs = problem
    increments = np.random.default_rng(1).normal(size=(COUNT, geometry.model.nv))
    costs = [
        function({"qpos": moved(qpos, sign * STEP * increments)[:, None], **inputs})["cost"][:, 0, 0]
        for sign in (1, -1)
    ]
    slope = (costs[0] - costs[1]) / (2 * STEP)
    gradient = function({"qpos": qpos[:, None], **inputs})["gradient"][:, 0]
    # The rotation error's Jacobian is exact at no error only.
    np.testing.assert_allclose(2 * (gradient * increments).sum(axis=1), slope, rtol=0.1, atol=1.0)


def test_heights_and_centre_of_mass_agree_with_mujoco(problem, geometry):
    function, qpos, inputs = problem
    found = function({"qpos": qpos[:, None], **inputs})
    data = mujoco.MjData(geometry.model)
    for k in (0, CHUNK - 1, CHUNK, COUNT - 1):
        data.qpos[:] = qpos[k]
        mujoco.mj_kinematics(geometry.model, data)
        mujoco.mj_comPos(geometry.model, data)
        heights = [
            (data.xpos[foot.body] + foot.corners @ data.xmat[foot.body].reshape(3, 3).T)[:, 2] for foot in geometry.feet
        ]
        np.testing.assert_allclose(found["height"][k, 0], np.concatenate(heights), atol=1e-9)
        np.testing.assert_allclose(found["centre_of_mass"][k, 0], data.subtree_com[0], atol=1e-9)
