"""One joint's increments inside its limits, against a dense solver."""

import daqp
import numpy as np
import scipy.sparse as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.solve.differences import Sparse, Stretch
from retarget.solve.joint_repair import repaired


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10_000), count=st.integers(3, 12), tight=st.floats(0.01, 0.1))
def test_nearest_increments_within_limits(seed, count, tight):
    rng = np.random.default_rng(seed)
    first, second = Stretch(0, count, count).operators()
    differences: Sparse = sp.vstack([first, second], format="csr")
    values, box = rng.normal(0, 0.2, count), (np.full(count, -0.2), np.full(count, 0.25))
    cost: Sparse = sp.diags(rng.uniform(1, 10, count)) + second.T @ second
    limits = np.full(differences.shape[0], -tight), np.full(differences.shape[0], tight)
    found = repaired(values, cost.tocsc(), differences, box, limits)
    assert found is not None
    rows = differences.toarray()
    moving = rows.any(axis=1)
    upper, lower = np.concatenate([box[1], limits[1][moving]]), np.concatenate([box[0], limits[0][moving]])
    sense = np.zeros(len(upper), dtype=np.int32)
    wanted, _, flag, _ = daqp.solve(cost.toarray(), -(cost @ values), rows[moving], upper, lower, sense)
    assert flag == 1
    np.testing.assert_allclose(found, wanted, atol=1e-4)
