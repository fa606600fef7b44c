"""The subcommand `evaluate`."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from generator.registry import DEFAULT
from ros_free_stack.console import Command

if TYPE_CHECKING:
    from generator.evaluation.embedder import Embedder
    from generator.evaluation.evaluation import Evaluation
    from generator.evaluation.pairs import Pair
    from generator.evaluation.protocol import Score

ROWS = ("real", "reconstruction", "first", "resampled")


@dataclass(frozen=True, kw_only=True)
class Evaluate(Command):
    """Measure the generator: R-precision, FID, diversity and coherence, real motion first."""

    weights: Annotated[tuple[Path, ...], tyro.conf.UseAppendAction] = ()
    """Folder of trained models; name several to compare them. The ones that come with the program where not given."""
    generator: str = DEFAULT
    """Which of the generators in there: `segmo`, `momask`, `party` or `part-wise`."""
    dataset: Path | None = None
    """Folder of the motion data set (made by `data build`)."""
    official: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder with HumanML3D, GloVe and T2M's networks as published: the papers' own numbers, in place of a data set
    and an evaluator of this project."""
    evaluator: Path | None = None
    """Folder of a trained evaluator, perhaps of arms or legs alone; the one that comes with the program where not
    given."""
    split: Literal["train", "val", "test"] = "test"
    """Which clips."""
    clips: int | None = None
    """How many of them, drawn by the seed; all where not given."""
    rows: str = ",".join(ROWS)
    """What is measured: real motion, the model's reconstruction of it, its first samples for the texts as they are, and
    what `generate` writes: resampled where a motion does not show its text, with feet locked."""
    runs: int = 20
    """Runs over newly drawn pools, for the 95 % interval."""
    generations: int = 1
    """How often motions are generated; the papers do so for every run, which takes as many times as long."""
    multimodality: Annotated[int, tyro.conf.arg(metavar="TEXTS")] = 0
    """Also generate 30 motions for each of so many texts and measure how much they differ; papers take 100."""
    seed: int = 0
    """Seed of clips, captions, noise and pools."""
    device: str = "auto"
    """`cpu`, `cuda`, or `auto`: the GPU where there is one."""
    out: Path | None = None
    """Also write the result as JSON to this file."""

    def run(self) -> int:
        from generator.evaluation.evaluation import Evaluation
        from generator.evaluation.table import table
        from generator.registry import SHARED, WEIGHTS_FOLDER
        from generator.training.stages import choose_device
        from ros_free_stack.files import write_json

        wanted = self._checked_rows()
        device = choose_device(self.device)
        pairs, embedder = self._material(
            WEIGHTS_FOLDER / SHARED / "evaluator", device, split_texts=bool({"first", "resampled"} & set(wanted))
        )
        evaluation = Evaluation(pairs, embedder, runs=self.runs, seed=self.seed)
        rows = {"real": evaluation.real_scores()} if "real" in wanted else {}
        folders = self.weights or (WEIGHTS_FOLDER,)
        for folder in folders:
            place = _suffix(folder, folders)
            rows |= {f"{name}{place}": scores for name, scores in self._model_rows(evaluation, folder, wanted, device)}
        result = {
            "embedder": embedder.name,
            "clips": len(pairs),
            "distinct_captions": len({pair.text for pair in pairs}),
            "runs": self.runs,
            "generations": self.generations,
            "rows": {name: {metric: asdict(score) for metric, score in row.items()} for name, row in rows.items()},
        }
        if self.out:
            write_json(self.out, result)
        title = f"{embedder.name}, {len(pairs)} clips, {result['distinct_captions']} distinct captions, pools of 32"
        self.report(result, table(rows, title), *([f"wrote {self.out}"] if self.out else []))
        return 0

    def _model_rows(
        self, evaluation: "Evaluation", folder: Path, wanted: Sequence[str], device: str
    ) -> "Iterator[tuple[str, dict[str, Score]]]":
        """The wanted rows of the models in a folder."""
        from generator.performer import Performer

        if not set(wanted) - {"real"}:
            return
        performer = Performer.load(folder, generator=self.generator, device=device)
        if "reconstruction" in wanted and (scores := evaluation.reconstruction_scores(performer.model)):
            yield "reconstruction", scores
        for name in ("first", "resampled"):
            if name in wanted:
                yield (
                    name,
                    evaluation.generated_scores(
                        performer,
                        resampled=name == "resampled",
                        generations=self.generations,
                        multimodal_texts=self.multimodality,
                    ),
                )

    def _checked_rows(self) -> tuple[str, ...]:
        """The rows that are wanted, once the options are seen to be usable."""
        from ros_free_stack.errors import InvalidOption, UnknownName

        for option, value, least in (
            ("--runs", self.runs, 1),
            ("--generations", self.generations, 1),
            ("--multimodality", self.multimodality, 0),
        ):
            if value < least:
                raise InvalidOption(option, f"must be at least {least}, found {value}")
        if (self.dataset is None) == (self.official is None):
            raise InvalidOption("--dataset / --official", "give one of them: a data set folder, or the published files")
        if self.official is not None and self.evaluator is not None:
            raise InvalidOption("--evaluator", "does not go with --official, which brings its own")
        wanted = tuple(row.strip() for row in self.rows.split(","))
        for row in wanted:
            if row not in ROWS:
                raise UnknownName("row", row, ROWS)
        return wanted

    def _material(self, evaluator: Path, device: str, *, split_texts: bool) -> "tuple[Sequence[Pair], Embedder]":
        """What is measured, and the space it is measured in."""
        from generator.datasets.open_dataset import open_dataset
        from generator.datasets.published import PublishedMotions
        from generator.evaluation.embedder import CorpusEmbedder
        from generator.evaluation.official import OfficialEmbedder, OfficialFiles
        from generator.evaluation.pairs import corpus_pairs
        from generator.evaluation.published import published_pairs

        if self.official is None:
            assert self.dataset is not None
            embedder = CorpusEmbedder.load(self.evaluator or evaluator, device)
            dataset = open_dataset(self.dataset)
            return corpus_pairs(dataset, self.split, clips=self.clips, seed=self.seed), embedder
        files = OfficialFiles.find(self.official)
        embedder = OfficialEmbedder(files, device)
        data = PublishedMotions.open(files.dataset, split=self.split, segments=split_texts)
        return published_pairs(data, self.split, clips=self.clips, seed=self.seed), embedder


def _suffix(folder: Path, folders: Sequence[Path]) -> str:
    """What tells a folder's rows from the others': its name, or all of its path where two have the same name."""
    if len(folders) == 1:
        return ""
    unique = len({other.name for other in folders}) == len(folders)
    return f", {folder.name if unique else folder}"
