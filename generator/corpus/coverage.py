"""How much of what people say of human motion the corpus can say: real captions against the vocabulary.

A caption is split into segments, a segment into its verbs ("walks while waving" has two). An action counts as covered
when the vocabulary utters its verb, and with that verb each limb that the action names, "up" or "down" where it has
one, and after a verb that means little by itself ("does", "plays") its object. A caption is covered when all its
actions are. Only words are compared: a covered caption may still ask for a detail that no clip shows.
"""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np

from generator.corpus.vocabulary.english import Phrase, gerund, third_person
from generator.corpus.vocabulary.entry import Draw, Voice
from generator.corpus.words import VOCABULARY
from ros_free_stack.errors import InvalidFile, InvalidPrompt

_DRAWS: Final = 70  # of an entry of weight one; those drawn often have more to say
_JOINED = re.compile(r" and |, ")
_WORD = re.compile(r"[a-z]+(?:-[a-z]+)*")
_LIMBS: Final = {
    word: limb
    for limb, words in {
        "arm": "arm arms hand hands fist fists wrist wrists palm palms elbow elbows finger fingers",
        "leg": "leg legs foot feet knee knees heel heels toe toes ankle thigh",
        "head": "head face neck ear ears mouth eyes hair nose chin",
        "trunk": "body torso waist chest stomach belly hip hips shoulder shoulders",
    }.items()
    for word in words.split()
}
_PARTICLES: Final = frozenset({"up", "down"})
_VAGUE: Final = frozenset({"do", "make", "take", "perform", "give", "have", "play", "get", "go", "use", "be"})
_FILLERS = """
a an the some several few couple of one two three four five six small large big slow quick left right both other
his her their its something motion movement gesture forward forwards backward backwards back away ahead
into in to around with on at
"""
_EMPTY: Final = frozenset(_FILLERS.split())


@dataclass(frozen=True)
class Said:
    """An action in words: the verb's base, the limbs named, "up" or "down", and a vague verb's object."""

    verb: str
    limbs: frozenset[str] = frozenset()
    particles: frozenset[str] = frozenset()
    object: str = ""


@dataclass(frozen=True)
class Coverage:
    """What a sample of captions showed.

    Attributes:
        captions: how many were read; `unreadable` more could not be split into segments.
        segments: how many segments they have.
        covered_captions, covered_segments: shares.
        uncovered: the actions most often not covered ("do cartwheel"), with their number.
    """

    captions: int
    unreadable: int
    segments: int
    covered_captions: float
    covered_segments: float
    uncovered: tuple[tuple[str, int], ...]


class Speech:
    """All that the vocabulary utters, drawn from its templates."""

    def __init__(self, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        draws = (item for item in VOCABULARY.values() for _ in range(round(_DRAWS * (1 + item.weight))))
        drawn = (item.phrase(item.sample(Draw(rng)), Voice(), rng).marked for item in draws)
        marked = [Phrase(text) for text in dict.fromkeys(drawn)]
        verbs = {verb for phrase in marked for verb in re.findall(r"<(\w+)>", phrase.marked)}
        self._bases = {form(verb): verb for verb in verbs for form in (third_person, gerund)}
        self._limbs: dict[str, set[str]] = defaultdict(set)
        self._particles: dict[str, set[str]] = defaultdict(set)
        self._objects: dict[str, set[str]] = defaultdict(set)
        for said in {said for phrase in marked for said in self.actions(phrase.third)}:
            self._limbs[said.verb] |= said.limbs
            self._particles[said.verb] |= said.particles
            self._objects[said.verb].add(said.object)

    def actions(self, segment: str) -> tuple[Said, ...]:
        """The actions of a segment text, its subject left away. After "and", words without a known verb go on."""
        pieces: list[list[str]] = []
        for at_once in segment.removeprefix("a person ").split(" while "):
            for place, piece in enumerate(_JOINED.split(at_once)):
                words = [word for word in _WORD.findall(piece) if not word.endswith("ly")]
                if place and pieces and words and words[0] not in self._bases:
                    pieces[-1] += words
                elif words:
                    pieces.append(words)
        return tuple(self._said(words) for words in pieces)

    def _said(self, words: list[str]) -> Said:
        verb, rest = self._bases.get(words[0], words[0]), words[1:]
        limbs = frozenset(_LIMBS[word] for word in rest if word in _LIMBS)
        named = [word for word in rest if word not in _EMPTY | _PARTICLES]
        return Said(verb, limbs, _PARTICLES.intersection(rest), named[0] if named and verb in _VAGUE else "")

    def covers(self, said: Said) -> bool:
        """Whether the vocabulary utters this verb with these limbs, this particle and this object."""
        return (
            said.verb in self._objects
            and said.limbs <= self._limbs[said.verb]
            and said.particles <= self._particles[said.verb]
            and (
                not said.object
                or bool({said.object, said.object.rstrip("s"), f"{said.object}s"} & self._objects[said.verb])
            )
        )


def measure(
    captions: Iterable[str], split: Callable[[str], Sequence[str]], speech: Speech, *, top: int = 30
) -> Coverage:
    """Coverage of captions, split into segment texts by `split`, which raises InvalidPrompt where it cannot."""
    missing = Counter[str]()
    whole, covered, unreadable = [], [], 0
    for caption in captions:
        try:
            segments = split(caption)
        except InvalidPrompt:
            unreadable += 1
            continue
        known = []
        for segment in segments:
            strange = [said for said in speech.actions(segment) if not speech.covers(said)]
            known.append(not strange)
            missing.update(_named(said) for said in strange)
        covered += known
        whole.append(all(known))
    return Coverage(
        captions=len(whole),
        unreadable=unreadable,
        segments=len(covered),
        covered_captions=float(np.mean(whole)) if whole else 0.0,
        covered_segments=float(np.mean(covered)) if covered else 0.0,
        uncovered=tuple(missing.most_common(top)),
    )


def _named(said: Said) -> str:
    return " ".join(filter(None, (said.verb, said.object, *sorted(said.particles), *sorted(said.limbs))))


def read_captions(path: Path) -> tuple[str, ...]:
    """Every caption of a JSON file of {split: {clip: [[text, start, end], ...]}}.

    Raises:
        InvalidFile: the file is missing, no JSON, or of another form.
    """
    try:
        content: Any = json.loads(path.read_bytes())
    except FileNotFoundError:
        raise InvalidFile(path, "no such file") from None
    except (OSError, ValueError) as error:
        raise InvalidFile(path, f"not a JSON file ({error})") from None
    try:
        texts = [said[0] for clips in content.values() for captions in clips.values() for said in captions]
    except (AttributeError, TypeError, IndexError, KeyError):
        raise InvalidFile(path, "expected {split: {clip: [[caption, start, end], ...]}}") from None
    if not texts or not all(isinstance(text, str) for text in texts):
        raise InvalidFile(path, "it has no captions, or some that are no text")
    return tuple(texts)


def sample_captions(captions: Sequence[str], count: int, seed: int) -> tuple[str, ...]:
    """`count` captions drawn without repetition; all of them where there are no more."""
    order = np.random.default_rng(seed).permutation(len(captions))[:count]
    return tuple(captions[int(place)] for place in order)
