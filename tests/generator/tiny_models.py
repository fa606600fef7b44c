"""Models so small that they train in a second, as changes to the preset that comes with the program, and folders of
ones that were never trained."""

from pathlib import Path
from typing import Any

import torch

from generator import weights
from generator.datasets.dataset import MotionDataset
from generator.models.segmo.config import TokenizerConfig, TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.tokenizer import MotionTokenizer
from generator.nn.durations import DurationModel, DurationsConfig
from generator.nn.evaluator import EvaluatorConfig, MotionTextEvaluator
from generator.registry import SHARED, find_preset
from generator.settings import Preset
from generator.training.stages import StageJob

TRANSFORMERS = ("mask", "grounding")
STAGES = ("tokenizer", *TRANSFORMERS, "durations", "evaluator")
SMALLER = (
    *(f"tokenizer.model.{k}={v}" for k, v in {"width": 32, "encoder_width": 8, "depth": 1, "code_width": 8}.items()),
    *(f"{stage}.model.codes=32" for stage in ("tokenizer", *TRANSFORMERS)),
    "tokenizer.objective.window=40",
    *(
        f"{stage}.model.{k}={v}"
        for stage in TRANSFORMERS
        for k, v in {"width": 32, "layers": 1, "feed_forward": 64}.items()
    ),
    "durations.model.width=16",
    *(f"evaluator.model.{k}={v}" for k, v in {"width": 16, "layers": 1, "embedding": 8}.items()),
    *(f"{stage}.training.{k}={v}" for stage in STAGES for k, v in {"batch": 8, "iterations": 12, "warm_up": 2}.items()),
)
"""Changes to `segmo-layout`, as `train --set` takes them."""


RESIDUAL = tuple(change.replace("mask.", "residual.", 1) for change in SMALLER if change.startswith("mask."))


def tiny_preset(name: str = "segmo-layout", *changes: str) -> Preset:
    """A preset with models of a few thousand parameters."""
    _, preset = find_preset(name)
    known = [change for change in (*SMALLER, *RESIDUAL) if change.partition(".")[0] in preset.stages]
    return preset.changed((*known, *changes))


def tiny_job(
    stage: str, dataset: MotionDataset, out: Path, *changes: str, preset: str = "segmo-layout", **options: Any
) -> StageJob:
    """A stage of such a preset."""
    generator, _ = find_preset(preset)
    chosen = tiny_preset(preset, *changes)
    return StageJob(stage=stage, generator=generator, preset=chosen, dataset=dataset, out=out, **options)


def write_tiny_models(folder: Path, *, quantizers: int = 3, width: int = 32) -> Path:
    """A folder of weights of tiny models that were never trained, as `train` leaves it."""
    torch.manual_seed(0)
    own, shared = folder / "segmo", folder / SHARED
    for place in (
        *(own / name for name in ("tokenizer", "mask")),
        shared / "durations",
        shared / "evaluator",
    ):
        place.mkdir(parents=True)
    tokenizer = TokenizerConfig("patch", 16, 8, 1, 2, codes=32, code_width=8, quantizers=quantizers, parts="limbs")
    config = TransformerConfig(width, 1, 4, 2 * width, dropout=0.0, codes=32, quantizers=quantizers, parts=5)
    model = MotionTokenizer(tokenizer, torch.zeros(263), 0.02 * torch.ones(263))
    for books in model.quantizers.buffers():
        if books.ndim == 3:
            books.normal_()
    weights.save(own / "tokenizer", tokenizer, model, {})
    facts = {"tokenizer": weights.digest(own / "tokenizer")}
    weights.save(own / "mask", config, MaskTransformer(config), facts)
    weights.save(shared / "durations", DurationsConfig(8), DurationModel(DurationsConfig(8)), {})
    evaluator = EvaluatorConfig(16, 1, 4, 8)
    weights.save(shared / "evaluator", evaluator, MotionTextEvaluator(evaluator), {})
    return folder
