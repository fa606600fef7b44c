"""Bringing one joint's increments inside limits that the program of all joints did not foresee."""

import numpy as np
import piqp
import scipy.sparse as sp

from retarget.solve.differences import Sparse
from ros_free_stack.messages import Floats

UNIT = 0.1
"""Increments in rad that are one to the solver."""
ROOM = 1e-8
"""What a limit is widened by, in rad, where it is kept: a joint at several of them has no interior otherwise."""
ITERATIONS = 50
"""After which the solver is stuck."""


def repaired(
    values: Floats, cost: Sparse, differences: Sparse, box: tuple[Floats, Floats], limits: tuple[Floats, Floats]
) -> Floats | None:
    """The n increments of a joint within limits that are nearest to `values` (n,); None if the solver found none.

    Only this joint gives way: were all shortened alike, one frame's quick joint would hold up the whole clip.

    Args:
        values: wanted increments.
        cost: (n, n) metric of the distance: the share of this joint in the cost of all.
        differences: (m, n) limited differences of the increments.
        box: (n,) least and greatest increments.
        limits: (m,) least and greatest differences; zero keeps all limits.
    """
    solver = piqp.SparseSolver()
    solver.settings.verbose, solver.settings.max_iter = False, ITERATIONS
    lower, upper = np.minimum(limits[0] - ROOM, 0) / UNIT, np.maximum(limits[1] + ROOM, 0) / UNIT
    rows: Sparse = sp.csc_matrix(differences)
    linear = -(cost @ values) * UNIT
    solver.setup(cost * UNIT**2, linear, None, None, rows, lower, upper, box[0] / UNIT, box[1] / UNIT)
    return UNIT * solver.result.x if solver.solve() == piqp.PIQP_SOLVED else None
