"""The learning rate over a run."""

import pytest

from generator.config import Training
from generator.training.schedule import learning_rate


def test_learning_rate_warms_up_and_falls_as_a_cosine() -> None:
    training = Training(1, 100, 0.5, warm_up=10, final_rate=0.1)
    assert learning_rate(training, 0, 0.0) == pytest.approx(0.05)
    assert learning_rate(training, 9, 0.0) == pytest.approx(0.5)
    assert learning_rate(training, 50, 0.5) == pytest.approx(0.5 * 0.55)
    assert learning_rate(training, 99, 1.0) == pytest.approx(0.05)


def test_learning_rate_steps_at_milestones() -> None:
    training = Training(1, 100, 1.0, warm_up=1, schedule="step", milestones=(20, 60), gamma=0.1)
    found = [learning_rate(training, iteration, iteration / 100) for iteration in (0, 19, 20, 59, 60, 99)]
    assert found == pytest.approx([1.0, 1.0, 0.1, 0.1, 0.01, 0.01])
