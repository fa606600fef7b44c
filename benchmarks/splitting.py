"""How well prompts are split into segments, on the hand-checked gold set: the splitter, or a language model.

python benchmarks/splitting.py --half held-out
python benchmarks/splitting.py --llm http://127.0.0.1:11434/v1 --llm-model qwen3:8b
"""

import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from generator.text.splitter import PERSON
from generator.text.understanding import Segmenter, segmenter
from ros_free_stack.errors import InvalidPrompt

GOLD = Path(__file__).parents[1] / "tests" / "generator" / "splitting_gold.tsv"
HALVES = ("dev", "held-out")


@dataclass(frozen=True)
class Arguments:
    """Split every sentence of the gold set and count what is right."""

    half: Literal["dev", "held-out", "both"] = "both"
    """The half that the splitter was tuned on, the one that it was not, or each in turn."""
    llm: str | None = None
    """Ask this OpenAI-compatible endpoint instead of the splitter."""
    llm_model: str = "qwen3:8b"
    """The endpoint's model."""
    failures: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Show each sentence of the half that was split otherwise."""
    json: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Print one JSON object."""


@dataclass(frozen=True)
class Case:
    """A prompt with the segments that a person gave it."""

    kind: str
    prompt: str
    expected: tuple[str, ...]


@dataclass(frozen=True)
class Outcome:
    """What came of a prompt: its segments, none where it was refused, and whether a fall-back made them."""

    case: Case
    found: tuple[str, ...]
    fell_back: bool

    @property
    def exact(self) -> bool:
        return self.found == self.case.expected


def cases(half: str, path: Path = GOLD) -> tuple[Case, ...]:
    """One half of the gold set."""
    rows = (line.split("\t") for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("#"))
    return tuple(
        Case(kind, prompt, tuple(f"{PERSON} {text.strip()}" for text in segments.split("|")))
        for row_half, kind, prompt, segments in rows
        if row_half == half
    )


def split(case: Case, reader: Segmenter) -> Outcome:
    """Split one prompt; a refusal counts as no segments."""
    try:
        reading = reader.read(case.prompt)
    except InvalidPrompt:
        return Outcome(case, (), fell_back=False)
    return Outcome(case, reading.segments, reading.fell_back)


def scores(outcomes: Iterable[Outcome]) -> dict[str, float]:
    """Share of prompts right to the letter and in the number of segments; F1 over segments that agree to the letter."""
    outcomes = list(outcomes)
    common = sum((Counter(o.found) & Counter(o.case.expected)).total() for o in outcomes)
    total = sum(len(o.found) + len(o.case.expected) for o in outcomes)
    return {
        "sentences": len(outcomes),
        "exact": sum(o.exact for o in outcomes) / len(outcomes),
        "number": sum(len(o.found) == len(o.case.expected) for o in outcomes) / len(outcomes),
        "f1": 2 * common / total,
        "fell_back": sum(o.fell_back for o in outcomes) / len(outcomes),
    }


def main(arguments: Arguments) -> None:
    """Print the table."""
    reader = segmenter(arguments.llm, arguments.llm_model)
    halves = HALVES if arguments.half == "both" else (arguments.half,)
    outcomes = {half: [split(case, reader) for case in cases(half)] for half in halves}
    if arguments.json:
        print(json.dumps({half: scores(found) for half, found in outcomes.items()}, indent=2))
        return
    print("| half | kind | sentences | exact | number | F1 | fell back |\n|---|---|---|---|---|---|---|")
    for half, found in outcomes.items():
        for kind in (*dict.fromkeys(o.case.kind for o in found), "all"):
            row = scores(o for o in found if kind in {o.case.kind, "all"})
            shares = " | ".join(f"{row[key]:.3f}" for key in ("exact", "number", "f1", "fell_back"))
            print(f"| {half} | {kind} | {row['sentences']} | {shares} |")
    if arguments.failures:
        for outcome in (o for found in outcomes.values() for o in found if not o.exact):
            print(f"\n{outcome.case.prompt}\n  want {outcome.case.expected}\n  have {outcome.found}")


if __name__ == "__main__":
    main(tyro.cli(Arguments))
