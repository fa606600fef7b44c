"""What guidance, text grounding, fusion and the whole body each add to ParTY, at equal training.

python benchmarks/party.py --dataset data/corpus --weights runs/party --out runs/party-rows

Tables 5, 6, S2, S13 and S17 of the paper. Every row is trained several times, from other initial weights and on other
batches, with the tokenizer of WEIGHTS; the part-wise baseline trains its own. OUT/ROW/SEED is a folder of weights for
`launch.py evaluate --generator`. First samples are scored, each row's mean with the spread between its trainings, for
the whole body and for every part that has an evaluator in WEIGHTS/shared/evaluator-PART. A row that was trained and
scored before is not trained again.
"""

import json
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
import tyro

from generator import weights
from generator.bodies import PARTS, WHOLE
from generator.datasets.dataset import MotionDataset
from generator.datasets.open_dataset import open_dataset
from generator.evaluation.embedder import CorpusEmbedder
from generator.evaluation.evaluation import Generation
from generator.evaluation.pairs import Features, Pair, corpus_pairs
from generator.evaluation.protocol import MotionSet, score
from generator.performer import Performer
from generator.registry import SHARED, find_preset
from generator.training.stages import StageJob, choose_device
from ros_free_stack.errors import StackError, UnknownName
from ros_free_stack.files import make_folder, write_json

ROWS: dict[str, tuple[str, ...]] = {
    "party": (),
    "no-guidance": ("model.guidance=false",),
    "no-grounding": ("model.embeddings=0",),
    "no-fusion": ("model.fusion=false",),
    "whole-body": ("model.guidance=false", "model.fusion=false", "model.embeddings=0"),
    "no-part-texts": ("objective.auxiliary=0.0",),
    **{f"embeddings-{count}": (f"model.embeddings={count}",) for count in (1, 2, 8)},
    **{f"cycle-{count}": (f"model.cycle={count}", f"model.part_cycle={count}") for count in (1, 2, 5)},
    "part-wise": (),
}
"""Changes to the transformer of `party-small`; the last one is a generator of its own."""

PART_WISE = "part-wise"
METRICS = ("top1", "top2", "top3", "fid", "mm_dist")
COHERENCE = ("tc", "sc")

Values = dict[str, float]


@dataclass(frozen=True, kw_only=True)
class Arguments:
    """Train the rows and print what their first samples score."""

    dataset: Path
    """Folder of the motion data set."""
    weights: Path
    """Folder with ParTY's trained tokenizer, and what all generators share."""
    out: Path
    """Folder for the weights and scores of all rows."""
    iterations: int = 6000
    """Of each training."""
    seeds: int = 3
    """Trainings of each row."""
    rows: tuple[str, ...] = tuple(ROWS)
    """Which rows."""
    clips: int | None = None
    """How many clips of the test split to score; all where not given."""
    set: tuple[str, ...] = ()
    """Further changes to every row, such as transformer.training.batch=32."""
    runs: int = 20
    """Runs over newly drawn pools."""
    device: str = "auto"
    """`cpu`, `cuda`, or `auto`."""


class Table:
    """Trains rows and scores them."""

    def __init__(self, arguments: Arguments) -> None:
        self._arguments, self._device = arguments, choose_device(arguments.device)
        self._dataset: MotionDataset = open_dataset(arguments.dataset)
        self._pairs: Sequence[Pair] = corpus_pairs(self._dataset, "test", clips=arguments.clips, seed=0)
        shared = arguments.weights / SHARED
        folders = {WHOLE: shared / "evaluator", **{part: shared / f"evaluator-{part}" for part in PARTS}}
        self._embedders = {
            body: CorpusEmbedder.load(folder, self._device)
            for body, folder in folders.items()
            if body == WHOLE or folder.is_dir()
        }
        real = [pair.features for pair in self._pairs]
        self._texts = {body: embedder.texts(self._pairs) for body, embedder in self._embedders.items()}
        self._real = {body: MotionSet.measure(real, embedder) for body, embedder in self._embedders.items()}

    def real(self) -> Values:
        """Scores of the real motions."""
        return self._scores([pair.features for pair in self._pairs])

    def row(self, name: str, seed: int) -> Values:
        """Scores of one training of a row, trained and measured unless it was before."""
        folder = self._arguments.out / name / str(seed)
        result = folder / "scores.json"
        if not result.is_file():
            self._train(name, seed, folder)
            performer = Performer.load(folder, generator=_owner(name), device=self._device)
            generation = Generation(performer, self._pairs, resampled=False)
            motions = generation.motions(range(len(self._pairs)), seed=seed, title=f"{name} {seed}")
            write_json(result, self._scores(motions))
        return json.loads(result.read_text(encoding="utf-8"))

    def _scores(self, motions: Sequence[Features]) -> Values:
        found = Values()
        for body, embedder in self._embedders.items():
            measured = MotionSet.measure(motions, embedder)
            scores = score(self._texts[body], self._real[body], [measured], runs=self._arguments.runs, seed=0)
            prefix = "" if body == WHOLE else f"{body}_"
            found |= {f"{prefix}{metric}": scores[metric].mean for metric in METRICS}
            found |= {metric: scores[metric].mean for metric in COHERENCE}
        return found

    def _train(self, name: str, seed: int, folder: Path) -> None:
        arguments, owner = self._arguments, _owner(name)
        shutil.copytree(arguments.weights / SHARED, make_folder(folder) / SHARED, dirs_exist_ok=True)
        stages = ["transformer"]
        if name == PART_WISE:
            stages = ["tokenizer", *stages]
        else:
            source = arguments.weights / owner / "tokenizer"
            weights.load(source, "tokenizer")  # before anything is copied
            shutil.copytree(source, folder / owner / "tokenizer", dirs_exist_ok=True)
        generator, preset = find_preset(PART_WISE if name == PART_WISE else "party-small")
        preset = preset.changed([*(f"transformer.{change}" for change in ROWS[name]), *arguments.set])
        for stage in stages:
            torch.manual_seed(seed)
            StageJob(
                stage=stage,
                generator=generator,
                preset=preset,
                dataset=self._dataset,
                out=folder,
                iterations=arguments.iterations,
                device=self._device,
                seed=seed,
            ).run()


def _owner(name: str) -> str:
    return PART_WISE if name == PART_WISE else "party"


def _line(name: str, trainings: Sequence[Mapping[str, float]]) -> str:
    """A row of the table: each score's mean, and half of its 95 % interval over the trainings."""
    cells = []
    for metric in trainings[0]:
        values = [training[metric] for training in trainings]
        spread = 1.96 * float(np.std(values)) / len(values) ** 0.5
        cells.append(f"{np.mean(values):.3f}" + (f" ±{spread:.3f}" if len(values) > 1 else ""))
    return f"| {' | '.join((name, *cells))} |"


def main(arguments: Arguments) -> None:
    for name in arguments.rows:
        if name not in ROWS:
            raise UnknownName("row", name, ROWS)
    table = Table(arguments)
    real = table.real()
    print(f"| | {' | '.join(real)} |\n|{'---|' * (len(real) + 1)}\n{_line('real', [real])}")
    for name in arguments.rows:
        print(_line(name, [table.row(name, seed) for seed in range(arguments.seeds)]))


if __name__ == "__main__":
    try:
        main(tyro.cli(Arguments, description=__doc__))
    except StackError as error:
        raise SystemExit(f"error: {error}") from None
