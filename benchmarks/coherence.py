"""Tables S3 to S5 of ParTY anew: its coherence scores of real motion under each of its hyper-parameters.

python benchmarks/coherence.py --dataset data/corpus

Beside captured clips, the same clips with the arms of one another are scored: what a good score must tell apart. The
paper chooses by the score of real motion alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np
import tyro

from generator.bodies import channels
from generator.datasets.open_dataset import open_dataset
from ros_free_stack.coherence import spatial_coherence, temporal_coherence
from ros_free_stack.errors import InvalidOption, StackError
from ros_free_stack.formats.features import decode
from ros_free_stack.messages import Floats

SIGMAS, KAPPAS = (0.05, 0.1, 0.2, 0.5), (3.0, 5.0, 10.0, 15.0)
WINDOWS, LAGS = (20, 30, 40), (10, 15, 20, 30)
BETAS = (1.0, 1.5, 2.0, 3.0)

Metric = Callable[[Floats], float]


@dataclass(frozen=True, kw_only=True)
class Arguments:
    """Score captured motion under each hyper-parameter."""

    dataset: Path
    """Folder of the motion data set."""
    source: str = "cmu"
    """Only clips of this source: `cmu`, or the name of a published data set."""
    clips: int = 200
    """How many clips, drawn by the seed."""
    frames: int = 100
    """Of each clip, from its start."""
    seed: int = 0
    """Seed of the draw."""


def motions(arguments: Arguments) -> tuple[list[Floats], list[Floats]]:
    """Joints (T, 22, 3) of captured clips, and of the same with the arms of the next one."""
    data = open_dataset(arguments.dataset)
    found = [clip for clip in data.clips if clip.source == arguments.source and clip.length >= arguments.frames]
    if len(found) < 2:
        sources = ", ".join(sorted({clip.source for clip in data.clips}))
        raise InvalidOption(
            "--source",
            f"fewer than two clips of {arguments.source} have {arguments.frames} frames; the data set has {sources}",
        )
    order = np.random.default_rng(arguments.seed).permutation(len(found))[: arguments.clips]
    real = [data.features(found[place])[: arguments.frames].astype(np.float64) for place in order]
    own, mixed = list(channels("arms")), [rows.copy() for rows in real]
    for number, rows in enumerate(mixed):
        rows[:, own] = real[(number + 1) % len(real)][:, own]
    return [decode(rows) for rows in real], [decode(rows) for rows in mixed]


def row(title: str, metric: Metric, real: Sequence[Floats], mixed: Sequence[Floats]) -> str:
    """One row of a table: the mean over real motions, over mixed ones, and how often a clip beats its mixture."""
    scores, others = (np.array([metric(joints) for joints in motion]) for motion in (real, mixed))
    return f"| {title} | {scores.mean():.3f} | {others.mean():.3f} | {(scores > others).mean():.0%} |"


def main(arguments: Arguments) -> None:
    """Print the tables."""
    real, mixed = motions(arguments)
    head = "| real | arms of another clip | told apart |\n|---|---|---|---|"
    print(f"TC\n\n| sigma, kappa {head}")
    for sigma, kappa in product(SIGMAS, KAPPAS):
        print(row(f"{sigma:g}, {kappa:g}", partial(temporal_coherence, sigma=sigma, kappa=kappa), real, mixed))
    print(f"\n| window, greatest lag {head}")
    for window, lag in product(WINDOWS, LAGS):
        print(row(f"{window}, {lag}", partial(temporal_coherence, window=window, max_lag=lag), real, mixed))
    print(f"\nSC\n\n| beta {head}")
    for beta in BETAS:
        print(row(f"{beta:g}", partial(spatial_coherence, beta=beta), real, mixed))


if __name__ == "__main__":
    try:
        main(tyro.cli(Arguments, description=__doc__))
    except StackError as error:
        raise SystemExit(f"error: {error}") from None
