"""How surely a motion succeeds: playbacks with another mass, friction, latency, a push and noisy sensors, in parallel.

Perturbed runs read the state that encoders and an IMU tell, as a robot does. The success rate comes with its Wilson
interval (Wilson 1927): of few runs, and of runs that all succeed, it is the honest one.
"""

import os
from collections.abc import Iterator
from concurrent.futures import Executor, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context

import numpy as np

from ros_free_stack.messages import ControllerName, Mount, RobotTrajectory
from ros_free_stack.robots import RobotDescription
from sim.model import judging_model
from sim.playback.estimation import SensorNoise
from sim.playback.physics import Disturbance, FallLimits, Stage, play, set_stage
from sim.reference import make_reference

Z = 1.959964
"""Of the 95 % interval."""

MASS, FRICTION = 0.05, 0.2
"""Greatest relative error of a body's mass and of the floor's friction."""

PUSH_SHARE = 0.03
"""Greatest push, in sqrt(g h) of the root's height h: 0.08 m/s on G1."""


@dataclass(frozen=True)
class Robustness:
    """Outcome of perturbed runs.

    Attributes:
        runs: how many.
        stood: how many did not fall.
    """

    runs: int
    stood: int

    @property
    def rate(self) -> float:
        return self.stood / self.runs

    @property
    def interval(self) -> tuple[float, float]:
        """The Wilson interval of the success rate at 95 %."""
        return wilson(self.stood, self.runs)

    def words(self) -> str:
        """One line for people."""
        low, high = self.interval
        return (
            f"{self.stood} of {self.runs} perturbed runs stood: {self.rate:.0%}, 95 % interval {low:.0%} to {high:.0%}"
        )


def wilson(successes: int, runs: int) -> tuple[float, float]:
    """Lower and upper end of the 95 % interval of a success rate; of no runs 0 to 1.

    (p + z^2/2n +- z sqrt(p q/n + z^2/4n^2)) / (1 + z^2/n) for a share p of n runs.
    """
    if runs == 0:
        return 0.0, 1.0
    share, square = successes / runs, Z**2 / runs
    middle, half = share + square / 2, Z * np.sqrt(share * (1 - share) / runs + square / (4 * runs))
    return max(0.0, float((middle - half) / (1 + square))), min(1.0, float((middle + half) / (1 + square)))


def draw(stage: Stage, seed: int) -> Disturbance:
    """One seeded disturbance: the same seed gives the same, whatever else runs."""
    rng = np.random.default_rng(seed)
    model = stage.model
    direction, height = rng.uniform(0, 2 * np.pi), float(stage.plan.qpos[0, 2])
    strength = PUSH_SHARE * np.sqrt(9.81 * max(height, 0.0)) * rng.uniform(0.0, 1.0)
    return Disturbance(
        mass=1 + rng.uniform(-MASS, MASS, model.nbody),
        friction=float(1 + rng.uniform(-FRICTION, FRICTION)),
        late_cycles=int(rng.integers(0, 2)),
        push=strength * np.array([np.cos(direction), np.sin(direction), 0.0]),
        push_at=float(rng.uniform(0.1, 0.9)),
        noise=SensorNoise(),
        seed=seed,
    )


def perturbed_runs(
    trajectory: RobotTrajectory,
    robot: RobotDescription,
    fall: FallLimits,
    *,
    runs: int,
    seed: int = 0,
    mount: Mount = "free",
    controller: ControllerName = "default",
    workers: int | None = None,
) -> Robustness:
    """Play a trajectory under `runs` disturbances.

    Args:
        trajectory: what is played.
        robot: the robot it was made for.
        fall: what counts as a fall.
        runs: how many; run k has the seed `seed` + k.
        seed: of all disturbances.
        mount: `free` or `fixed`.
        controller: what moves the robot.
        workers: processes; by default one a core that this process may use. 1 runs here.
    """
    workers = min(runs, workers or len(os.sched_getaffinity(0)))
    blocks = [range(seed + first, seed + runs, workers) for first in range(workers)]
    stood = partial(_stood, trajectory, robot, fall, mount, controller)
    if workers == 1:
        return Robustness(runs, stood(blocks[0]))
    judging_model(robot, mount=mount)  # so that the workers find it in the cache
    with _processes(workers) as pool:
        return Robustness(runs, sum(pool.map(stood, blocks)))


@contextmanager
def _processes(workers: int) -> Iterator[Executor]:
    # Not forked: a copy of a process with threads (PyTorch's, OpenMP's) can stop in one of their locks.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield pool


def _stood(
    trajectory: RobotTrajectory,
    robot: RobotDescription,
    fall: FallLimits,
    mount: Mount,
    controller: ControllerName,
    seeds: range,
) -> int:
    """How many of the runs with these seeds did not fall."""
    stage = set_stage(make_reference(trajectory, robot, judging_model(robot)), mount=mount)
    played = (
        play(stage, fall, controller=controller, state="estimated", disturbance=draw(stage, seed)) for seed in seeds
    )
    return sum(playback.fell_at_s is None for playback in played)
