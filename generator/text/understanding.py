"""A raw prompt to segment texts that the model knows: check, split, compare with the training texts."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from generator.text.domain import Domain
from generator.text.encoder import TextEncoder
from generator.text.prompt import check_prompt
from generator.text.splitter import Splitter

DOMAIN = "domain.safetensors"


class Understanding:
    """Parser and known texts, each loaded when first needed: a hopeless prompt costs neither."""

    def __init__(self, folder: Path, encoder: Callable[[], TextEncoder] = TextEncoder) -> None:
        """Take the known texts that lie in a folder of weights; `encoder` makes or hands over the text encoder."""
        self._folder, self._encoder = folder, encoder

    def segments(self, prompt: str, *, anyway: bool = False) -> tuple[tuple[str, ...], bool]:
        """The prompt's segment texts in temporal order, and whether the model knows them all.

        Args:
            prompt: a sentence.
            anyway: go on with unknown segments.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, or has too many actions.
            OutOfDomain: a segment is unknown to the model.
            InvalidFile: the known texts are missing.
        """
        segments = self._splitter.split(check_prompt(prompt))
        if not anyway:
            self._domain.check(segments)
            return segments, True
        known = bool((self._domain.similarity(segments) >= self._domain.threshold).all())
        return segments, known

    @cached_property
    def _splitter(self) -> Splitter:
        return Splitter()

    @cached_property
    def _domain(self) -> Domain:
        return Domain.load(self._folder / DOMAIN, self._encoder())
