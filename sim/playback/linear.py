"""Small systems of equations that are solved once or more in every control cycle."""

from typing import Final

import numpy as np
from scipy.linalg import get_lapack_funcs
from scipy.optimize import nnls

from ros_free_stack.errors import SolverFailed
from ros_free_stack.messages import Floats

_POSV: Final = get_lapack_funcs(["posv"], dtype=float)[0]


def solve_definite(matrix: Floats, right: Floats) -> Floats:
    """x (n,) with matrix x = right, for a symmetric positive definite (n, n) matrix.

    LAPACK's Cholesky solver without the checks of arguments, which take numpy longer than a few equations.

    Raises:
        SolverFailed: the matrix is not positive definite, or no number.
    """
    _, found, status = _POSV(matrix, right)
    if status or not np.isfinite(found.sum()):
        raise SolverFailed("a system of the balance controller", f"LAPACK posv {status}")
    return found


def damped_shares(matrix: Floats, right: Floats, damping: float) -> Floats:
    """x (n,), none below 0, with the least |matrix x - right|^2 + damping^2 |x|^2.

    Where the least squares without bounds have no x below 0 they are the answer, and m equations give them; only
    elsewhere it takes the search for the x that are 0 (Lawson and Hanson's NNLS).

    Args:
        matrix: (m, n), with m far below n.
        right: (m,).
        damping: more than 0.
    """
    rows, columns = matrix.shape
    products = matrix @ matrix.T
    products.flat[:: rows + 1] += damping**2
    free = matrix.T @ solve_definite(products, right)
    if free.min() >= 0:
        return free
    return nnls(np.vstack([matrix, damping * np.eye(columns)]), np.concatenate([right, np.zeros(columns)]))[0]
