"""The quadratic program of one frame, kept in DAQP from frame to frame.

min 1/2 x'Hx + g'x  with  lower <= x <= upper for the variables, and for rows A x, of which some are soft and some must
be met as equations. DAQP (Arnstrom, Bemporad and Axehill 2022, "A dual active-set solver for embedded quadratic
programming using recursive LDL' updates") goes on from the last program's active set.
"""

from typing import Final

import daqp
import numpy as np

from ros_free_stack.messages import Floats

SOLVED: Final = 1
"""Least exit flag of DAQP with a solution; those of failures are negative."""

NOT_FINITE: Final = -100
"""Our own flag of a solution that is no number."""

EQUALITY, SOFT = 5, 8
"""DAQP's marks of a row."""

Data = tuple[Floats, Floats, Floats, Floats, Floats]
"""H (n, n), g (n,), A (m, n), upper and lower (n + m,): memory that is written anew before each program."""


class FrameProgram:
    """Programs of one pattern, one after the other.

    Attributes:
        solved, failed: how many programs had a solution, and how many had none, since `forget`.
        status: DAQP's exit flag of the last one without.
    """

    def __init__(self, data: Data, softness: float) -> None:
        """Every row is soft by `softness`, the share of a violation that is left, until `mark` says otherwise."""
        self._data = data
        variables, rows = len(data[1]), len(data[3])
        self._sense = np.full(rows, SOFT, dtype=np.int32)
        self._sense[:variables] = 0
        self._softness = np.full(rows, softness)
        self._variables = variables
        self.forget()

    def forget(self) -> None:
        """Begin a new clip: no active set, nothing counted."""
        self._ready, self._changed = False, True
        self.solved = self.failed = self.status = 0

    def mark(self, first: int, sense: np.ndarray, softness: np.ndarray) -> None:
        """From the row `first` on, marks (k,) and softness (k,)."""
        rows = slice(self._variables + first, self._variables + first + len(sense))
        self._sense[rows], self._softness[rows], self._changed = sense, softness, True

    def solve(self) -> Floats:
        """(n,) the solution of the program that the data holds now; zeros where there is none, which is counted."""
        found, status = self._go_on() if self._ready else self._begin()
        if status < SOLVED and self._ready:
            # The last active set can lead astray: once more, from none.
            found, status = self._begin()
        self._ready = status >= SOLVED
        if not self._ready:
            self.failed, self.status = self.failed + 1, status
            return np.zeros(self._variables)
        self.solved += 1
        return found

    def _begin(self) -> tuple[Floats, int]:
        self._program = daqp.Model()
        status, _ = self._program.setup(*self._data, self._sense)
        return self._run(status, soften=True)

    def _go_on(self) -> tuple[Floats, int]:
        # Without the rows' marks DAQP goes on from its last active set.
        changed = (self._sense,) if self._changed else ()
        return self._run(self._program.update(*self._data, *changed), soften=self._changed)

    def _run(self, accepted: int, *, soften: bool) -> tuple[Floats, int]:
        """Solution and exit flag, below `SOLVED` where DAQP refuses the data and would solve the last program."""
        if accepted < 0:
            return self._data[1], accepted
        if soften:
            self._program.soft_weights(rho_l=self._softness, rho_u=self._softness)
            self._changed = False
        found, _, status, _ = self._program.solve()
        # A sum is finite where all its terms are, and costs less than a look at each.
        return found, int(status) if np.isfinite(found.sum()) else NOT_FINITE
