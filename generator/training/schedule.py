"""The learning rate over a run."""

import math

from generator.config import Training


def learning_rate(training: Training, iteration: int, progress: float) -> float:
    """The rate of an iteration.

    Args:
        iteration: from 0.
        progress: share of the run that is done, 0 to 1.
    """
    warm = min(1.0, (iteration + 1) / training.warm_up)
    if training.schedule == "step":
        return training.learning_rate * warm * training.gamma ** sum(iteration >= mark for mark in training.milestones)
    cosine = 0.5 * (1 + math.cos(math.pi * progress))
    return training.learning_rate * warm * (training.final_rate + (1 - training.final_rate) * cosine)
