"""The quadratic program of a stretch of frames, in the banded form that PIQP's multistage solver factorises.

Variables are the frames' increments d_k (nv,), each followed by a slack s_k that frees the frame's soft rows:
    min  sum_k  1/2 d_k'H_k d_k + g_k'd_k + 1/2 p s_k^2  +  1/2 sum_c |a_c + (D d)_c|^2_w
    with  low_k <= d_k <= high_k,   l_k <= R_k d_k + s_k,
          |v_e + (V d)_e| <= step,  |a_c + (D d)_c| <= change     for joints that come near these limits,
where v and a are first and second differences of the trajectory. Frames are coupled joint by joint only, and over three
frames, so the matrix of every interior-point step is banded in blocks of nv + 1 (Schwan, Jiang, Kuhn and Jones 2023,
"PIQP: a proximal interior-point quadratic programming solver", whose multistage backend factorises it).
"""

from dataclasses import dataclass

import numpy as np
import piqp
import scipy.sparse as sp

from retarget.solve.differences import Sparse, Stretch
from retarget.solve.joint_repair import repaired
from ros_free_stack.messages import Bools, Floats

SLACK_PRICE = 1e6
"""The price p: a soft row gives way by micrometres, unless it has to."""
TOLERANCE, GAP = 3e-6, 1e-2
"""Largest residuals of the conditions of optimality, and relative duality gap: the next program starts where this one
ended, so only what is left of the rows counts."""
UNIT = 0.1
"""Increments in rad or m that are one to the solver: its first guess then lies about as far from the bounds as they
are."""
STUCK = 60
"""Iterations after which the solver has lost its way."""
FRACTION = 0.999
"""Share of the way to the nearest bound that an iteration may go."""
WATCHED = 0.25
"""Share of a limited difference's range, from either end, in which a row for it is added when a joint missed one."""
UNUSED = -1.0
"""Lower bound of a soft row that holds nothing."""


@dataclass(frozen=True)
class Quadratic:
    """Frame by frame costs: `hessian` (n, nv, nv) and `gradient` (n, nv)."""

    hessian: Floats
    gradient: Floats


@dataclass(frozen=True)
class SoftRows:
    """R rows `jacobian` (R, nv) @ d_k >= `lower` (R,) of the frames k = `frame` (R,), sorted by frame."""

    frame: np.ndarray
    jacobian: Floats
    lower: Floats


@dataclass(frozen=True)
class LimitedDifferences:
    """Ranges (2n + 5, J) of what increments add to steps, then to changes of step, and which are `near` their ends."""

    lower: Floats
    upper: Floats
    near: Bools


class TrajectoryQP:
    """Programs of one stretch with a common pattern, which grows where more rows come near their limits.

    Attributes:
        iterations: of the interior point in the last program.
    """

    def __init__(self, stretch: Stretch, dofs: np.ndarray, smoothness: Floats) -> None:
        """`dofs` (J,) have limits; `smoothness` (nv,) are the weights w."""
        self._count, self._nv, self._dofs = len(stretch), len(smoothness), dofs
        first, self._second = stretch.operators()
        self._limited: Sparse = sp.vstack([first, self._second], format="csr")
        self._coupling: Sparse = (self._second.T @ self._second).tocsr()
        self._smoothness = smoothness
        self._cost = self._cost_pattern()
        self._near = np.zeros((self._limited.shape[0], len(dofs)), dtype=bool)
        self._slots = np.zeros(self._count, dtype=int)
        self._missed = np.zeros_like(self._near)
        self._solver: piqp.SparseSolver | None = None
        self.iterations = 0

    def solve(
        self,
        cost: Quadratic,
        changes: Floats,
        box: tuple[Floats, Floats],
        soft: SoftRows,
        limits: LimitedDifferences,
    ) -> Floats | None:
        """Increments (n, nv) of least cost; joints that would exceed a limit that was not foreseen are repaired.

        None if the solver found none.

        Args:
            cost: of each frame.
            changes: (n + 2, nv) present changes of step.
            box: (n, nv) lower and upper bounds of the increments.
            soft: rows of single frames.
            limits: of steps and changes of step.
        """
        matrix = self._cost.filled(self._cost_values(cost.hessian) * UNIT**2)
        pull = self._second.T @ (changes * self._smoothness)
        linear = self._stacked(cost.gradient + pull, 0.0) * UNIT
        low, high = self._stacked(box[0], -np.inf) / UNIT, self._stacked(box[1], np.inf) / UNIT
        grown, solver = self._grow(limits.near | self._missed, soft), self._solver
        rows, lower, upper = self._rows_filled(soft, limits)
        lower, upper = lower / UNIT, upper / UNIT
        if grown or solver is None:
            solver = self._solver = _solver()
            solver.setup(matrix, linear, None, None, rows, lower, upper, low, high)
        else:
            solver.update(P=matrix, c=linear, G=rows, h_l=lower, h_u=upper, x_l=low, x_u=high)
        status = solver.solve()
        self.iterations = int(solver.result.info.iter)
        if status != piqp.PIQP_SOLVED:
            return None
        values = UNIT * solver.result.x.reshape(self._count, self._nv + 1)[:, : self._nv]
        return self._within(values, cost, box, limits)

    def _within(
        self, values: Floats, cost: Quadratic, box: tuple[Floats, Floats], limits: LimitedDifferences
    ) -> Floats:
        """Increments that keep limits that had no rows; the next program has rows where repaired joints come near.

        Where a joint cannot be repaired all increments are shortened.
        """
        differences = self._limited @ values[:, self._dofs]
        exceeded = ~self._near & ((differences < limits.lower) | (differences > limits.upper))
        joints = np.flatnonzero(exceeded.any(axis=0))
        for joint, dof in zip(joints, self._dofs[joints], strict=True):
            metric: Sparse = sp.diags(cost.hessian[:, dof, dof]) + self._smoothness[dof] * self._coupling
            bounds, own = (box[0][:, dof], box[1][:, dof]), (limits.lower[:, joint], limits.upper[:, joint])
            found = repaired(values[:, dof], metric.tocsc(), self._limited, bounds, own)
            if found is not None:
                values[:, dof] = found
        differences = self._limited @ values[:, self._dofs]
        left = np.minimum(differences - limits.lower, limits.upper - differences)
        self._missed = exceeded.any(axis=0) & (left < WATCHED * (limits.upper - limits.lower))
        free = ~self._near
        return _allowed(differences[free], limits.lower[free], limits.upper[free]) * values

    def _cost_pattern(self) -> "Pattern":
        """Upper triangles of the frames' blocks, and what couples a dof with itself one and two frames later."""
        count, nv = self._count, self._nv
        row, column = np.triu_indices(nv)
        slack = np.arange(count) * (nv + 1) + nv
        starts = np.arange(count)[:, None] * (nv + 1)
        rows = [(starts + row).ravel(), slack]
        columns = [(starts + column).ravel(), slack]
        for apart in (1, 2):
            at = (starts[: max(count - apart, 0)] + np.arange(nv)).ravel()
            rows.append(at)
            columns.append(at + apart * (nv + 1))
        size = count * (nv + 1)
        return Pattern(np.concatenate(rows), np.concatenate(columns), (size, size))

    def _cost_values(self, hessian: Floats) -> Floats:
        row, column = np.triu_indices(self._nv)
        blocks = hessian[:, row, column]
        blocks[:, row == column] += self._coupling.diagonal()[:, None] * self._smoothness
        off = [
            (self._coupling.diagonal(apart)[:, None] * self._smoothness).ravel()
            for apart in (1, 2)
            if apart < self._count
        ]
        return np.concatenate([blocks.ravel(), np.full(self._count, SLACK_PRICE), *off])

    def _grow(self, near: Bools, soft: SoftRows) -> bool:
        """Make room for rows that the pattern lacks; whether it had to grow."""
        moving = np.diff(self._limited.indptr) > 0
        near = (self._near | near) & moving[:, None]
        slots = np.maximum(self._slots, np.bincount(soft.frame, minlength=self._count))
        if self._solver and np.array_equal(near, self._near) and np.array_equal(slots, self._slots):
            return False
        self._near, self._slots = near, slots
        limited, joint = np.nonzero(near)
        lengths = np.diff(self._limited.indptr)[limited]
        entry = np.repeat(self._limited.indptr[limited] - np.cumsum(lengths) + lengths, lengths)
        entry = entry + np.arange(lengths.sum())
        width, held = self._nv + 1, int(slots.sum())
        frame = np.repeat(np.arange(self._count), slots)
        soft_row = np.repeat(np.arange(held) + len(limited), width)
        soft_column = (frame[:, None] * width + np.arange(width)).ravel()
        self._row_values = self._limited.data[entry]
        self._rows = Pattern(
            np.concatenate([np.repeat(np.arange(len(limited)), lengths), soft_row]),
            np.concatenate([self._limited.indices[entry] * width + np.repeat(self._dofs[joint], lengths), soft_column]),
            (len(limited) + held, self._count * width),
        )
        return True

    def _rows_filled(self, soft: SoftRows, limits: LimitedDifferences) -> tuple[Sparse, Floats, Floats]:
        held = int(self._slots.sum())
        first = np.concatenate([[0], np.cumsum(np.bincount(soft.frame, minlength=self._count))])
        slot = (np.cumsum(self._slots) - self._slots - first[:-1])[soft.frame] + np.arange(len(soft.frame))
        jacobian = np.zeros((held, self._nv + 1))
        jacobian[:, -1] = 1.0
        jacobian[slot, :-1] = soft.jacobian
        lower = np.full(held, UNUSED)
        lower[slot] = soft.lower
        return (
            self._rows.filled(np.concatenate([self._row_values, jacobian.ravel()])),
            np.concatenate([limits.lower[self._near], lower]),
            np.concatenate([limits.upper[self._near], np.full(held, np.inf)]),
        )

    def _stacked(self, values: Floats, slack: float) -> Floats:
        return np.column_stack([values, np.full(self._count, slack)]).ravel()


class Pattern:
    """A CSC matrix of fixed pattern; values come in the order in which the pattern was given."""

    def __init__(self, row: np.ndarray, column: np.ndarray, shape: tuple[int, int]) -> None:
        self._order = np.lexsort((row, column))
        self._indices = row[self._order].astype(np.int32)
        self._starts = np.searchsorted(column[self._order], np.arange(shape[1] + 1)).astype(np.int32)
        self._shape = shape

    def filled(self, values: Floats) -> Sparse:
        """The matrix with one of `values` for each entry."""
        return sp.csc_matrix((values[self._order], self._indices, self._starts), shape=self._shape)


def _allowed(differences: Floats, lower: Floats, upper: Floats) -> float:
    """The share up to 1 of `differences` that stays in the ranges; these contain zero."""
    bound = np.where(differences > 0, upper, lower)
    beyond = np.abs(differences) > np.abs(bound)
    return float((bound[beyond] / differences[beyond]).min(initial=1.0))


def _solver() -> piqp.SparseSolver:
    solver = piqp.SparseSolver()
    settings = solver.settings
    settings.verbose, settings.max_iter, settings.tau = False, STUCK, FRACTION
    settings.kkt_solver = piqp.KKTSolver.sparse_multistage
    settings.eps_abs = settings.eps_rel = TOLERANCE
    settings.eps_duality_gap_rel = GAP
    # The columns' natural sizes suit the interior point better than equal norms: half as many iterations.
    settings.preconditioner_iter = 0
    return solver
