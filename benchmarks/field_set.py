"""Are other people's words understood: the share of frames right over a hand-written set of prompts and captions.

python benchmarks/field_set.py --half dev --show

`field_set/README.md` says how the set is written. Silent: something of a sentence is lost and nothing is told. False
alarm: something is told or refused that should not be.
"""

import re
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from generator.registry import SHARED, WEIGHTS_FOLDER
from generator.text.frame import ActionFrame, Kind
from generator.text.understanding import Understanding
from ros_free_stack.errors import InvalidPrompt, OutOfDomain

FOLDER = Path(__file__).parent / "field_set"
CAPTION = "caption"
_KEYS: dict[str, Kind] = {"n": "count", "m": "distance", "deg": "angle", "s": "duration"}
_DEFAULTS = {"forward", "up"}
Half = Literal["dev", "held"]
Kindness = Literal["right", "wrong", "silent", "false alarm"]


@dataclass(frozen=True)
class Arguments:
    """Print the shares by half, prompts and captions apart."""

    half: Half | Literal["both"] = "both"
    """Which half to count."""
    show: bool = False
    """Print every sentence that is not right."""
    weights: Path = WEIGHTS_FOLDER
    """Folder of the weights, of which only the known texts are used."""


@dataclass(frozen=True)
class Wanted:
    """One right reading: moments of (names, details) pairs, words to be told, words to be refused for (None: no)."""

    moments: tuple[tuple[tuple[frozenset[str], dict[str, str]], ...], ...]
    told: tuple[str, ...] = ()
    refused: tuple[str, ...] | None = None


@dataclass(frozen=True)
class Sentence:
    style: str
    prompt: str
    wanted: tuple[Wanted, ...]


@dataclass(frozen=True)
class Found:
    """What was understood: moments, lines told, the refusal ("" for none)."""

    moments: tuple[tuple[ActionFrame, ...], ...]
    told: tuple[str, ...]
    refusal: str

    def __str__(self) -> str:
        if self.refusal:
            return f"refused: {self.refusal}"
        moments = " > ".join(" & ".join(_written(action) for action in moment) for moment in self.moments)
        return moments + "".join(f" ! {line}" for line in self.told)


def sentences(half: Half) -> list[Sentence]:
    """The sentences of one half."""
    lines = (FOLDER / f"{half}.tsv").read_text(encoding="utf-8").splitlines()
    rows = (line.split("\t") for line in lines if line and not line.startswith("#"))
    return [Sentence(style, prompt, tuple(map(_wanted, frame.split("||")))) for style, prompt, frame in rows]


def understood(understanding: Understanding, prompt: str) -> Found:
    """What becomes of a prompt."""
    try:
        found = understanding.read(prompt)
    except (InvalidPrompt, OutOfDomain) as error:
        return Found((), (), str(error))
    return Found(tuple(moment.actions for moment in found.moments), found.not_shown, "")


def outcome(sentence: Sentence, found: Found) -> Kindness:
    """Whether what was found is right, and if not, how it is wrong."""
    if any(_fits(wanted, found) for wanted in sentence.wanted):
        return "right"
    if found.refusal:
        known = all(wanted.refused is None for wanted in sentence.wanted)
        return "false alarm" if known else "wrong"
    same = [wanted for wanted in sentence.wanted if wanted.refused is None and _same_moments(wanted, found)]
    if any(len(found.told) > len(wanted.told) for wanted in same):
        return "false alarm"
    return "wrong" if found.told else "silent"


def main(arguments: Arguments) -> None:
    """Print the table, and what is not right."""
    understanding = Understanding(arguments.weights / SHARED)
    halves: tuple[Half, ...] = ("dev", "held") if arguments.half == "both" else (arguments.half,)
    print("| half | sentences | count | right | silent | false alarms |\n|---|---|---|---|---|---|")
    mistakes: list[str] = []
    for half in halves:
        for kind in ("prompts", "captions"):
            listed = [s for s in sentences(half) if (s.style == CAPTION) == (kind == "captions")]
            counts: Counter[str] = Counter()
            for sentence in listed:
                found = understood(understanding, sentence.prompt)
                result = outcome(sentence, found)
                counts[result] += 1
                if result != "right":
                    mistakes.append(f"{half} {sentence.style} {result}: {sentence.prompt}\n    {found}")
            shares = [f"{counts[name] / len(listed):.1%}" for name in ("right", "silent", "false alarm")]
            print(f"| {half} | {kind} | {len(listed)} | {' | '.join(shares)} |")
    if arguments.show:
        print("\n" + "\n".join(mistakes))


def _wanted(text: str) -> Wanted:
    text = text.strip()
    if text.startswith("?"):
        words = text[1:].strip()
        return Wanted((), refused=tuple(words.split("/")) if words else ())
    frame, _, told = text.partition("!")
    if "?" in frame:  # a refusal whatever else is in it
        return Wanted((), refused=())
    moments = tuple(tuple(_action(part) for part in moment.split("&")) for moment in frame.split(">"))
    return Wanted(moments, tuple(told.split()))


def _action(text: str) -> tuple[frozenset[str], dict[str, str]]:
    names, *details = text.split()
    return frozenset(names.split("/")), dict(detail.split("=") for detail in details)


def _fits(wanted: Wanted, found: Found) -> bool:
    if wanted.refused is not None:
        named = not wanted.refused or any(word in found.refusal for word in wanted.refused)
        return bool(found.refusal) and named
    told = " ".join(found.told)
    all_told = all(any(re.search(rf"\b{word}", told) for word in words.split("/")) for words in wanted.told)
    return _same_moments(wanted, found) and all_told and (not found.told or bool(wanted.told))


def _same_moments(wanted: Wanted, found: Found) -> bool:
    return len(wanted.moments) == len(found.moments) and all(
        len(pair) == len(actions) and _same_actions(pair, actions)
        for pair, actions in zip(wanted.moments, found.moments, strict=True)
    )


def _same_actions(pair: tuple[tuple[frozenset[str], dict[str, str]], ...], actions: tuple[ActionFrame, ...]) -> bool:
    """In any order."""
    rest = list(actions)
    for names, details in pair:
        fitting = [action for action in rest if action.action in names and _same_details(details, action)]
        if not fitting:
            return False
        rest.remove(fitting[0])
    return True


def _same_details(details: dict[str, str], action: ActionFrame) -> bool:
    way = details.get("dir", details.get("to", ""))
    way = action.way if way in action.words.split() and "to" in details else way
    if way != action.way and not {way, action.way} <= _DEFAULTS | {""}:
        return False
    if details.get("side", "") != action.side or details.get("speed", "") != action.speed:
        return False
    for key, kind in _KEYS.items():
        value, named = action.value(kind), details.get(key)
        if (value is None) != (named is None) or (value and named and abs(value - float(named)) > 0.02 * value):
            return False
    return True


def _written(action: ActionFrame) -> str:
    amounts = [f"{key}={action.value(kind):g}" for key, kind in _KEYS.items() if action.value(kind) is not None]
    details = [f"{name}={value}" for name, value in (("side", action.side), ("dir", action.way)) if value]
    speed = [f"speed={action.speed}"] if action.speed else []
    return " ".join([action.action, *details, *amounts, *speed])


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
