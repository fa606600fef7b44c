"""ParTY's stages so small that they train in a second."""

from pathlib import Path
from typing import Any

from generator.datasets.dataset import MotionDataset
from generator.registry import find_preset
from generator.training.stages import StageJob

SMALLER = (
    *(f"tokenizer.model.{k}={v}" for k, v in {
        "width": 24, "encoder_width": 12, "depth": 1, "codes": 16, "part_codes": 16, "code_width": 8, "groups": 2,
    }.items()),
    "tokenizer.objective.window=24",
    *(f"transformer.model.{k}={v}" for k, v in {
        "width": 16, "layers": 1, "part_layers": 1, "feed_forward": 32, "fusion_heads": 2, "fusion_head_width": 8,
    }.items()),
    "durations.model.width=16",
    *(f"evaluator.model.{k}={v}" for k, v in {"width": 16, "layers": 1, "embedding": 8}.items()),
    *(f"{stage}.training.{k}={v}" for stage in ("tokenizer", "transformer", "durations", "evaluator")
      for k, v in {"batch": 8, "iterations": 8, "warm_up": 2}.items()),
)  # fmt: skip
"""Changes to `party-small`, as `train --set` takes them."""


def tiny_party_job(stage: str, dataset: MotionDataset, out: Path, *changes: str, **options: Any) -> StageJob:
    """A stage of such a preset."""
    generator, preset = find_preset("party-small")
    chosen = preset.changed((*SMALLER, *changes))
    return StageJob(stage=stage, generator=generator, preset=chosen, dataset=dataset, out=out, **options)
