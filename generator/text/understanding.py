"""A raw prompt to what it asks for: check, split, read each segment as a frame, word it as the corpus does."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from generator.text.canonical import phrase, segment_texts, sentence
from generator.text.domain import ALIKE, Domain
from generator.text.encoder import TextEncoder
from generator.text.frame import ActionFrame, Moment, Unknown
from generator.text.frame_parser import moments
from generator.text.llm import DEFAULT_MODEL, LanguageModel
from generator.text.prompt import check_prompt
from generator.text.reading import Segmenter
from generator.text.spans import located
from generator.text.splitter import PERSON, Splitter
from ros_free_stack.errors import OutOfDomain

DOMAIN = "domain.safetensors"


@dataclass(frozen=True)
class Understood:
    """What a prompt asks for.

    Attributes:
        segments: texts in the corpus's own words, in temporal order: what the motion model reads.
        known: whether all of it is known.
        notes: lines for a person.
        moments: the frames of the segments.
        not_shown: the words that no motion will show.
    """

    segments: tuple[str, ...]
    known: bool
    notes: tuple[str, ...] = ()
    moments: tuple[Moment, ...] = ()
    not_shown: tuple[str, ...] = ()


def segmenter(llm: str | None = None, llm_model: str = DEFAULT_MODEL) -> Segmenter:
    """The splitter, or the language model at an address with the splitter to fall back on.

    Raises:
        InvalidOption: the address is none.
        MissingDependency: the splitter's parser is not installed.
    """
    return Splitter() if llm is None else LanguageModel(llm, llm_model, Splitter)


class Understanding:
    """Segmenter and known texts, each loaded when first needed: a hopeless prompt costs neither."""

    def __init__(
        self,
        folder: Path,
        encoder: Callable[[], TextEncoder] = TextEncoder,
        segmenter: Callable[[], Segmenter] = Splitter,
    ) -> None:
        """Take the known texts of a folder of weights; `encoder` and `segmenter` make or hand over what they name."""
        self._folder, self._encoder, self._make_segmenter = folder, encoder, segmenter

    def read(self, prompt: str, *, anyway: bool = False) -> Understood:
        """Understand a prompt.

        Args:
            prompt: a sentence.
            anyway: go on with what is known of it, and with unknown segments in their own words.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, has too many actions or an amount out of range.
            OutOfDomain: an action is unknown to the model.
            InvalidFile: the known texts are missing.
        """
        reading = self._segmenter.read(check_prompt(prompt))
        found = [self._looked_up(moment) for moment in moments(reading.segments)]
        unknown = [part for moment in found for part in moment.unknown]
        if unknown and not anyway:
            named = " and ".join(dict.fromkeys(located(part.text, prompt)[0] for part in unknown))
            raise OutOfDomain(named, self._near(unknown[0]))
        texts = segment_texts(found)
        words = [part.text for moment in found for part in (*moment.not_shown, *moment.unknown)]
        told = dict.fromkeys((*(located(text, prompt)[0] for text in words), *reading.left_out))
        lost = tuple(text for text in told if not any(text in other and text != other for other in told))
        notes = (
            *reading.notes,
            f"understood: {sentence(texts).removeprefix(f'{PERSON} ')}",
            *(f"not shown: {text!r}" for text in lost),
        )
        return Understood(texts, not unknown, notes, tuple(found), lost)

    def segments(self, prompt: str, *, anyway: bool = False) -> tuple[tuple[str, ...], bool]:
        """What `read` understands, without its notes."""
        understood = self.read(prompt, anyway=anyway)
        return understood.segments, understood.known

    def _looked_up(self, moment: Moment) -> Moment:
        """A moment whose uncertain clauses were compared with the known texts: unknown words, and unknown objects."""
        actions, unknown = list[ActionFrame](), list[Unknown]()
        for frame in moment.actions:
            clause = f"{PERSON} {frame.words}"
            if frame.objects and float(self._domain.similarity([clause])[0]) < self._domain.threshold:
                unknown.append(Unknown(frame.words, (frame.action,), frame.words))
            actions.append(frame)
        for part in moment.unknown:
            clause = f"{PERSON} {part.clause}"
            names = () if part.near or not part.clause else self._domain.meant([clause])[0]
            if names and float(self._domain.similarity([clause])[0]) >= self._domain.threshold:
                actions.append(ActionFrame(names[0], words=part.clause, confidence=ALIKE))
            else:
                unknown.append(part)
        return replace(moment, actions=tuple(actions), unknown=tuple(unknown))

    def _near(self, part: Unknown) -> tuple[str, ...]:
        """Known actions near in meaning, in the corpus's words."""
        if part.near:
            return tuple(f"{PERSON} {phrase(ActionFrame(name)).third}" for name in part.near)
        return self._domain.nearest(f"{PERSON} {part.clause or part.text}")

    @cached_property
    def _segmenter(self) -> Segmenter:
        return self._make_segmenter()

    @cached_property
    def _domain(self) -> Domain:
        return Domain.load(self._folder / DOMAIN, self._encoder())
