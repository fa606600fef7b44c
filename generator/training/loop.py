"""The training loop that all models share: schedule, averaged weights, checkpoints, loss curve, export of the best.

Batch and random draws of an iteration depend on the seed and its number only, so a resumed run repeats an unbroken one.
"""

import copy
import math
import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import torch
from torch import Tensor, nn

from generator import weights
from generator.config import Training
from generator.training.curve import plot_curve, write_curve
from generator.training.reporter import Reporter
from generator.training.schedule import learning_rate
from ros_free_stack.errors import InvalidFile, InvalidOption
from ros_free_stack.files import atomic_path, make_folder

CHECKPOINT = "checkpoint.pt"
BF16 = "RFS_BF16"
CHECKPOINT_EVERY_S = 180.0
VALIDATIONS = 20  # in a whole run
ROWS = 400  # of the loss curve in a whole run


class Objective(Protocol):
    """What is trained: a model, its configuration, and the loss of each iteration.

    Attributes:
        name: of the stage, and of its folder.
        facts: noted beside the weights.
    """

    name: str
    model: nn.Module
    config: Any
    facts: dict[str, Any]

    def loss(self, iteration: int) -> dict[str, Tensor]:
        """Scalars of this iteration's batch; "loss" is minimised, the others are logged."""
        ...

    def validate(self, model: nn.Module) -> dict[str, float]:
        """Scalars on the validation split; the weights of least "loss" are exported."""
        ...


@dataclass(frozen=True)
class Run:
    """How far and where to train.

    Attributes:
        minutes: also end after this much training time; the learning rate follows whichever is nearer to its end.
        resume: go on from the folder's checkpoint.
    """

    iterations: int
    minutes: float | None = None
    device: str = "cpu"
    seed: int = 0
    resume: bool = False


@dataclass
class _State:
    """What a checkpoint holds beside the tensors."""

    iteration: int = 0
    seconds: float = 0.0
    best: float = math.inf
    curve: list[dict[str, float]] = field(default_factory=list)
    sums: dict[str, float] = field(default_factory=dict)
    summed: int = 0


def train(objective: Objective, training: Training, folder: Path, run: Run) -> dict[str, float]:
    """Train until the iterations or minutes are spent, or until SIGINT or SIGTERM, which leave a checkpoint.

    Writes `weights.safetensors` and `config.json` (best validation so far), `checkpoint.pt`, `curve.csv`, `curve.png`.

    Returns: the last row of the loss curve, with "finished" 1 or 0.
    """
    if run.iterations < 1 or (run.minutes is not None and run.minutes <= 0):
        raise InvalidOption("--iterations / --minutes", "must be positive")
    return _Trainer(objective, training, make_folder(folder), run).train()


class _Trainer:
    def __init__(self, objective: Objective, training: Training, folder: Path, run: Run) -> None:
        self.objective, self.training, self.folder, self.run = objective, training, folder, run
        self.model = objective.model.to(run.device)
        self.averaged = copy.deepcopy(self.model).eval() if training.ema else self.model
        self.optimiser = torch.optim.AdamW(
            self.model.parameters(),
            lr=training.learning_rate,
            betas=training.betas,
            weight_decay=training.weight_decay,
            fused=True,
        )
        self.state = _State()
        if run.resume:
            self._load()

    def train(self) -> dict[str, float]:
        state, reporter = self.state, Reporter(self.objective.name, self.run.iterations)
        row_every = max(1, self.run.iterations // ROWS)
        validate_every = row_every * max(1, self.run.iterations // row_every // VALIDATIONS)
        saved = time.monotonic()
        with _stop_requested() as stopped, reporter:
            while self._progress() < 1 and not stopped():
                started = time.perf_counter()
                self._step()
                state.seconds += time.perf_counter() - started
                if state.iteration % row_every == 0:
                    self._row(validate=state.iteration % validate_every == 0)
                reporter.update(state.iteration, self._progress(), state.curve[-1] if state.curve else {})
                if time.monotonic() - saved > CHECKPOINT_EVERY_S:
                    self._save()
                    saved = time.monotonic()
            finished = self._progress() >= 1
            if finished and "validation_loss" not in (state.curve[-1] if state.curve else {}):
                self._row(validate=True)
            self._save()
        return {**(state.curve[-1] if state.curve else {}), "finished": float(finished)}

    def _progress(self) -> float:
        """Share of the run that is done, 0 to 1: of the iterations or of the minutes, whichever is further."""
        done = self.state.iteration / self.run.iterations
        if self.run.minutes is not None:
            done = max(done, self.state.seconds / (60 * self.run.minutes))
        return min(done, 1.0)

    def _learning_rate(self) -> float:
        return learning_rate(self.training, self.state.iteration, self._progress())

    def _step(self) -> None:
        state = self.state
        torch.manual_seed(self.run.seed * 1_000_003 + state.iteration)
        self.model.train()
        for group in self.optimiser.param_groups:
            group["lr"] = self._learning_rate()
        with autocast(self.run.device):
            losses = self.objective.loss(state.iteration)
        self.optimiser.zero_grad()
        losses["loss"].backward()
        if self.training.clip:
            nn.utils.clip_grad_norm_(self.model.parameters(), self.training.clip)
        self.optimiser.step()
        self._average()
        state.iteration += 1
        for name, value in losses.items():
            state.sums[name] = state.sums.get(name, 0.0) + float(value.detach())
        state.summed += 1

    @torch.no_grad()
    def _average(self) -> None:
        """Move the averaged weights towards the new ones, faster in the first iterations."""
        if not self.training.ema:
            return
        decay = min(self.training.ema, (1 + self.state.iteration) / (10 + self.state.iteration))
        for mine, theirs in zip(self.averaged.parameters(), self.model.parameters(), strict=True):
            mine.lerp_(theirs, 1 - decay)
        for mine, theirs in zip(self.averaged.buffers(), self.model.buffers(), strict=True):
            mine.copy_(theirs)

    def _row(self, *, validate: bool) -> None:
        """Add a row to the loss curve; where asked, validate and export the weights if they are the best so far."""
        state = self.state
        row = {"iteration": float(state.iteration), "seconds": state.seconds, "learning_rate": self._learning_rate()}
        row |= {name: total / max(1, state.summed) for name, total in state.sums.items()}
        state.sums, state.summed = {}, 0
        state.curve.append(row)
        if not validate:
            return
        self.averaged.eval()
        with torch.no_grad(), autocast(self.run.device):
            row |= {f"validation_{name}": value for name, value in self.objective.validate(self.averaged).items()}
        if row["validation_loss"] < state.best:
            state.best = row["validation_loss"]
            facts = {**self.objective.facts, "iteration": state.iteration, "validation_loss": state.best}
            weights.save(self.folder, self.objective.config, self.averaged, facts)

    def _save(self) -> None:
        with atomic_path(self.folder / CHECKPOINT) as temporary:
            torch.save(
                {
                    "state": vars(self.state),
                    "model": self.model.state_dict(),
                    "averaged": self.averaged.state_dict(),
                    "optimiser": self.optimiser.state_dict(),
                },
                temporary,
            )
        if self.state.curve:
            write_curve(self.folder / "curve.csv", self.state.curve)
            plot_curve(self.folder / "curve.png", self.state.curve, self.objective.name)

    def _load(self) -> None:
        path = self.folder / CHECKPOINT
        if not path.is_file():
            raise InvalidOption("--resume", f"there is no checkpoint at {path}")
        try:
            data = torch.load(path, map_location=self.run.device, weights_only=True)
            self.model.load_state_dict(data["model"])
            self.averaged.load_state_dict(data["averaged"])
            self.optimiser.load_state_dict(data["optimiser"])
            self.state = _State(**data["state"])
        except (RuntimeError, KeyError, TypeError, ValueError, EOFError) as error:
            problem = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise InvalidFile(path, f"is no checkpoint of this model and size ({problem})") from None


def autocast(device: str) -> AbstractContextManager[Any]:
    """bfloat16 where the device has matrix units for it; elsewhere it would be slower than float32.

    The environment variable RFS_BF16, `on` or `off`, overrides what the device has, so that either way can be tried.

    Raises:
        InvalidOption: the variable holds something else.
    """
    return torch.autocast(torch.device(device).type, torch.bfloat16) if _bfloat16(device) else nullcontext()


def _bfloat16(device: str) -> bool:
    forced = os.environ.get(BF16, "")
    if forced not in ("", "on", "off"):
        raise InvalidOption(BF16, f"expected on or off, found {forced!r}")
    if forced:
        return forced == "on"
    able = torch.cpu.get_capabilities()
    return device != "cpu" or able["amx_bf16"] or able["avx512_bf16"]


@contextmanager
def _stop_requested() -> Iterator[Callable[[], bool]]:
    """A function that tells whether SIGINT or SIGTERM has come; a second one acts as usual."""
    caught: list[int] = []
    before: dict[int, Any] = {}

    def note(number: int, _: Any) -> None:
        caught.append(number)
        signal.signal(number, before[number])

    for number in (signal.SIGINT, signal.SIGTERM):
        before[number] = signal.signal(number, note)
    try:
        yield lambda: bool(caught)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
