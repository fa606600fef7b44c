"""One motion after another: prompts are appended, and each goes on from where the last one ended."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ros_free_stack.messages import HumanMotion

if TYPE_CHECKING:
    from generator.performer import Performer


@dataclass
class Continuation:
    """A motion that grows; what an `append` costs does not depend on how long it is already.

    Attributes:
        performer: makes the motions.
        seed: of all randomness; each prompt draws from its own.
        last: what the latest prompt gave, or the motion to go on from.
    """

    performer: "Performer"
    seed: int
    last: HumanMotion | None = None
    appended: int = 0

    def append(self, prompt: str, segments: Sequence[str], *, duration_s: float | None = None) -> HumanMotion:
        """The motion of the next prompt, in the world frame of the ones before.

        Raises:
            InvalidOption: see `Performer.generate`.
        """
        seed = int(np.random.SeedSequence((self.seed, self.appended)).generate_state(1)[0])
        (chunk,) = self.performer.generate(prompt, segments, seed=seed, duration_s=duration_s, start=self.last)
        self.last, self.appended = chunk, self.appended + 1
        return chunk


def concatenated(chunks: Sequence[HumanMotion]) -> HumanMotion:
    """The chunks of a continuation as one motion."""
    starts = np.cumsum([0.0, *(chunk.duration_s for chunk in chunks)])
    segments = tuple(
        replace(segment, start_s=segment.start_s + start, end_s=segment.end_s + start)
        for chunk, start in zip(chunks, starts.tolist(), strict=False)
        for segment in chunk.segments
    )
    joints = np.concatenate([chunk.joints for chunk in chunks])
    return replace(chunks[0], joints=joints, prompt=", then ".join(chunk.prompt for chunk in chunks), segments=segments)
