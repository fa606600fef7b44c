"""Joining phrases into the sentence that a person would type, and into the texts of its segments.

A clip's phrases come in temporal order. The sentence may tell them in another order ("bows after waving"), as a
command ("wave, then bow"), or in several sentences; the segment texts always say, in temporal order, "a person " and
the third person of what that caption said.
"""

import re

import numpy as np

from generator.corpus.vocabulary.english import Phrase, number, tidy
from generator.corpus.vocabulary.entry import Voice
from generator.datasets.dataset import Caption

_SUBJECTS = (
    ("a person", "he", ("the", "their", "his"), 0.42),
    ("the person", "he", ("the", "their", "his"), 0.11),
    ("this person", "he", ("the", "their", "his"), 0.02),
    ("someone", "they", ("the", "their"), 0.07),
    ("a man", "he", ("his", "the"), 0.11),
    ("the man", "he", ("his", "the"), 0.04),
    ("a woman", "she", ("her", "the"), 0.05),
    ("a figure", "it", ("the", "its"), 0.03),
    ("the figure", "it", ("the", "its"), 0.03),
    ("person", "he", ("the", "their"), 0.05),
    ("he", "he", ("his", "the"), 0.03),
    ("she", "she", ("her", "the"), 0.02),
    ("", "", ("the",), 0.08),  # a command: "wave with the right hand"
)
_PROGRESSIVE = 0.12
_BARE = 0.04  # "person waving"
_TOGETHER = " at the same time"
_TIMES = re.compile(r"\b(two|\d+) times\b")
_POSSESSIVE = re.compile(r"\b(?:their|his|her|its)\b")
_DETERMINED = re.compile(rf"\b(both|all|the) {_POSSESSIVE.pattern}")
_LINKS = (" then ", ", then ", " and then ", ", and then ", " and ", ", ")


def draw_voice(rng: np.random.Generator) -> Voice:
    """Who is spoken of, with one pronoun and one possessive for the whole caption; no subject for a command."""
    shares = np.array([share for *_, share in _SUBJECTS])
    subject, pronoun, possessives, _ = _SUBJECTS[int(rng.choice(len(_SUBJECTS), p=shares / shares.sum()))]
    return Voice(subject, pronoun, possessives[int(rng.integers(len(possessives)))])


def together(legs: Phrase, arms: Phrase, rng: np.random.Generator) -> Phrase:
    """One phrase for two actions at the same time; its main verb stays marked."""
    form = rng.random()
    if form < 0.55:
        return Phrase(f"{arms.marked} while {legs.gerund}")
    if form < 0.85 or " and " in legs.marked + arms.marked:
        return Phrase(f"{legs.marked} while {arms.gerund}")
    return Phrase(f"{legs.marked} and {arms.marked}{_TOGETHER}")


def segment_text(phrase: Phrase) -> str:
    """`a person waves with the right hand`, whatever the caption's possessive and way to count or to join were.

    `<wave> his hand two times` -> `a person waves the hand twice`
    """
    marked = phrase.marked
    if marked.endswith(_TOGETHER):
        first, second = (Phrase(part) for part in marked.removesuffix(_TOGETHER).split(" and ", 1))
        text = f"{first.third} while {second.gerund}"
    else:
        text = phrase.third
    text = _TIMES.sub(lambda found: "twice" if found[1] in ("two", "2") else f"{number(int(found[1]))} times", text)
    return "a person " + _POSSESSIVE.sub("the", _DETERMINED.sub(r"\1", text))


def compose_caption(phrases: tuple[Phrase, ...], voice: Voice, rng: np.random.Generator) -> Caption:
    """One caption of phrases in temporal order."""
    text = _sentence(phrases, voice, rng) if voice.subject else _command(phrases, rng)
    end = "." if rng.random() < 0.4 else ""
    return Caption(tidy(text) + end, tuple(segment_text(phrase) for phrase in phrases))


def _pick(choices: tuple[str, ...], rng: np.random.Generator) -> str:
    return choices[int(rng.integers(len(choices)))]


def _command(phrases: tuple[Phrase, ...], rng: np.random.Generator) -> str:
    words = [phrase.plain for phrase in phrases]
    if len(words) == 2 and rng.random() < 0.2:
        return f"{words[1]} after {phrases[0].gerund}"
    return _chain(words, rng)


def _sentence(phrases: tuple[Phrase, ...], voice: Voice, rng: np.random.Generator) -> str:
    if len(phrases) == 1:
        return _single(phrases[0], voice, rng)
    if rng.random() < (0.32 if len(phrases) == 2 else 0.2):
        return _turned(phrases, voice, rng)
    if rng.random() < 0.12:
        return _several_sentences(phrases, voice, rng)
    first = "first " if rng.random() < 0.05 else ""
    words = [phrase.third for phrase in phrases]
    if rng.random() < _PROGRESSIVE:
        words[0] = f"is {phrases[0].gerund}"
    return f"{first}{voice.subject} " + _chain(words, rng)


def _single(phrase: Phrase, voice: Voice, rng: np.random.Generator) -> str:
    form = rng.random()
    if form < _PROGRESSIVE:
        return f"{voice.subject} is {phrase.gerund}"
    if form < _PROGRESSIVE + _BARE and voice.subject.endswith("person"):
        return f"{voice.subject} {phrase.gerund}"
    return f"{voice.subject} {phrase.third}"


def _chain(words: list[str], rng: np.random.Generator) -> str:
    """Clauses in temporal order: a then b; a, b, then c; a, then b, then c."""
    if len(words) == 1:
        return words[0]
    last = _pick(_LINKS[:5], rng)
    if len(words) == 2:
        return words[0] + last + words[1]
    if rng.random() < 0.5:
        return ", ".join(words[:-1]) + last + words[-1]
    links = [_pick(_LINKS, rng) for _ in words[:-2]]
    return "".join(word + link for word, link in zip(words, [*links, last, ""], strict=True))


def _turned(phrases: tuple[Phrase, ...], voice: Voice, rng: np.random.Generator) -> str:
    """Sentences with `after`, `before`, `followed by`, in or against the order of time; the rest follows in order."""
    a, b, rest = phrases[0], phrases[1], [phrase.third for phrase in phrases[2:]]
    subject = voice.subject
    if rest:  # only forms after which another clause can follow without doubt
        heads = (f"after {a.gerund}, {subject} {b.third}", f"before {b.gerund}, {subject} {a.third}")
        head = heads[0] if rng.random() < 0.7 else heads[1]
        return head + _pick((", then ", " and then ", ", and then "), rng) + _chain(rest, rng)
    forms = (
        f"{subject} {b.third} after {a.gerund}",
        f"{subject} {b.third} after {a.gerund}",
        f"after {a.gerund}, {subject} {b.third}",
        f"before {b.gerund}, {subject} {a.third}",
        f"{subject} {a.third} before {b.gerund}",
        f"{subject} {a.third} before {b.gerund}",
        f"{subject} {a.third} followed by {b.gerund}",
        f"{subject} {b.third}, but first {_clause(a, voice)}",
    )
    if any(" while " in phrase.marked or _TOGETHER in phrase.marked for phrase in phrases):
        forms = forms[2:4]  # "b after a while c" leaves open which of them c goes with
    return _pick(forms, rng)


def _clause(phrase: Phrase, voice: Voice) -> str:
    """A clause with the pronoun."""
    return f"{voice.pronoun} {phrase.plain if voice.pronoun == 'they' else phrase.third}"


def _several_sentences(phrases: tuple[Phrase, ...], voice: Voice, rng: np.random.Generator) -> str:
    cut = int(rng.integers(1, len(phrases)))
    head = f"{voice.subject} " + _chain([phrase.third for phrase in phrases[:cut]], rng)
    they = voice.pronoun == "they"
    tail = [phrase.plain if they else phrase.third for phrase in phrases[cut:]]
    opening = _pick(("then", "after that,", "next,", "afterwards,"), rng)
    return f"{head}. {opening} {voice.pronoun} " + _chain(tail, rng)
