"""The training stages, in the order in which one needs the other's result."""

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import torch

from generator import weights
from generator.config import Training
from generator.data.dataset import MotionDataset
from generator.presets import Preset, preset
from generator.training.loop import Objective, Run, train
from ros_free_stack.console import say
from ros_free_stack.errors import InvalidOption, UnknownName

STAGES: Final = ("tokenizer", "mask", "residual", "durations", "evaluator", "grounding")


@dataclass(frozen=True)
class Job:
    """One stage of training.

    Attributes:
        dataset: folder of the motion data set.
        out: folder of the weights, with one folder a model.
        tune: folder of trained weights to begin with; none begins with random ones.
    """

    stage: str
    dataset: MotionDataset
    preset_name: str
    out: Path
    iterations: int | None
    minutes: float | None
    device: str
    seed: int
    resume: bool
    tune: Path | None = None

    def run(self) -> dict[str, float]:
        """Train the stage; the last row of its loss curve.

        Raises:
            InvalidOption: the weights to begin with speak another tokenizer's tokens.
        """
        models = preset(self.preset_name)
        training = _training(models, self.stage)
        objective = _objective(self, models)
        if self.tune is not None:
            self._begin_with(self.tune / self.stage, objective)
        parameters = sum(parameter.numel() for parameter in objective.model.parameters())
        say(f"{self.stage}: {parameters / 1e6:.2f} M parameters, {objective.facts['clips']} clips, on {self.device}")
        run = Run(self.iterations or training.iterations, self.minutes, self.device, self.seed, self.resume)
        result = train(objective, training, self.out / self.stage, run)
        if self.stage == "grounding" and result["finished"]:
            self._embed_known_texts()
        return result

    def _begin_with(self, folder: Path, objective: Objective) -> None:
        """Take trained weights; tokens may be those of the present tokenizer or of the one that it was tuned from."""
        saved = weights.load(folder, self.stage)
        if saved.facts.get("tokenizer") not in (objective.facts.get("tokenizer"), self._tokenizer_before(objective)):
            raise InvalidOption(
                "--tune", f"{folder} was trained with another tokenizer than the one in {self.out / 'tokenizer'}"
            )
        saved.fill(objective.model)
        objective.facts["tuned_from"] = saved.digest

    def _tokenizer_before(self, objective: Objective) -> str | None:
        """Digest of the tokenizer that the present one was tuned from, for a model that speaks its tokens."""
        if "tokenizer" not in objective.facts:
            return None
        return weights.load(self.out / "tokenizer", "tokenizer").facts.get("tuned_from")

    def _embed_known_texts(self) -> None:
        from generator.grounding.space import AlignedSpace
        from generator.grounding.texts import KnownTexts

        KnownTexts.fit(self.dataset, AlignedSpace.load(self.out)).save(self.out / self.stage)


def choose_device(name: str) -> str:
    """ "auto" is the GPU where there is one; anything else but "cpu" and "cuda" is an UnknownName."""
    choices = ["cpu", "cuda"] if torch.cuda.is_available() else ["cpu"]
    if name == "auto":
        return choices[-1]
    if name not in choices:
        raise UnknownName("device", name, ["auto", *choices])
    return name


def _training(models: Preset, stage: str) -> Training:
    if stage not in STAGES:
        raise UnknownName("stage", stage, [*STAGES, "all"])
    return getattr(models, f"{stage}_training")


def _objective(job: Job, models: Preset) -> Objective:
    """The stage's objective; each imports only what it needs, so that none waits for the others' libraries."""
    training = _training(models, job.stage)
    if job.stage == "tokenizer":
        from generator.models.segmo.objectives.tokenizer import TokenizerObjective

        return TokenizerObjective(job.dataset, models.tokenizer, training, job.seed)
    if job.stage == "durations":
        from generator.training.durations import DurationsObjective

        return DurationsObjective(job.dataset, models.durations, training, job.seed)
    if job.stage == "evaluator":
        from generator.training.evaluator import EvaluatorObjective

        return EvaluatorObjective(job.dataset, models.evaluator, training, job.seed)
    from generator.models.segmo.objectives.batches import TokenCorpus

    corpus = TokenCorpus.build(job.dataset, job.out / "tokenizer", job.device)
    if job.stage == "mask":
        from generator.models.segmo.objectives.mask import MaskObjective

        return MaskObjective(corpus, models.mask, training, job.seed)
    if job.stage == "grounding":
        from generator.models.segmo.objectives.mask import MaskObjective

        return MaskObjective(corpus, models.grounding, training, job.seed, name="grounding")
    from generator.models.segmo.objectives.residual import ResidualObjective

    return ResidualObjective(corpus, models.residual, training, job.seed)
