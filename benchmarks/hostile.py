"""Strings that nobody should send: no crash, and how long the slowest takes.

python benchmarks/hostile.py --count 2000
"""

import random
import string
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import tyro

from generator.registry import SHARED, WEIGHTS_FOLDER
from generator.text.understanding import Understanding
from ros_free_stack.errors import StackError

_WORDS = (Path(__file__).parents[1] / "generator/text/contrast.txt").read_text(encoding="utf-8").split()
_TURNS = [
    "wave",
    "walk",
    "turn",
    "bow",
    "while",
    "and",
    "then",
    "after",
    "before",
    "twice",
    "left",
    "right",
    "the",
    "a",
    "with",
    "hand",
    "arm",
    ",",
    ".",
    ";",
    "!",
    "?",
    "no",
    "wait",
]
_ODD = "\x00\u200b\u202e\ufeff🤖👋é中文العربية\\{}[]()%$#@^&*~`|<>\"'\n\t"
_PATTERNS = ("a{n}", "({n})", "%s{n}", "../{n}", "{{{n}}}", "${{{n}}}", "1e{n}", "-{n}", "{n} times {n}", "wave {n} m")


@dataclass(frozen=True)
class Arguments:
    """Feed strings to the understanding and count what becomes of them."""

    count: int = 2000
    """How many."""
    seed: int = 0
    """Of the strings."""


def strings(count: int, seed: int) -> list[str]:
    """Empty ones, noise, nested grammar, numbers, half words, markup, very long ones."""
    rng = random.Random(seed)
    makers = (
        lambda: "".join(rng.choices(string.printable, k=rng.randint(0, 600))),
        lambda: " ".join(rng.choices(_TURNS, k=rng.randint(1, 90))),
        lambda: " ".join(rng.choices(_WORDS, k=rng.randint(1, 60))),
        lambda: "".join(rng.choices(_ODD + string.ascii_lowercase, k=rng.randint(1, 80))),
        lambda: rng.choice(_PATTERNS).format(n=rng.choice((0, -1, 10**9, 10**30, "nan", "inf", "½"))),
        lambda: rng.choice(_TURNS) * rng.randint(1, 200),
        lambda: ", no, wait, ".join(rng.choices(_TURNS, k=rng.randint(2, 25))),
        lambda: " then ".join(["walk"] * rng.randint(1, 60)),
        lambda: "the left " * rng.randint(1, 50) + "hand",
        lambda: " ".join(
            f"{rng.randint(0, 10**6)} {rng.choice(('m', 'times', 'degrees', 's', 'feet', ''))}" for _ in range(9)
        ),
    )
    return [rng.choice(makers)() for _ in range(count)]


def main(arguments: Arguments) -> None:
    """Print what became of the strings, and the slowest."""
    understanding = Understanding(WEIGHTS_FOLDER / SHARED)
    understanding.read("wave, then bow")  # loads parser and encoder
    ends: Counter[str] = Counter()
    slowest = (0.0, "")
    for text in strings(arguments.count, arguments.seed):
        start = perf_counter()
        try:
            understanding.read(text)
            end = "read"
        except StackError as error:
            end = type(error).__name__
        except Exception as error:  # what this program is for
            end = f"CRASH {type(error).__name__}: {error} in {text[:120]!r}"
        ends[end] += 1
        slowest = max(slowest, (perf_counter() - start, text))
    for end, number in ends.most_common():
        print(f"{number:6d}  {end}")
    print(f"slowest: {slowest[0]:.2f} s for {slowest[1][:80]!r}")


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
