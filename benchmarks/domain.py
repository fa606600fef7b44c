"""How well known sentences are told from unknown ones: shares of two hand-written lists, and every mistake.

python benchmarks/domain.py --weights generator/weights

Each list is halved by a checksum of the sentence: rules and constants were chosen on the development half alone, the
held-out half was only ever counted. A sentence counts as accepted if the splitter and the check let all of it pass.
"""

import zlib
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import tyro

from generator.registry import SHARED, WEIGHTS_FOLDER
from generator.text.understanding import Understanding
from ros_free_stack.errors import InvalidPrompt, OutOfDomain

SENTENCES = Path(__file__).parent / "domain_sentences"
LISTS = {"known": True, "unknown": False}
HALVES = ("development", "held-out")


@dataclass(frozen=True)
class Arguments:
    """Print the share of correct answers for each half of each list, and the mistakes."""

    weights: Path = WEIGHTS_FOLDER
    """Folder of the weights, of which only the known texts are used."""


@dataclass(frozen=True)
class Outcome:
    """Which of the two lists and halves, how many sentences, and the wrongly answered ones."""

    name: str
    half: str
    count: int
    mistakes: tuple[str, ...]

    @property
    def share(self) -> float:
        """Correctly accepted or refused ones of all."""
        return 1.0 - len(self.mistakes) / self.count


def sentences(name: str, half: str) -> tuple[str, ...]:
    """The sentences of one half ("development" or "held-out") of a list ("known" or "unknown")."""
    lines = (SENTENCES / f"{name}.txt").read_text(encoding="utf-8").splitlines()
    return tuple(
        line for line in lines if line and line[0] != "#" and HALVES[zlib.crc32(line.encode()) % len(HALVES)] == half
    )


def accepted(understanding: Understanding, sentence: str) -> bool:
    """Whether a sentence would be generated without further ado."""
    try:
        understanding.segments(sentence)
    except (InvalidPrompt, OutOfDomain):
        return False
    return True


def outcomes(understanding: Understanding) -> tuple[Outcome, ...]:
    """All four lists, counted."""
    return tuple(
        Outcome(name, half, len(listed), tuple(s for s in listed if accepted(understanding, s) is not expected))
        for name, expected in LISTS.items()
        for half in HALVES
        for listed in (sentences(name, half),)
    )


def main(arguments: Arguments) -> None:
    """Print the table and the mistakes."""
    understanding = Understanding(arguments.weights / SHARED)
    accepted(understanding, "a person walks")  # loads parser and encoder
    start = perf_counter()
    counted = outcomes(understanding)
    elapsed = perf_counter() - start
    print("| list | half | sentences | correct |\n|---|---|---|---|")
    for outcome in counted:
        print(f"| {outcome.name} | {outcome.half} | {outcome.count} | {outcome.share:.1%} |")
    print(f"\n{elapsed / sum(outcome.count for outcome in counted) * 1e3:.0f} ms a sentence, parsing included")
    for outcome in counted:
        verdict = "refused" if LISTS[outcome.name] else "accepted"
        for sentence in outcome.mistakes:
            print(f"wrongly {verdict} ({outcome.half}): {sentence}")


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
