"""What segments, alignment, segmentation and layout each add (SegMo, table 3 and figure 4), at equal training.

python benchmarks/ablation.py --dataset data/corpus --weights runs/small --out runs/ablation

Every row is a mask transformer of one small size, trained for as many iterations on the same batches. OUT/ROW is a
folder of weights for `launch.py evaluate --weights`, in which all rows share tokenizer and durations.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
import torch
import tyro

from generator import weights
from generator.config import AlignmentKind, SegmentationKind, Training
from generator.datasets.authored import AuthoredCorpus
from generator.grounding.consistency import consistency, paired_segments
from generator.models.segmo.config import TOKEN_S, ConditioningKind, MaskLosses, TokenizerConfig, TransformerConfig
from generator.models.segmo.mask_transformer import MaskTransformer
from generator.models.segmo.objectives.batches import TokenBatches, TokenCorpus
from generator.models.segmo.objectives.mask import MaskObjective
from generator.models.segmo.objectives.segmentation_table import first_captions, segmentation_table
from generator.models.segmo.parts import part_count
from generator.models.segmo.segmentation import boundary_errors, boundary_iou
from generator.registry import DEFAULT, SHARED
from generator.training.loop import CHECKPOINT, Objective, Run, train
from ros_free_stack.console import say
from ros_free_stack.errors import InvalidFile, StackError, UnknownName
from ros_free_stack.files import make_folder, write_json

SEGMENTATIONS: tuple[SegmentationKind, ...] = ("uniform", "change-point", "clustering", "exact")
RESULT = "result.json"
ALIKE = (f"{DEFAULT}/tokenizer", SHARED)
"""What all rows share."""


@dataclass(frozen=True)
class Row:
    """What is special about one row; the segmentation is that of the alignment."""

    conditioning: ConditioningKind
    alignment: AlignmentKind
    segmentation: SegmentationKind = "uniform"
    layout: Literal["exact", "uniform"] = "exact"
    sentence_dropout: float = 0.0


ROWS: dict[str, Row] = {
    "momask": Row("sentence", "none"),
    "segmo-none": Row("segments", "none"),
    "segmo-global": Row("segments", "global"),
    "segmo-batch": Row("segments", "batch"),
    "segmo-token": Row("segments", "token"),
    "segmo": Row("segments", "segment"),
    "segmo-change-point": Row("segments", "segment", "change-point"),
    "segmo-clustering": Row("segments", "segment", "clustering"),
    "segmo-exact": Row("segments", "segment", "exact"),
    "layout-uniform": Row("layout", "segment", "uniform", "uniform"),
    "layout-exact": Row("layout", "segment", "exact"),
    "layout-exact-dropout": Row("layout", "segment", "exact", sentence_dropout=0.2),
}
"""Each differs from its neighbour in one thing; the last one is how the presets are trained."""


@dataclass(frozen=True, kw_only=True)
class Arguments:
    """Train the rows of the ablation and print what their losses and segments came to."""

    dataset: Path
    """Folder of the motion data set."""
    weights: Path
    """Folder of trained models; all but the mask transformer are shared by all rows."""
    out: Path
    """Folder for the weights of all rows."""
    iterations: int = 2000
    """Of each row."""
    batch: int = 64
    rows: tuple[str, ...] = tuple(ROWS)
    """Which rows."""
    width: int = 128
    layers: int = 3
    threads: int = 1
    device: str = "cpu"
    seed: int = 0
    resume: bool = False
    """Go on in a folder that holds some rows: finished ones are left alone, begun ones go on."""


@dataclass(frozen=True)
class Ablation:
    """The rows with what they share."""

    arguments: Arguments
    corpus: TokenCorpus
    tokenizer: TokenizerConfig

    def transformer(self, row: Row) -> TransformerConfig:
        """All rows have the same size."""
        return TransformerConfig(
            self.arguments.width,
            self.arguments.layers,
            4,
            2 * self.arguments.width,
            dropout=0.0,
            codes=self.tokenizer.codes,
            quantizers=self.tokenizer.quantizers,
            parts=part_count(self.tokenizer.parts),
            conditioning=row.conditioning,
            layout=row.layout,
            sentence_dropout=row.sentence_dropout,
        )

    def training(self) -> Training:
        """All rows are trained alike."""
        return Training(self.arguments.batch, self.arguments.iterations, 1e-3)

    def train_row(self, name: str) -> dict[str, Any]:
        """Train a row, link what it shares, measure its segments; what was found."""
        row, folder = ROWS[name], make_folder(self.arguments.out / name)
        self._link_shared(folder)
        torch.manual_seed(self.arguments.seed)
        training, config = self.training(), self.transformer(row)
        losses = MaskLosses(row.alignment, segmentation=row.segmentation)
        end = self._train(MaskObjective(self.corpus, config, training, losses, self.arguments.seed), training, name)
        result = {"row": asdict(row), "training": asdict(training), "end": end, "consistency": self._consistency(name)}
        write_json(folder / RESULT, result)
        return result

    def _train(self, objective: Objective, training: Training, name: str) -> dict[str, float]:
        folder = self.arguments.out / name / DEFAULT / objective.name
        resume = self.arguments.resume and (folder / CHECKPOINT).is_file()
        say(f"{name}: {objective.name}")
        end = train(
            objective,
            training,
            folder,
            Run(self.arguments.iterations, device=self.arguments.device, seed=self.arguments.seed, resume=resume),
        )
        if not end["finished"]:
            raise KeyboardInterrupt
        return end

    def _link_shared(self, folder: Path) -> None:
        """Links to the models that all rows share."""
        make_folder(folder / DEFAULT)
        for name in ALIKE:
            source = self.arguments.weights / name
            if source.exists() and not (folder / name).is_symlink():
                (folder / name).symlink_to(source.resolve(), target_is_directory=source.is_dir())

    def _consistency(self, name: str) -> dict[str, dict[str, float]]:
        """ISC on the test split under each segmentation; nothing for a model without segments."""
        saved = weights.load(self.arguments.out / name / DEFAULT / "mask", "mask")
        model = MaskTransformer(saved.config_as(TransformerConfig))
        if model.config.conditioning == "sentence":
            return {}
        saved.fill(model)
        model.eval()
        found = {}
        for kind in SEGMENTATIONS:
            batches = TokenBatches(
                self.corpus, batch=self.arguments.batch, layout=model.config.layout, segmentation=kind, seed=0
            )
            text, motion = paired_segments(model, batches.batches(self.corpus.test))
            found[kind] = asdict(consistency(text, motion))
        return found


def segmentation_rows(dataset: AuthoredCorpus) -> list[tuple[str, float, float, float]]:
    """Name, mean IoU with the true segments, mean and variance of boundary errors in s, on clips of two or more."""
    chosen = np.array([clip.split == "test" and len(clip.segments) > 1 for clip in dataset.clips])
    true, rows = first_captions(dataset, segmentation_table(dataset, "exact"))[chosen], []
    for kind in SEGMENTATIONS:
        found = first_captions(dataset, segmentation_table(dataset, kind))[chosen]
        errors = boundary_errors(found, true) * TOKEN_S
        rows.append((kind, boundary_iou(found, true)[true > 0].mean(), errors.mean(), errors.var()))
    return rows


def show(results: dict[str, dict[str, Any]], segmentations: Sequence[tuple[str, float, float, float]]) -> None:
    """Print the three tables."""
    print("| row | validation mask loss | accuracy | alignment loss | s/iteration |\n|---|---|---|---|---|")
    for name, result in results.items():
        end = result["end"]
        aligned = f"{end['validation_alignment']:.3f}" if "validation_alignment" in end else ""
        print(
            f"| {name} | {end['validation_mask']:.3f} | {end['validation_accuracy']:.1%} | {aligned} "
            f"| {end['seconds'] / end['iteration']:.3f} |"
        )
    print(f"\n| ISC (CV), trained as | {' | '.join(SEGMENTATIONS)} |\n|---{'|---' * len(SEGMENTATIONS)}|")
    for name, result in results.items():
        cells = [result["consistency"].get(kind) for kind in SEGMENTATIONS]
        if all(cells):
            print(f"| {name} | " + " | ".join("{mean:.3f} ({variation:.2f})".format(**cell) for cell in cells) + " |")
    print("\n| segmentation | IoU with the true segments | boundary error, s | its variance, s^2 |\n|---|---|---|---|")
    for kind, iou, error, variance in segmentations:
        print(f"| {kind} | {iou:.3f} | {error:.3f} | {variance:.3f} |")


def run(arguments: Arguments) -> dict[str, dict[str, Any]]:
    """Train what is not finished yet; the results of all rows asked for.

    Raises:
        UnknownName: there is no such row.
        InvalidFile: the output folder holds a row already, and going on was not asked for.
    """
    for name in arguments.rows:
        if name not in ROWS:
            raise UnknownName("row", name, ROWS)
        if (arguments.out / name).exists() and not arguments.resume:
            raise InvalidFile(arguments.out / name, "exists already; --resume goes on, or give a new folder")
    finished = {name: arguments.out / name / RESULT for name in arguments.rows}
    missing = [name for name, path in finished.items() if not path.is_file()]
    if missing:
        dataset = AuthoredCorpus.open(arguments.dataset)
        saved = weights.load(arguments.weights / DEFAULT / "tokenizer", "tokenizer")
        corpus = TokenCorpus.build(dataset, arguments.weights / DEFAULT / "tokenizer", arguments.device)
        ablation = Ablation(arguments, corpus, saved.config_as(TokenizerConfig))
        for name in missing:
            ablation.train_row(name)
    return {name: json.loads(path.read_text(encoding="utf-8")) for name, path in finished.items()}


def main(arguments: Arguments) -> None:
    """Train and print."""
    torch.set_num_threads(arguments.threads)
    try:
        show(run(arguments), segmentation_rows(AuthoredCorpus.open(arguments.dataset)))
    except StackError as error:
        raise SystemExit(f"error: {error}") from None


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
