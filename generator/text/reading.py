"""What becomes of a prompt: its segments, and what a person should know about how they were found."""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class Reading:
    """One to five segment texts in temporal order; `notes` are lines for a person, such as corrected spelling.

    `left_out` are the words that say what is not done.
    `fell_back`: the preferred way of reading failed, a note says why.
    """

    segments: tuple[str, ...]
    notes: tuple[str, ...] = ()
    left_out: tuple[str, ...] = ()
    fell_back: bool = False


class Segmenter(Protocol):
    """Splits a prompt into segment texts."""

    def read(self, prompt: str) -> Reading:
        """The reading of a prompt.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, or has more than five actions in order.
        """
        ...

    def split(self, prompt: str) -> tuple[str, ...]:
        """The segment texts alone."""
        ...
