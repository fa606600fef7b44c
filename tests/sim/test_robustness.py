"""Perturbed runs and the interval of their success rate."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binomtest

from sim.judge.robustness import draw, perturbed_runs, wilson
from sim.judge.verdict import judge
from sim.model import judging_model
from sim.playback.physics import FallLimits, set_stage
from sim.reference import make_reference

LIMITS = FallLimits(0.1, 0.8)


@given(st.integers(1, 200), st.data())
def test_interval_is_scipys(runs, data):
    successes = data.draw(st.integers(0, runs))
    expected = binomtest(successes, runs).proportion_ci(method="wilson")
    assert wilson(successes, runs) == pytest.approx((expected.low, expected.high), abs=1e-6)


def test_no_runs():
    assert wilson(0, 0) == (0.0, 1.0)


def test_same_seed_same_disturbance(op3, standing):
    stage = set_stage(make_reference(standing(op3), op3, judging_model(op3)))
    first, again, other = draw(stage, 3), draw(stage, 3), draw(stage, 4)
    assert np.array_equal(first.mass, again.mass) and first.push.tolist() == again.push.tolist()
    assert not np.array_equal(first.mass, other.mass)
    assert np.abs(first.mass - 1).max() <= 0.05


def test_standing_survives_and_workers_agree(op3, standing):
    trajectory = standing(op3, frames=20)
    alone = perturbed_runs(trajectory, op3, LIMITS, runs=2, workers=1)
    together = perturbed_runs(trajectory, op3, LIMITS, runs=2, workers=2)
    assert alone == together
    assert alone.stood == 2 and alone.rate == 1.0


def test_verdict_carries_the_rate(op3, standing):
    rise = np.zeros((20, 3))
    rise[:, 2] = np.linspace(0, 0.3, 20)
    judgement = judge(standing(op3, frames=20, root_offset=rise, contacts=False), op3, perturbed=1)
    (check,) = [check for check in judgement.verdict.checks if check.name == "robustness"]
    assert check.value == 0 and not check.passed
    assert any(
        "0 of 1 perturbed runs stood" in note and "95 % interval 0% to 79%" in note for note in judgement.verdict.notes
    )
