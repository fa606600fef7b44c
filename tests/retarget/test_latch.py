import mujoco
import numpy as np
import pytest

from retarget.body.geometry import measure
from retarget.plan.foothold_update import latch
from retarget.plan.targets import Targets
from ros_free_stack.robots import load_robot

COUNT = 40


@pytest.fixture(scope="module")
def geometry():
    return measure(load_robot("op3"))


@pytest.fixture
def planned(geometry) -> Targets:
    """Both feet stand, but for the left one from frame 15 to 25."""
    data = mujoco.MjData(geometry.model)
    data.qpos[:] = geometry.standing
    mujoco.mj_kinematics(geometry.model, data)
    turns = np.array([data.xmat[foot.body].reshape(3, 3) for foot in geometry.feet])
    soles = [data.xpos[foot.body] + turn @ foot.centre for foot, turn in zip(geometry.feet, turns, strict=True)]
    contacts = np.ones((COUNT, 2), dtype=bool)
    contacts[15:25, 0] = False
    return Targets(
        fps=50.0,
        points=np.zeros((COUNT, len(geometry.followed), 3)),
        rotations=np.tile(np.eye(3), (COUNT, len(geometry.frames), 1, 1)),
        soles=np.tile(soles, (COUNT, 1, 1)),
        sole_rotations=np.tile(turns, (COUNT, 1, 1, 1)),
        contacts=contacts,
        following=np.ones(COUNT),
        scale=1.0,
    )


def test_a_plan_that_is_kept_stays(geometry, planned):
    found = latch(geometry, planned, np.tile(geometry.standing, (COUNT, 1)))
    np.testing.assert_allclose(found.soles, planned.soles, atol=1e-9)
    np.testing.assert_allclose(found.sole_rotations, planned.sole_rotations, atol=1e-9)


def test_stances_move_to_where_feet_stand_and_stay_flat(geometry, planned):
    qpos = np.tile(geometry.standing, (COUNT, 1))
    qpos[20:, 0] += 0.01
    turn = 0.1
    qpos[20:, 3], qpos[20:, 6] = np.cos(turn / 2), np.sin(turn / 2)
    found = latch(geometry, planned, qpos)
    left = found.soles[:, 0] - planned.soles[:, 0]
    np.testing.assert_allclose(left[:15], 0, atol=1e-9)
    assert np.ptp(left[25:], axis=0).max() < 1e-9 and left[-1, 0] < 0.01
    np.testing.assert_allclose(left[:, 2], 0, atol=1e-12)
    assert np.abs(np.diff(left[14:26], axis=0)).max() < 0.3 * np.abs(left[-1]).max()
    yaw = np.arctan2(found.sole_rotations[:, 0, 1, 0], found.sole_rotations[:, 0, 0, 0])
    assert yaw[-1] - yaw[0] == pytest.approx(turn, abs=1e-6)
    np.testing.assert_allclose(found.sole_rotations[:, 0, 2], planned.sole_rotations[:, 0, 2], atol=1e-9)


def test_robots_without_feet_have_nothing_to_latch(geometry, planned):
    held = measure(load_robot("g1_upper"))
    none = Targets(
        planned.fps,
        planned.points,
        planned.rotations,
        np.zeros((COUNT, 0, 3)),
        np.zeros((COUNT, 0, 3, 3)),
        np.zeros((COUNT, 0), dtype=bool),
        planned.following,
        1.0,
    )
    assert latch(held, none, np.tile(held.standing, (COUNT, 1))).soles.shape == (COUNT, 0, 3)
