import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from retarget.balance.com_plan import Support, balanced_com, nearer, zmp_excess
from retarget.balance.dynamics import Dynamics, whole_body_dynamics
from retarget.body.geometry import measure
from ros_free_stack.errors import SolverFailed
from ros_free_stack.robots import load_robot

FPS = 50.0
NORMALS = np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]])


def box(start: int, end: int, centre: tuple[float, float], half: float) -> Support:
    return Support(start, end, NORMALS, NORMALS @ np.array(centre) + half)


def pendulum(com: np.ndarray, height: float) -> Dynamics:
    acceleration = np.zeros_like(com)
    acceleration[1:-1] = (com[2:] - 2 * com[1:-1] + com[:-2]) * FPS**2
    return Dynamics(np.column_stack([com, np.full(len(com), height)]), com - height / 9.81 * acceleration)


@pytest.mark.parametrize("name", ["op3", "g1"])
def test_the_zmp_of_a_robot_at_rest_is_below_its_centre_of_mass(name):
    geometry = measure(load_robot(name))
    dynamics = whole_body_dynamics(geometry, np.repeat(geometry.standing[None], 5, axis=0), FPS)
    np.testing.assert_allclose(dynamics.zmp, dynamics.centre_of_mass[:, :2], atol=1e-6)


def test_the_zmp_of_an_accelerating_robot_lags_behind_like_a_pendulum():
    geometry = measure(load_robot("op3"))
    qpos = np.repeat(geometry.standing[None], 60, axis=0)
    qpos[:, 0] += 0.5 * (np.arange(60) / FPS) ** 2
    dynamics = whole_body_dynamics(geometry, qpos, FPS)
    middle = dynamics.centre_of_mass[30]
    assert dynamics.zmp[30, 0] - middle[0] == pytest.approx(-middle[2] / 9.81, rel=0.02)


def test_weight_is_shifted_over_the_standing_foot_before_it_is_needed():
    wanted = np.zeros((200, 2))
    areas = [
        box(0, 80, (0.0, 0.0), 0.15),
        box(80, 120, (0.0, 0.1), 0.03),
        box(120, 200, (0.0, 0.0), 0.15),
    ]
    before = pendulum(wanted, 0.3)
    com = balanced_com(before, wanted, areas, FPS)
    assert zmp_excess(before.zmp, areas).max() > 0.05
    assert zmp_excess(pendulum(com, 0.3).zmp, areas).max() < 1e-3
    assert com[78, 1] > 0.02 and abs(com[0, 1]) < 0.02


def test_what_a_sluggish_body_makes_of_the_centre_of_mass_is_learnt():
    wanted = np.zeros((200, 2))
    inner, outer = (
        [box(0, 80, (0, 0), 0.15 * size), box(80, 120, (0, 0.1), 0.03 * size), box(120, 200, (0, 0), 0.15 * size)]
        for size in (0.6, 1.0)
    )

    def outside(*, learnt: bool) -> list[float]:
        found, asked = [], wanted
        for _ in range(4):
            solved = pendulum(gaussian_filter1d(asked, 4.0, axis=0), 0.3)
            found.append(zmp_excess(solved.zmp, outer).max())
            asked = balanced_com(solved, wanted, inner, FPS, asked if learnt else None)
        return found[1:]

    first, *_, last = outside(learnt=True)
    assert first > 2e-3 and last < first / 2
    assert outside(learnt=False)[-1] > 2 * last


def test_a_balanced_motion_stays_as_it_is():
    wanted = np.column_stack([0.02 * np.sin(np.linspace(0, 6, 150)), np.zeros(150)])
    wanted[:3], wanted[-3:] = wanted[3], wanted[-4]
    com = balanced_com(pendulum(wanted, 0.3), wanted, [box(0, 150, (0.0, 0.0), 0.3)], FPS)
    np.testing.assert_allclose(com, wanted, atol=5e-3)


def test_flight_keeps_the_speed_over_the_floor():
    wanted = np.column_stack([np.linspace(0, 0.3, 100), np.zeros(100)])
    areas = [box(0, 40, (0.0, 0.0), 0.15), box(60, 100, (0.3, 0.0), 0.15)]
    com = balanced_com(pendulum(wanted, 0.3), wanted, areas, FPS)
    np.testing.assert_allclose(np.diff(com[41:59, 0], n=2), 0, atol=1e-6)


def test_a_far_shift_is_shortened_as_a_whole_and_a_near_one_is_not():
    here, there = np.zeros((5, 2)), np.linspace([0, 0], [0.3, 0.4], 5)
    np.testing.assert_allclose(nearer(there, here, 0.1), there / 5)
    np.testing.assert_array_equal(nearer(there, here, 0.6), there)


def test_balanced_com_without_a_solution_is_an_error():
    wanted = np.zeros((20, 2))
    before = pendulum(wanted, 0.3)
    wanted[7] = np.nan
    with pytest.raises(SolverFailed, match=r"balance of the centre of mass has no solution .solver status: PIQP"):
        balanced_com(before, wanted, [box(0, 20, (0.0, 0.0), 0.15)], FPS)
