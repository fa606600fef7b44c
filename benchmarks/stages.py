"""Seconds of each stage: a cold process with one prompt, then a second prompt in a warm one, with their ratio.

python benchmarks/stages.py --robot op3
"""

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import tyro

from pipeline.pipeline import Pipeline
from pipeline.timings import Timings
from ros_free_stack.robots import load_robot

COLD = "a person waves with the right hand"
WARM = "a person squats down and stands up"
STAGES = ("text", "generate", "retarget", "validate")


@dataclass(frozen=True)
class Arguments:
    """Time a cold run (one candidate, no video) and a warm second prompt, stage by stage."""

    robot: str = "op3"
    """Robot by name."""


def cold(robot: str) -> dict[str, float]:
    """Seconds of each stage of a fresh process, and of the whole process as "process"."""
    options = ("--robot", robot, "--candidates", "1", "--no-video", "--json")
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "ros_free_stack", "run", COLD, *options, "--out", str(Path(folder) / "run")]
        start = perf_counter()
        finished = subprocess.run(command, stdout=subprocess.PIPE, check=False)
        elapsed = perf_counter() - start
    return {**json.loads(finished.stdout)["timings_s"], "process": elapsed}


def warm(robot: str) -> dict[str, float]:
    """Seconds of each stage for a second prompt in one process."""
    pipeline = Pipeline(load_robot(robot))
    timings = Timings()
    for prompt in (COLD, WARM):
        timings = Timings()
        with timings.measure("text"):
            segments, _ = pipeline.segments(prompt)
        pipeline.candidates(prompt, segments, seed=0, candidates=1, timings=timings)
    return timings.seconds


def main(arguments: Arguments) -> None:
    """Print the table."""
    first, second = cold(arguments.robot), warm(arguments.robot)
    print("| stage | cold, s | warm, s | cold / warm |\n|---|---|---|---|")
    for stage in STAGES:
        print(f"| {stage} | {first[stage]:.2f} | {second[stage]:.2f} | {first[stage] / second[stage]:.1f} |")
    total = sum(second[stage] for stage in STAGES)
    print(f"| report | {first['report']:.2f} | | |")
    print(f"| whole process | {first['process']:.2f} | {total:.2f} | {first['process'] / total:.1f} |")


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
