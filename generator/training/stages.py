"""One stage of training: its settings, its data, its place, and the weights it begins with."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import torch

from generator import weights
from generator.config import Training, checked
from generator.datasets.dataset import MotionDataset
from generator.registry import SHARED, Generator, Stage, resolved, stages
from generator.settings import Preset
from generator.training.loop import Objective, Run, train
from ros_free_stack.console import say
from ros_free_stack.errors import InvalidOption, UnknownName

Config = TypeVar("Config")


@dataclass(frozen=True, kw_only=True)
class StageJob:
    """One stage to be trained.

    Attributes:
        stage: its name.
        generator: whose it is; durations and evaluator serve all.
        preset: settings of all stages.
        dataset: what it is trained on.
        out: folder of the weights, in which every generator has a folder, and every stage one in that.
        iterations, minutes: ends training there; the preset's number of iterations where None.
        resume: go on from the last checkpoint.
        tune: folder of trained weights to begin with; None begins with random ones.
    """

    stage: str
    generator: Generator
    preset: Preset
    dataset: MotionDataset
    out: Path
    iterations: int | None = None
    minutes: float | None = None
    device: str = "cpu"
    seed: int = 0
    resume: bool = False
    tune: Path | None = None

    @property
    def training(self) -> Training:
        """How the stage is trained."""
        return checked(Training, self._section("training"), f"{self.stage}.training")

    def model(self, kind: type[Config]) -> Config:
        """Sizes of its model; UnknownName or InvalidOption where the settings do not fit."""
        return checked(kind, self._section("model"), f"{self.stage}.model")

    def objective(self, kind: type[Config]) -> Config:
        """Its losses, likewise."""
        return checked(kind, self._section("objective"), f"{self.stage}.objective")

    def folder(self, stage: str, root: Path | None = None) -> Path:
        """Folder of a stage's weights, in `out` if not told."""
        own = any(stage == item.name for item in self.generator.stages)
        return (root or self.out) / (self.generator.name if own else SHARED) / stage

    def run(self) -> dict[str, float]:
        """Train the stage; the last row of its loss curve.

        Raises:
            UnknownName: the generator has no such stage, or a setting is unknown.
            InvalidOption: a setting does not fit, or the weights to begin with speak another tokenizer's tokens.
        """
        stage, training = self._stage(), self.training
        objective: Objective = resolved(stage.objective)(self)
        if self.tune is not None:
            self._begin_with(self.folder(self.stage, self.tune), objective)
        parameters = sum(parameter.numel() for parameter in objective.model.parameters())
        say(f"{self.stage}: {parameters / 1e6:.2f} M parameters, {objective.facts['clips']} clips, on {self.device}")
        run = Run(self.iterations or training.iterations, self.minutes, self.device, self.seed, self.resume)
        result = train(objective, training, self.folder(self.stage), run)
        if stage.finish and result["finished"]:
            resolved(stage.finish)(self)
        return result

    def _stage(self) -> Stage:
        known = {stage.name: stage for stage in stages(self.generator)}
        if self.stage not in known:
            raise UnknownName("stage", self.stage, [*known, "domain", "all"])
        return known[self.stage]

    def _section(self, name: str) -> dict[str, Any]:
        return self.preset.stage(self.stage).get(name, {})

    def _begin_with(self, folder: Path, objective: Objective) -> None:
        """Take trained weights; tokens may be those of the present tokenizer or of the one that it was tuned from."""
        saved = weights.load(folder, self.stage)
        if saved.facts.get("tokenizer") not in (objective.facts.get("tokenizer"), self._tokenizer_before(objective)):
            raise InvalidOption(
                "--tune", f"{folder} was trained with another tokenizer than the one in {self.folder('tokenizer')}"
            )
        saved.fill(objective.model)
        objective.facts["tuned_from"] = saved.digest

    def _tokenizer_before(self, objective: Objective) -> str | None:
        """Digest of the tokenizer that the present one was tuned from, for a model that speaks its tokens."""
        if "tokenizer" not in objective.facts:
            return None
        return weights.load(self.folder("tokenizer"), "tokenizer").facts.get("tuned_from")


def choose_device(name: str) -> str:
    """ "auto" is the GPU where there is one; anything else but "cpu" and "cuda" is an UnknownName."""
    choices = ["cpu", "cuda"] if torch.cuda.is_available() else ["cpu"]
    if name == "auto":
        return choices[-1]
    if name not in choices:
        raise UnknownName("device", name, ["auto", *choices])
    return name
