"""The banded program against the same program written densely and solved by another solver."""

import daqp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.solve import trajectory_qp
from retarget.solve.differences import Stretch
from retarget.solve.trajectory_qp import SLACK_PRICE, LimitedDifferences, Quadratic, SoftRows, TrajectoryQP


def differences(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Dense first and second differences of frames that rest before and after."""
    places = np.clip(np.arange(-2, count + 2), 0, count - 1)
    moves = np.eye(count)[places]
    return np.diff(moves, axis=0), np.diff(moves, n=2, axis=0)


def dense_solution(cost, smoothness, changes, box, soft, limits, dofs) -> np.ndarray:
    """(n, nv) by DAQP; soft rows as a variable a frame."""
    count, nv = cost.gradient.shape
    first, second = differences(count)
    size = count * (nv + 1)

    def at(frame, dof):
        return frame * (nv + 1) + dof

    hessian, linear = np.zeros((size, size)), np.zeros(size)
    for k in range(count):
        block = slice(at(k, 0), at(k, nv))
        hessian[block, block] += cost.hessian[k]
        linear[block] += cost.gradient[k]
        hessian[at(k, nv), at(k, nv)] = SLACK_PRICE
    for dof in range(nv):
        index = at(np.arange(count), dof)
        hessian[np.ix_(index, index)] += smoothness[dof] * second.T @ second
        linear[index] += smoothness[dof] * second.T @ changes[:, dof]
    rows, lower, upper = [], list(np.column_stack([box[0], np.full(count, -1e30)]).ravel()), []
    upper = list(np.column_stack([box[1], np.full(count, 1e30)]).ravel())
    for r, operator in enumerate(np.concatenate([first, second])):
        for j, dof in enumerate(dofs):
            row = np.zeros(size)
            row[at(np.arange(count), dof)] = operator
            if row.any():
                rows.append(row)
                lower.append(limits.lower[r, j])
                upper.append(limits.upper[r, j])
    for frame, jacobian, least in zip(soft.frame, soft.jacobian, soft.lower, strict=True):
        row = np.zeros(size)
        row[at(frame, 0) : at(frame, nv)], row[at(frame, nv)] = jacobian, 1.0
        rows.append(row)
        lower.append(least)
        upper.append(1e30)
    found, _, flag, _ = daqp.solve(
        hessian, linear, np.array(rows), np.array(upper), np.array(lower), np.zeros(len(upper), dtype=np.int32)
    )
    assert flag == 1
    return found.reshape(count, nv + 1)[:, :nv]


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(1, 9), tight=st.floats(0.002, 0.05))
def test_agrees_with_a_dense_solver(seed, count, tight):
    """Solved to the end; an iteration of a clip stops where its own error is larger."""
    rng = np.random.default_rng(seed)
    nv, dofs = 5, np.array([1, 3, 4])
    factor = rng.normal(size=(count, 4, nv))
    cost = Quadratic(factor.swapaxes(1, 2) @ factor + 0.1 * np.eye(nv), rng.normal(size=(count, nv)))
    changes, smoothness = rng.normal(0, 0.01, (count + 2, nv)), rng.uniform(0.5, 5, nv)
    box = (np.full((count, nv), -0.3), np.full((count, nv), 0.2))
    frame = np.sort(rng.integers(0, count, 4))
    soft = SoftRows(frame, rng.normal(size=(4, nv)), rng.uniform(-0.1, 0.02, 4))
    shape = (2 * count + 5, len(dofs))
    limits = LimitedDifferences(np.full(shape, -tight), np.full(shape, tight), np.ones(shape, dtype=bool))
    program = TrajectoryQP(Stretch(0, count, count), dofs, smoothness)
    for _ in range(2):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(trajectory_qp, "TOLERANCE", 1e-9)
            patch.setattr(trajectory_qp, "GAP", 1e-9)
            found = program.solve(cost, changes, box, soft, limits)
        assert found is not None
        wanted = dense_solution(cost, smoothness, changes, box, soft, limits, dofs)
        np.testing.assert_allclose(found, wanted, atol=5e-4)
        cost = Quadratic(cost.hessian, -cost.gradient)


def test_rows_that_were_not_foreseen_hold_all_the_same():
    count, nv, dofs = 20, 3, np.array([0, 1, 2])
    cost = Quadratic(
        np.tile(np.eye(nv), (count, 1, 1)), np.where(np.arange(count)[:, None] % 6 < 3, 1.0, -1.0) * np.ones(nv)
    )
    shape = (2 * count + 5, nv)
    limits = LimitedDifferences(np.full(shape, -0.01), np.full(shape, 0.01), np.zeros(shape, dtype=bool))
    box = (np.full((count, nv), -0.3), np.full((count, nv), 0.3))
    none = SoftRows(np.zeros(0, dtype=int), np.zeros((0, nv)), np.zeros(0))
    program = TrajectoryQP(Stretch(0, count, count), dofs, np.full(nv, 1e-3))
    found = program.solve(cost, np.zeros((count + 2, nv)), box, none, limits)
    assert found is not None
    first, second = differences(count)
    assert np.abs(first @ found).max() <= 0.01 + 1e-8 and np.abs(second @ found).max() <= 0.01 + 1e-8
    assert np.abs(found).max() > 0.005


def test_only_a_joint_that_misses_a_limit_gives_way():
    count, nv, dofs = 12, 2, np.array([0, 1])
    gradient = np.zeros((count, nv))
    gradient[6, 0], gradient[:, 1] = -1.0, -0.1
    cost = Quadratic(np.tile(np.eye(nv), (count, 1, 1)), gradient)
    shape = (2 * count + 5, nv)
    limits = LimitedDifferences(np.full(shape, -0.05), np.full(shape, 0.05), np.zeros(shape, dtype=bool))
    limits.lower[:, 1], limits.upper[:, 1] = -1.0, 1.0
    box = (np.full((count, nv), -2.0), np.full((count, nv), 2.0))
    none = SoftRows(np.zeros(0, dtype=int), np.zeros((0, nv)), np.zeros(0))
    program = TrajectoryQP(Stretch(0, count, count), dofs, np.zeros(nv))
    found = program.solve(cost, np.zeros((count + 2, nv)), box, none, limits)
    assert found is not None
    np.testing.assert_allclose(found[:, 1], 0.1, atol=1e-3)
    first, second = differences(count)
    assert max(np.abs(first @ found[:, 0]).max(), np.abs(second @ found[:, 0]).max()) <= 0.05 + 1e-8
    assert found[:, 0].argmax() == 6 and found[6, 0] > 0.05
