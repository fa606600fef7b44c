"""Labelled excerpts of real motion: single actions cut out of CMU takes whose description or caption is clear."""

import re
from collections.abc import Iterable
from pathlib import Path

from generator.corpus.cmu_rules import MIN_S, rule_for
from generator.corpus.excerpts import Excerpt, Recording
from generator.corpus.joins import cut, length
from generator.corpus.mirror import mirror_words
from generator.corpus.vocabulary.english import Phrase, gerund, third_person
from generator.corpus.words import VOCABULARY
from ros_free_stack.errors import InvalidFile
from ros_free_stack.formats import cmu
from ros_free_stack.skeleton import FPS

_VERB = re.compile(r"<(\w+)>")
_CAPTION = re.compile(
    r"^(?:an? |the |this )?(?:person|man|woman|figure|someone|individual|sim)(?: (?:is|was))? (\w+)(.*)$"
)
_LEG_VERBS = frozenset(("walk", "step", "jump", "run", "jog", "hop", "shuffle", "sway", "move", "take", "turn"))
_SEVERAL = re.compile(r"\b(and|then|while|whilst|before|after|or|as|with|when|video|all|around)\b|,")


def load_excerpts(folder: Path, takes: Iterable[cmu.Take] | None = None) -> tuple[Excerpt, ...]:
    """Excerpts of all takes that a rule knows, and of the clips whose real captions tell a single action.

    Raises:
        InvalidFile: the folder has no readable index, or none of its takes gives an excerpt.
    """
    excerpts: list[Excerpt] = []
    for take in cmu.index(folder) if takes is None else takes:
        rule = rule_for(take.description)
        captioned = [clip for clip in take.clips if clip.captions or clip.mirrored_captions]
        if rule is None and not captioned:
            continue
        recording = Recording.of(take.name, cmu.read_take(folder, take.name))
        excerpts += rule(recording) if rule else []
        excerpts += [excerpt for clip in captioned for excerpt in _captioned(recording, clip)]
    if not excerpts:
        raise InvalidFile(folder, "none of its takes gives an excerpt of motion")
    return tuple(excerpt for excerpt in excerpts if length(excerpt.pose) >= MIN_S * FPS)


def _captioned(recording: Recording, clip: cmu.Clip) -> list[Excerpt]:
    """The clip with those of its real captions that tell a single action, as one excerpt; [] where none does."""
    start, stop = recording.sound_part(round(clip.start_s * FPS), round(clip.end_s * FPS))
    said = [*clip.captions, *(mirror_words(caption) for caption in clip.mirrored_captions)]
    words = tuple(dict.fromkeys(word for caption in said if (word := marked_caption(caption))))
    if not words or stop - start < MIN_S * FPS:
        return []
    verb, plainest = _VERB.findall(words[0])[0], Phrase(words[0]).third
    arms, legs = ("", plainest) if verb in _LEG_VERBS else (plainest, "")
    return [Excerpt(f"{verb} as told", {}, cut(recording.pose, start, stop), recording.take, words, arms, legs)]


def marked_caption(caption: str) -> str:
    """A caption of a single action as a phrase with its verb marked, or "" where it is not of that form.

    `a person is walking forward.` -> `<walk> forward`
    """
    text = " ".join(caption.lower().rstrip(". ").split())
    match = _CAPTION.match(text)
    if not match or _SEVERAL.search(match[2]) or len(text.split()) > 12:
        return ""
    word, rest = match[1], match[2]
    return next((f"<{verb}>{rest}" for verb in _known_verbs() if word in (third_person(verb), gerund(verb))), "")


def _known_verbs() -> tuple[str, ...]:
    return tuple(
        sorted({verb for entry in VOCABULARY.values() for text in entry.phrases for verb in _VERB.findall(text)})
    )
