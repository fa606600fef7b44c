"""What a generated motion has to join: the frames given before it, after it, or both."""

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from generator.config import TOKEN_FRAMES
from generator.data.body import BALL_HEIGHT
from generator.postprocess.foot_lock import lock_feet, standing_height
from generator.postprocess.stitch import stitch
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import decode, encode
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import FPS, JOINT_COUNT

Floats = NDArray[np.float64]

CONTEXT_TOKENS: Final = 5
"""Tokens of the given motion, on either side, that the models see."""
_ENCODED: Final = 15 * TOKEN_FRAMES
"""Frames that are encoded for them; more than they see, because the smoothed heading looks around."""


@dataclass(frozen=True)
class Context:
    """Given frames before and after the ones to be generated.

    Attributes:
        before, after: (P, 22, 3) and (Q, 22, 3) m, whole tokens of frames, perhaps none.
        before_text, after_text: what the person does there.
        rest: height of the ball of a standing foot in the whole given motion, m.
    """

    before: Floats
    after: Floats
    before_text: str = ""
    after_text: str = ""
    rest: float = BALL_HEIGHT

    @classmethod
    def none(cls) -> Self:
        """Nothing before, nothing after."""
        return cls(np.zeros((0, JOINT_COUNT, 3)), np.zeros((0, JOINT_COUNT, 3)))

    @classmethod
    def of_range(cls, motion: HumanMotion, first: int, last: int) -> Self:
        """Those of frames `first` to `last` (excluded) of a motion.

        Raises:
            InvalidOption: the motion is not at 20 frames a second.
        """
        if motion.fps != FPS:
            raise InvalidOption("motion", f"has {motion.fps:g} frames a second, the models need {FPS:g}")
        before = min(first // TOKEN_FRAMES * TOKEN_FRAMES, _ENCODED)
        after = min((len(motion.joints) - last) // TOKEN_FRAMES * TOKEN_FRAMES, _ENCODED)
        return cls(
            motion.joints[first - before : first],
            motion.joints[last : last + after],
            _text_at(motion, first - 1),
            _text_at(motion, last),
            standing_height(motion.joints),
        )

    @property
    def tokens(self) -> tuple[int, int]:
        """How many tokens before and after the models see."""
        before, after = (min(len(part) // TOKEN_FRAMES, CONTEXT_TOKENS) for part in (self.before, self.after))
        return before, after

    def features(self) -> tuple[Floats, Floats]:
        """(P, 263) and (Q, 263) features of the frames before and after."""
        lift = [0.0, 0.0, BALL_HEIGHT - self.rest]
        before, after = (_encode(part + lift) for part in (self.before, self.after))
        return before, after

    def joined(self, features: Floats, *, foot_lock: bool) -> tuple[Floats, Floats]:
        """Joints of the generated frames, and of those after them in their new place.

        Args:
            features: (N, 263) of the tokens that the models saw, the generated ones in the middle.
            foot_lock: hold standing feet still.
        """
        before, after = (count * TOKEN_FRAMES for count in self.tokens)
        given = self.before[len(self.before) - before :], self.after[:after]
        window = decode(features) - [0.0, 0.0, BALL_HEIGHT - self.rest]
        middle, follows = stitch(given[0], window, given[1])
        if foot_lock:
            rest = self.rest if before or after else None
            window = lock_feet(np.concatenate([given[0], middle, follows]), features[:, -4:], rest)
            middle, follows = stitch(given[0], window, given[1])
        return middle, follows


def _encode(frames: Floats) -> Floats:
    """Features of all frames; the last one goes on as it came."""
    if not len(frames):
        return np.zeros((0, 263))
    return encode(np.concatenate([frames, 2 * frames[-1:] - frames[-2:-1]]))


def _text_at(motion: HumanMotion, frame: int) -> str:
    """The text of the segment that holds a frame, or "a person stands still" where there is none."""
    time = (frame + 0.5) / motion.fps
    texts = [segment.text for segment in motion.segments if segment.start_s <= time < segment.end_s]
    return texts[0] if texts else "a person stands still"
