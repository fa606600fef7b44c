"""Programs with a solution, and without one: what a solver could not do is counted and never taken for an answer."""

import numpy as np
import pytest

from retarget.solve.frame_program import EQUALITY, SOFT, FrameProgram


def program(lower: list[float], upper: list[float], row: list[float], bound: tuple[float, float]) -> FrameProgram:
    """Nearest (x, y) to (1, 2) within bounds, with one row."""
    hessian, gradient = np.eye(2), np.array([-1.0, -2.0])
    ends = np.array([*upper, bound[1]], dtype=float), np.array([*lower, bound[0]], dtype=float)
    return FrameProgram((hessian, gradient, np.array([row]), *ends), softness=1e-6)


def test_solve_finds_the_nearest_point_within_bounds() -> None:
    found = program([-5, -5], [5, 0.5], [1.0, 0.0], (-9, 9))
    np.testing.assert_allclose(found.solve(), [1.0, 0.5], atol=1e-9)
    assert (found.solved, found.failed) == (1, 0)


def test_mark_makes_a_row_an_equation() -> None:
    found = program([-5, -5], [5, 5], [1.0, 1.0], (1.0, 1.0))
    found.mark(0, np.array([SOFT + EQUALITY]), np.array([1e-7]))
    np.testing.assert_allclose(found.solve(), [0.0, 1.0], atol=1e-5)


def test_solve_gives_way_in_a_soft_row_that_bounds_contradict() -> None:
    found = program([-1, -1], [1, 1], [1.0, 1.0], (5.0, 9.0))
    np.testing.assert_allclose(found.solve(), [1.0, 1.0], atol=1e-6)
    assert found.failed == 0


def test_solve_counts_bounds_that_contradict_each_other() -> None:
    found = program([2, -5], [-2, 5], [1.0, 0.0], (-9, 9))
    np.testing.assert_array_equal(found.solve(), [0.0, 0.0])
    assert (found.solved, found.failed) == (0, 1) and found.status < 0


@pytest.mark.parametrize("place", [0, 1])
def test_solve_counts_what_is_no_number_and_goes_on_after_it(place: int) -> None:
    memory = np.eye(2), np.array([-1.0, -2.0]), np.array([[1.0, 0.0]]), np.full(3, 5.0), np.full(3, -5.0)
    found = FrameProgram(memory, softness=1e-6)
    np.testing.assert_allclose(found.solve(), [1.0, 2.0], atol=1e-9)
    kept = memory[place].copy()
    memory[place].flat[0] = np.nan
    np.testing.assert_array_equal(found.solve(), [0.0, 0.0])
    memory[place][:] = kept
    np.testing.assert_allclose(found.solve(), [1.0, 2.0], atol=1e-9)
    assert (found.solved, found.failed) == (2, 1)
    found.forget()
    assert (found.solved, found.failed, found.status) == (0, 0, 0)


def test_solve_never_takes_the_last_solution_for_one_of_new_bounds() -> None:
    upper, lower = np.full(3, 5.0), np.full(3, -5.0)
    found = FrameProgram((np.eye(2), np.array([-1.0, -2.0]), np.array([[1.0, 0.0]]), upper, lower), softness=1e-6)
    np.testing.assert_allclose(found.solve(), [1.0, 2.0], atol=1e-9)
    upper[0], lower[0] = -2.0, 2.0
    np.testing.assert_array_equal(found.solve(), [0.0, 0.0])
    assert (found.solved, found.failed) == (1, 1)
