"""Every generator: who loads it, which stages it is trained in, which presets it has.

A new generator is a package in `generator/models` and an entry here; nothing else names it.
"""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from generator.settings import FOLDER, Preset, read_preset
from ros_free_stack.errors import UnknownName

if TYPE_CHECKING:
    from generator.model import MotionModel

WEIGHTS_FOLDER: Final = Path(__file__).parent / "weights"
"""The weights that come with the program: a folder for each generator, in it one for each of its stages."""

SHARED: Final = "shared"
"""Folder of what serves all generators: durations, evaluator, known texts."""

SHARED_WEIGHTS: Final = WEIGHTS_FOLDER / SHARED

DEFAULT: Final = "segmo"
DEFAULT_PRESET: Final = "segmo-layout"

Target = str | Callable[..., Any]
"""A function or class, or "module:name" of one, which is imported when it is needed."""


@dataclass(frozen=True)
class Stage:
    """One model that is trained.

    Attributes:
        name: as given to `train`, and of its folder.
        objective: makes its `Objective` of a `generator.training.stages.StageJob`.
        finish: called with the job after training, "" for nothing.
    """

    name: str
    objective: Target
    finish: Target = ""


@dataclass(frozen=True)
class Generator:
    """One generator.

    Attributes:
        name: as given to `--generator`, and of its folder of weights.
        title: for people.
        model: the class that is a `MotionModel`.
        stages: in the order in which one needs the other's result.
        presets: names of its presets, the usual one first.
        folder: where their files lie.
    """

    name: str
    title: str
    model: Target
    stages: tuple[Stage, ...]
    presets: tuple[str, ...]
    folder: Path = FOLDER

    def load(self, folder: Path, device: str) -> "MotionModel":
        """Its model from a folder of weights; NoWeights says how to train what is missing."""
        return resolved(self.model).load(folder / self.name, device=device)


_SEGMO: Final = "generator.models.segmo"
_PARTY: Final = "generator.models.party"

_STAGES: Final = (
    Stage("tokenizer", f"{_SEGMO}.objectives.tokenizer:from_job"),
    Stage("mask", f"{_SEGMO}.objectives.mask:from_job"),
    Stage("residual", f"{_SEGMO}.objectives.residual:from_job"),
)

GENERATORS: dict[str, Generator] = {
    item.name: item
    for item in (
        Generator(
            name="segmo",
            title="SegMo (Dang et al., WACV 2026): masked transformers on residual tokens, aligned segments",
            model=f"{_SEGMO}.model:SegMo",
            stages=(
                *_STAGES,
                Stage("grounding", f"{_SEGMO}.objectives.mask:from_job", "generator.grounding.texts:after_training"),
            ),
            presets=("segmo-layout", "segmo-published"),
        ),
        Generator(
            name="momask",
            title="MoMask (Guo et al., CVPR 2024): masked transformers on residual tokens, sentence alone",
            model=f"{_SEGMO}.model:SegMo",
            stages=_STAGES,
            presets=("momask",),
        ),
        Generator(
            name="party",
            title="ParTY (Heo et al., CVPR 2026): arms and legs first, as a guide to the whole body",
            model=f"{_PARTY}.model:Party",
            stages=(
                Stage("tokenizer", f"{_PARTY}.objectives.tokenizer:from_job"),
                Stage("transformer", f"{_PARTY}.objectives.transformer:from_job"),
            ),
            presets=("party-small", "party"),
        ),
    )
}
"""By name."""

SHARED_STAGES: Final = (
    Stage("durations", "generator.training.durations:from_job"),
    Stage("evaluator", "generator.training.evaluator:from_job"),
)
"""Trained once for all generators."""


def generator(name: str) -> Generator:
    """The generator of that name, or UnknownName."""
    if name not in GENERATORS:
        raise UnknownName("generator", name, GENERATORS)
    return GENERATORS[name]


def stages(of: Generator) -> tuple[Stage, ...]:
    """All stages that a generator needs, in order."""
    return (*of.stages, *SHARED_STAGES)


def training_command(folder: Path) -> str:
    """What trains the stage whose weights belong into a folder, which lies in its generator's."""
    owner = GENERATORS.get(folder.parent.name)
    chosen = f" --preset {owner.presets[0]}" if owner and owner.presets[0] != DEFAULT_PRESET else ""
    return f"python launch.py train {folder.name}{chosen} --dataset DATASET --out {folder.parent.parent}"


def find_preset(name: str, size: str = "small") -> tuple[Generator, Preset]:
    """A preset in one size, and whose it is; UnknownName where there is none."""
    for item in GENERATORS.values():
        if name in item.presets:
            return item, read_preset(item.folder / f"{name}.yaml", size)
    raise UnknownName("preset", name, [preset for item in GENERATORS.values() for preset in item.presets])


def resolved(target: Target) -> Callable[..., Any]:
    """The function or class that a target names."""
    if callable(target):
        return target
    module, _, name = target.partition(":")
    return getattr(importlib.import_module(module), name)
