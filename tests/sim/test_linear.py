"""Small systems of the control cycle: the answers, and what has none."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_free_stack.errors import SolverFailed
from sim.playback.linear import damped_shares, solve_definite


@given(st.integers(0, 2**32 - 1))
def test_solve_definite_solves(seed: int) -> None:
    rng = np.random.default_rng(seed)
    half = rng.normal(size=(4, 4))
    matrix, x = half @ half.T + np.eye(4), rng.normal(size=4)
    np.testing.assert_allclose(solve_definite(matrix, matrix @ x), x, atol=1e-8)


@pytest.mark.parametrize("matrix", [-np.eye(2), np.zeros((2, 2)), np.full((2, 2), np.nan)])
def test_solve_definite_refuses_what_has_no_solution(matrix: np.ndarray) -> None:
    with pytest.raises(SolverFailed, match="LAPACK posv"):
        solve_definite(matrix, np.ones(2))


def test_damped_shares_are_never_below_zero_and_sum_to_the_weight() -> None:
    matrix = np.array([[1.0, 1, 1, 1], [-1, 1, -1, 1], [-1, -1, 1, 1]])
    inside, outside = (damped_shares(matrix, np.array([1.0, x, 0.0]), 1e-4) for x in (0.4, 3.0))
    np.testing.assert_allclose(matrix @ inside, [1.0, 0.4, 0.0], atol=1e-6)
    assert (inside >= 0).all() and (outside >= 0).all() and (outside == 0).any()
