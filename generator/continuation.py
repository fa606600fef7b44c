"""One motion after another: prompts are appended, and each goes on from where the last one ended."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from generator.performer import Performer
from ros_free_stack.messages import HumanMotion


@dataclass
class Continuation:
    """A motion that grows; what an `append` costs does not depend on how long it is already.

    Attributes:
        generator: the models.
        seed: of all randomness; each prompt draws from its own.
        last: what the latest prompt gave, or the motion to go on from.
    """

    generator: Performer
    seed: int
    last: HumanMotion | None = None
    appended: int = 0

    def append(self, prompt: str, segments: Sequence[str], *, duration_s: float | None = None) -> HumanMotion:
        """The motion of the next prompt, in the world frame of the ones before.

        Raises:
            InvalidOption: see `Performer.generate`.
        """
        seed = int(np.random.SeedSequence((self.seed, self.appended)).generate_state(1)[0])
        (chunk,) = self.generator.generate(prompt, segments, seed=seed, duration_s=duration_s, start=self.last)
        self.last, self.appended = chunk, self.appended + 1
        return chunk
