"""The subcommands `data build`, `data show` and `data coverage`."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import tyro

from ros_free_stack.console import Command


@dataclass(frozen=True, kw_only=True)
class DataBuild(Command):
    """Build the motion corpus: composed clips with features, segments and captions."""

    out: Path
    """Folder to make; it must not exist yet, or be empty."""
    clips: int = 20000
    """How many clips."""
    seed: int = 0
    """Seed of all randomness: the same seed gives the same bytes."""
    cmu: Annotated[Path | None, tyro.conf.arg(metavar="DIR")] = None
    """Folder with CMU takes and their index.json, to mix real motion in; without it all is authored."""
    workers: int = 2
    """Processes."""

    def run(self) -> int:
        from generator.corpus.build import build_dataset, describe

        manifest = build_dataset(self.out, clips=self.clips, seed=self.seed, cmu=self.cmu, workers=self.workers)
        self.report(manifest, f"wrote {self.out}: {describe(manifest)}")
        return 0


@dataclass(frozen=True, kw_only=True)
class DataShow(Command):
    """Draw one clip of a corpus as a row of poses and print its captions and segments."""

    dataset: Path
    """Folder written by `data build`."""
    clip: str
    """Id of the clip, e.g. 000012."""
    out: Path
    """PNG to write."""

    def run(self) -> int:
        from generator.corpus.draw import draw_motion
        from generator.datasets.authored import AuthoredCorpus
        from ros_free_stack.formats.features import decode

        data = AuthoredCorpus.open(self.dataset)
        clip = data.clip(self.clip)
        draw_motion(decode(data.features(clip)), self.out, clip.captions[0].text)
        captions = [caption.text for caption in clip.captions]
        segments = [f"{s.start:4d} .. {s.end:4d}  {s.text}  [arms: {s.arms}; legs: {s.legs}]" for s in clip.segments]
        self.report(asdict(clip), *captions, *segments)
        return 0


@dataclass(frozen=True, kw_only=True)
class DataCoverage(Command):
    """Measure which share of real captions the corpus' vocabulary covers, and what it lacks most."""

    captions: Annotated[Path, tyro.conf.arg(metavar="FILE")]
    """JSON file of real captions: {split: {clip: [[caption, start, end], ...]}}."""
    sample: int = 1000
    """How many captions to draw."""
    seed: int = 0
    """Seed of the draw."""

    def run(self) -> int:
        from generator.corpus.coverage import Speech, measure, read_captions, sample_captions
        from generator.text.splitter import Splitter
        from ros_free_stack.console import progress
        from ros_free_stack.errors import InvalidOption

        if self.sample < 1:
            raise InvalidOption("sample", f"expected at least 1, found {self.sample}")
        texts = sample_captions(read_captions(self.captions), self.sample, self.seed)
        found = measure(progress(texts, "splitting captions", len(texts)), Splitter().split, Speech())
        self.report(
            asdict(found),
            f"{found.covered_captions:.1%} of {found.captions} captions covered, "
            f"{found.covered_segments:.1%} of their {found.segments} segments; {found.unreadable} captions unreadable",
            "most often not covered:",
            *(f"{count:6d}  {said}" for said, count in found.uncovered),
        )
        return 0
