"""Whether generated motion does what the words say, in compositions that training never showed.

python benchmarks/probes.py --weights generator/weights --dataset data/corpus --seeds 5

Sentences join actions whose ordered pair belongs to the test split; two actions at the same time are not split so, and
training may have shown them. Real motion of the test split, probed in the same way, is the ceiling.
"""

import json
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import tyro

from generator.corpus.actions import ACTIONS
from generator.corpus.build import pair_split
from generator.corpus.captions import segment_text, together
from generator.corpus.vocabulary.english import Phrase
from generator.corpus.vocabulary.entry import Draw, Params, Voice
from generator.corpus.words import VOCABULARY, entry
from generator.datasets.authored import AuthoredCorpus
from generator.datasets.dataset import Clip
from generator.performer import Performer, PerformerSettings
from generator.probes.checks import MotionChecks, Wanted, check_motion, probe
from generator.probes.named import named
from generator.probes.signals import Signals
from generator.ranking import Ranker
from generator.registry import WEIGHTS_FOLDER
from ros_free_stack.console import progress
from ros_free_stack.errors import UnknownName
from ros_free_stack.formats.features import decode
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import FPS

KINDS: Final = ("single", "two in order", "three in order", "four in order", "reversed", "simultaneous")
_LENGTHS: Final = {"single": 1, "two in order": 2, "three in order": 3, "four in order": 4, "reversed": 2}
_LEFT_OUT: Final = ("stand", "stand_up", "sit_down")
"""Standing shows nothing; sitting and standing up depend on what came before."""

Named = tuple[tuple[str, Params], ...]


@dataclass(frozen=True)
class Arguments:
    """Probe generated motion, and real motion where a data set is given."""

    weights: Path = WEIGHTS_FOLDER
    """Folder of the trained models."""
    dataset: Path | None = None
    """Data set whose test split is probed too."""
    seeds: int = 1
    """How many times all kinds of sentence are drawn and generated."""
    sentences: int = 60
    """Sentences of each kind for one seed."""
    candidates: int = 1
    """Motions generated for each sentence; the evaluator chooses among them."""
    rounds: int = PerformerSettings.rounds
    """How often what does not show its text is sampled again; 0 takes the first sample."""
    clips: int = 600
    """Clips of real motion."""
    segments: Literal["given", "split"] = "given"
    """Segments as written, or as the splitter finds them in the sentence."""
    actions: tuple[str, ...] = ()
    """Use these actions only, for weights that know fewer than the vocabulary."""
    json: bool = False
    """Print one JSON object."""


@dataclass(frozen=True)
class Sentence:
    """A prompt with its segment texts in temporal order, and what each has to show."""

    kind: str
    prompt: str
    texts: tuple[str, ...]
    wanted: tuple[Named, ...]


@dataclass
class Tally:
    """Shares of what was right, by kind of sentence, by action and by modifier: [right, asked]."""

    cells: dict[str, dict[str, list[int]]] = field(
        default_factory=lambda: defaultdict(lambda: defaultdict(lambda: [0, 0]))
    )

    def note(self, table: str, row: str, right: bool) -> None:
        cell = self.cells[table][row]
        cell[0] += right
        cell[1] += 1

    def add(self, kind: str, wanted: tuple[Named, ...], checks: MotionChecks | None) -> None:
        """Note one motion; None where the sentence was split into another number of segments."""
        self.note("actions of a sentence", kind, checks is not None and checks.present)
        self.note("sentence with all details", kind, checks is not None and checks.passed)
        if checks is None:
            return
        for named_actions, found in zip(wanted, checks.segments, strict=True):
            for (action, params), check in zip(named_actions, found, strict=True):
                self.note("action", action, check.action)
                if not check.action:
                    continue
                for name, right, row in (
                    ("side", check.side, params.get("side")),
                    ("count", check.count, f"{params.get('count')}"),
                    ("direction", check.direction, probe(action).wanted(params)),
                    ("how far", check.extent, action),
                ):
                    if right is not None:
                        self.note(name, "all", right)
                        self.note(name, str(row), right)

    def shares(self) -> dict[str, dict[str, float]]:
        return {
            table: {row: right / asked for row, (right, asked) in rows.items()} for table, rows in self.cells.items()
        }


def draw_sentence(kind: str, names: tuple[str, ...], rng: np.random.Generator) -> Sentence:
    """A sentence of that kind about unseen pairs of the given actions."""
    voice = Voice()
    draw = Draw(rng, brief=kind in ("three in order", "four in order"))
    if kind == "simultaneous":
        legs = _pick([name for name in names if ACTIONS[name].part == "legs"], rng)
        arms = _pick([name for name in names if ACTIONS[name].part == "arms"], rng)
        deeds = [(name, entry(name).sample(draw)) for name in (legs, arms)]
        below, above = (entry(name).phrase(params, voice, rng) for name, params in deeds)
        both = together(below, above, rng)
        text = segment_text(both)
        return Sentence(kind, text, (text,), (_named(deeds, text),))
    chain = _unseen(names, _LENGTHS[kind], rng)
    deeds = [(name, entry(name).sample(draw)) for name in chain]
    phrases = [entry(name).phrase(params, voice, rng) for name, params in deeds]
    texts = tuple(segment_text(phrase) for phrase in phrases)
    wanted = tuple(_named([deed], text) for deed, text in zip(deeds, texts, strict=True))
    return Sentence(kind, _prompt(kind, phrases, rng), texts, wanted)


def _pick(choices: list[str], rng: np.random.Generator) -> str:
    return choices[int(rng.integers(len(choices)))]


def _named(deeds: list[tuple[str, Params]], text: str) -> Named:
    return tuple((name, named(probe(name), params, text)) for name, params in deeds)


def _unseen(names: tuple[str, ...], count: int, rng: np.random.Generator) -> list[str]:
    """A chain of actions each of which training never showed after the one before."""
    while True:
        chain = [_pick(list(names), rng)]
        while len(chain) < count:
            following = [n for n in names if n not in chain and pair_split(chain[-1], n) == "test"]
            if not following:
                break
            chain.append(_pick(following, rng))
        if len(chain) == count:
            return chain


def _prompt(kind: str, phrases: list[Phrase], rng: np.random.Generator) -> str:
    if kind == "reversed":
        first, second = phrases
        return _pick(
            [f"before {second.gerund}, a person {first.third}", f"a person {second.third} after {first.gerund}"], rng
        )
    *before, last = [phrase.third for phrase in phrases]
    return f"a person {', '.join(before)}, then {last}" if before else f"a person {last}"


def probe_generated(arguments: Arguments) -> Tally:
    """Generate every sentence and probe one motion of each."""
    generator = Performer.load(arguments.weights)
    ranker = Ranker.load(arguments.weights) if arguments.candidates > 1 else None
    names = tuple(name for name in arguments.actions or tuple(VOCABULARY) if name not in _LEFT_OUT)
    split = _splitter() if arguments.segments == "split" else None
    drawn = [
        (seed, draw_sentence(kind, names, np.random.default_rng([seed, number, index])))
        for seed in range(arguments.seeds)
        for number, kind in enumerate(KINDS)
        for index in range(arguments.sentences)
    ]
    tally, settings = Tally(), PerformerSettings(rounds=arguments.rounds)
    for seed, sentence in progress(drawn, "generating", total=len(drawn)):
        texts = split(sentence.prompt) if split else sentence.texts
        if len(texts) != len(sentence.texts):
            tally.add(sentence.kind, sentence.wanted, None)
            continue
        motions = generator.generate(
            sentence.prompt, texts, seed=seed, candidates=arguments.candidates, settings=settings
        )
        motion = motions[int(np.argmin(ranker.distances(sentence.prompt, motions)))] if ranker else motions[0]
        tally.add(sentence.kind, sentence.wanted, _check(motion, sentence.wanted))
    return tally


def _splitter() -> Any:
    from generator.text.splitter import Splitter

    return Splitter().split


def _check(motion: HumanMotion, wanted: tuple[Named, ...]) -> MotionChecks:
    frames = len(motion.joints)
    windows = [(round(s.start_s * FPS), min(frames, round(s.end_s * FPS))) for s in motion.segments]
    segments = tuple(Wanted(window, actions) for window, actions in zip(windows, wanted, strict=True))
    return check_motion(Signals.of(motion.joints), segments)


def probe_real(dataset: Path, limit: int) -> Tally:
    """Probe authored clips of the test split, with what their first caption names."""
    corpus, tally = AuthoredCorpus.open(dataset), Tally()
    clips = tuple(_usable(corpus.split("test")))
    chosen = np.random.default_rng(0).permutation(len(clips))[:limit]
    for index in progress(chosen, "probing real motion", total=len(chosen)):
        clip = clips[index]
        texts = clip.captions[0].segments
        wanted = tuple(_named(list(s.actions), text) for s, text in zip(clip.segments, texts, strict=True))
        segments = tuple(Wanted((s.start, s.end), w) for s, w in zip(clip.segments, wanted, strict=True))
        checks = check_motion(Signals.of(decode(corpus.features(clip))), segments)
        kind = "simultaneous" if len(clip.segments[0].actions) == 2 else KINDS[len(clip.segments) - 1]
        tally.add(kind, wanted, checks)
    return tally


def _usable(clips: tuple[Clip, ...]) -> Iterator[Clip]:
    """One to four segments of actions that have probes; at the same time only where there is a single segment."""
    for clip in clips:
        names = [name for segment in clip.segments for name, _ in segment.actions]
        longest = 1 if len(names) > len(clip.segments) else 4
        if clip.source == "authored" and len(clip.segments) <= longest and all(name in VOCABULARY for name in names):
            yield clip


def render(generated: Tally, real: Tally) -> str:
    """Markdown tables: what was asked, of real and of generated motion."""
    lines: list[str] = []
    shares, ceiling = generated.shares(), real.shares()
    for table, rows in shares.items():
        lines += [f"| {table} | real | generated | asked |", "|---|---|---|---|"]
        order = [kind for kind in KINDS if kind in rows] or sorted(rows, key=lambda row: (row != "all", row))
        for row in order:
            top = ceiling.get(table, {}).get(row)
            text = "" if top is None else f"{top:.1%}"
            lines.append(f"| {row} | {text} | {rows[row]:.1%} | {generated.cells[table][row][1]} |")
        lines.append("")
    return "\n".join(lines)


def main(arguments: Arguments) -> None:
    """Print the tables."""
    for name in arguments.actions:
        if name not in VOCABULARY:
            raise UnknownName("action", name, VOCABULARY)
    real = probe_real(arguments.dataset, arguments.clips) if arguments.dataset else Tally()
    generated = probe_generated(arguments)
    if arguments.json:
        print(json.dumps({"real": real.shares(), "generated": generated.shares()}, indent=1))
    else:
        print(render(generated, real))


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
