"""Options of the commands that make motion from sentences, and the motions that they ask for."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from ros_free_stack.console import Command
from ros_free_stack.errors import InvalidOption

if TYPE_CHECKING:
    from generator.performer import Performer
    from ros_free_stack.messages import HumanMotion

Sentence = tuple[str, tuple[str, ...]]
"""A prompt and its segment texts."""


@dataclass(frozen=True, kw_only=True)
class MotionOptions(Command):
    """What `generate` and `run` have in common: durations, motions to go on from or to change, further sentences."""

    duration: float | None = None
    """Total duration in s, 2 to 9.8; from the sentence where not given."""
    durations: tuple[float, ...] | None = None
    """Duration of each segment in s instead, in temporal order."""
    start: Path | None = None
    """Motion to go on from: the new one begins where its last frame ends, without a jump."""
    edit: Path | None = None
    """Motion of which --range is made anew from the sentence; the rest stays."""
    range: tuple[float, float] | None = None
    """Start and end in s of what --edit makes anew."""
    then: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """A sentence to append, which goes on from where the last one ends; give it as often as you like."""

    def check_options(self) -> None:
        """InvalidOption where options do not go together."""
        if (self.edit is None) != (self.range is None):
            raise InvalidOption("--edit", "needs --range START END, and --range needs --edit MOTION")
        for option, given in (("--start", self.start), ("--duration", self.duration), ("--durations", self.durations)):
            if given is not None and (self.edit is not None or (self.then and option != "--start")):
                raise InvalidOption(option, "cannot be combined with --edit or --then")
        if self.duration is not None and self.durations is not None:
            raise InvalidOption("--durations", "cannot be combined with --duration")
        if self.edit is not None and self.then:
            raise InvalidOption("--then", "cannot be combined with --edit")

    @property
    def alone(self) -> bool:
        """Whether one sentence makes the whole motion, so that the amounts which it names can be planned."""
        given = (self.then, self.edit, self.start, self.duration, self.durations)
        return not any(option not in (None, ()) for option in given)

    def motions(
        self,
        performer: "Performer",
        sentences: Sequence[Sentence],
        *,
        seed: int,
        candidates: int,
        lasting_s: Sequence[float | None] | None = None,
    ) -> "tuple[HumanMotion, ...]":
        """The motions of the sentences, the first and those to append, as the options ask for them.

        `lasting_s` are durations of single segments of one sentence, None where they are predicted.

        Raises:
            InvalidFile: a motion cannot be read.
            InvalidOption: a number is out of range.
        """
        from generator.continuation import Continuation, concatenated
        from generator.editing import edit
        from ros_free_stack.files import load_motion

        (prompt, segments), *_ = sentences
        start = None if self.start is None else load_motion(self.start)
        if self.edit is not None and self.range is not None:
            return edit(
                performer,
                load_motion(self.edit),
                prompt,
                segments,
                start_s=self.range[0],
                end_s=self.range[1],
                seed=seed,
                candidates=candidates,
            )
        if self.then:
            grown = (Continuation(performer, seed + further, start) for further in range(candidates))
            return tuple(concatenated([motion.append(*sentence) for sentence in sentences]) for motion in grown)
        return performer.generate(
            prompt,
            segments,
            seed=seed,
            candidates=candidates,
            duration_s=self.duration,
            durations_s=self.durations,
            lasting_s=lasting_s,
            start=start,
        )
