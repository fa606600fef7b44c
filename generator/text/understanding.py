"""A raw prompt to segment texts that the model knows: check, split, compare with the training texts."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from generator.text.llm import DEFAULT_MODEL, LanguageModel
from generator.text.prompt import check_prompt
from generator.text.reading import Segmenter
from generator.text.splitter import Splitter

DOMAIN = "domain.safetensors"


@dataclass(frozen=True)
class Understood:
    """The segment texts of a prompt in temporal order, whether the model knows them all, and lines for a person."""

    segments: tuple[str, ...]
    known: bool
    notes: tuple[str, ...] = ()


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
            anyway: go on with unknown segments.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, or has too many actions.
            OutOfDomain: a segment is unknown to the model.
            InvalidFile: the known texts are missing.
        """
        reading = self._segmenter.read(check_prompt(prompt))
        if not anyway:
            self._domain.check(reading.segments)
            return Understood(reading.segments, True, reading.notes)
        known = bool((self._domain.similarity(reading.segments) >= self._domain.threshold).all())
        return Understood(reading.segments, known, reading.notes)

    def segments(self, prompt: str, *, anyway: bool = False) -> tuple[tuple[str, ...], bool]:
        """What `read` understands, without its notes."""
        understood = self.read(prompt, anyway=anyway)
        return understood.segments, understood.known

    @cached_property
    def _segmenter(self) -> Segmenter:
        return self._make_segmenter()

    @cached_property
    def _domain(self) -> Domain:
        return Domain.load(self._folder / DOMAIN, self._encoder())
