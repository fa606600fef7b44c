"""Subcommands of the generator: `train` and `generate`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from ros_free_stack.console import Command


@dataclass(frozen=True, kw_only=True)
class Train(Command):
    """Train a model of the generator; interrupt it at will and go on with --resume."""

    stage: Annotated[Literal["tokenizer", "mask", "residual", "durations", "all"], tyro.conf.Positional]
    """Which model; each but `durations` needs the one before it. `all` trains one after the other."""
    dataset: Path
    """Folder of the motion data set (made by `data build`)."""
    out: Path
    """Folder for the weights; each model gets a folder in it."""
    preset: Literal["small", "full"] = "small"
    """`small` trains on two processor cores, `full` has the published sizes and wants a GPU."""
    iterations: int | None = None
    """How many iterations; the preset's number where not given."""
    minutes: float | None = None
    """End after this many minutes of training, if that comes before the last iteration."""
    threads: int = 2
    """Processor threads."""
    device: str = "auto"
    """`cpu`, `cuda`, or `auto`: the GPU where there is one."""
    seed: int = 0
    """Seed of initial weights, batches and noise."""
    resume: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Go on from the last checkpoint in the output folder."""

    def run(self) -> int:
        import torch

        from generator.data.dataset import MotionDataset
        from generator.training.stages import STAGES, Job, choose_device

        torch.set_num_threads(self.threads)
        dataset, device = MotionDataset.open(self.dataset), choose_device(self.device)
        results: dict[str, dict[str, float]] = {}
        for stage in STAGES if self.stage == "all" else (self.stage,):
            torch.manual_seed(self.seed)
            job = Job(
                stage, dataset, self.preset, self.out, self.iterations, self.minutes, device, self.seed, self.resume
            )
            results[stage] = job.run()
            if not results[stage]["finished"]:
                self.report(results, f"{stage}: stopped; the same command with --resume goes on")
                return 130
        self.report(results, *(f"{stage}: {self.out / stage}" for stage in results))
        return 0
