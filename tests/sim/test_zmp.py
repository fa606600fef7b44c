"""The zero moment point against closed forms."""

import mujoco
import numpy as np
import pytest

from ros_free_stack.robot_model import kinematic_model, standing_qpos
from sim.judge.zmp import zero_moment_point

BALL = """
<mujoco><worldbody><body pos="0 0 0.8"><freejoint/><geom size="0.05" mass="2"/></body></worldbody></mujoco>
"""
WHEEL = """
<mujoco><worldbody><body pos="0 0 0.8"><freejoint/>
<inertial pos="0 0 0" mass="2" diaginertia="0.3 0.3 0.3"/></body></worldbody></mujoco>
"""
FPS = 100.0


def path(count: int) -> np.ndarray:
    return np.tile([0, 0, 0.8, 1, 0, 0, 0.0], (count, 1))


def test_standing_zmp_is_below_the_centre_of_mass(op3):
    model = kinematic_model(op3)
    qpos = standing_qpos(model, op3)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_fwdPosition(model, data)
    zmp = zero_moment_point(model, np.tile(qpos, (30, 1)), FPS)
    assert np.allclose(zmp, data.subtree_com[0, :2], atol=1e-9)


@pytest.mark.parametrize("acceleration", [1.0, -3.0])
def test_cart_and_table(acceleration):
    """x_zmp = x - z a / g for a point mass that accelerates along x (Kajita et al. 2003)."""
    model = mujoco.MjModel.from_xml_string(BALL)
    times = np.arange(200) / FPS
    qpos = path(200)
    qpos[:, 0] = 0.5 * acceleration * times**2
    zmp = zero_moment_point(model, qpos, FPS)
    middle = slice(30, 170)
    assert np.allclose(zmp[middle, 0], qpos[middle, 0] - 0.8 * acceleration / 9.81, atol=2e-3)
    assert np.allclose(zmp[middle, 1], 0, atol=1e-6)


def test_spinning_up_shifts_it():
    """A body that spins up about y needs the moment I alpha: x_zmp = -I alpha / (m g)."""
    model = mujoco.MjModel.from_xml_string(WHEEL)
    times, alpha = np.arange(200) / FPS, 2.0
    half = 0.25 * alpha * times**2
    qpos = path(200)
    qpos[:, 3], qpos[:, 5] = np.cos(half), np.sin(half)
    zmp = zero_moment_point(model, qpos, FPS)
    assert np.allclose(zmp[30:170, 0], -0.3 * alpha / (2 * 9.81), atol=1e-3)


def test_free_fall_has_none():
    model = mujoco.MjModel.from_xml_string(BALL)
    qpos = path(100)
    qpos[:, 2] = 5 - 0.5 * 9.81 * (np.arange(100) / FPS) ** 2
    assert np.isnan(zero_moment_point(model, qpos, FPS)[20:80]).all()


def test_one_frame():
    assert np.allclose(zero_moment_point(mujoco.MjModel.from_xml_string(BALL), path(1), FPS), [[0, 0]])
