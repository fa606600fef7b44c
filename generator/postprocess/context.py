"""What a generated motion has to join: the frames given before it, after it, or both."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
import torch
from numpy.typing import NDArray

from generator.config import FEATURES
from generator.corpus.body import BALL_HEIGHT
from generator.model import Known
from generator.postprocess.foot_lock import lock_feet, standing_height
from generator.postprocess.stitch import stitch
from ros_free_stack.errors import InvalidOption
from ros_free_stack.formats.features import decode, encode
from ros_free_stack.messages import HumanMotion
from ros_free_stack.skeleton import FPS, JOINT_COUNT

Floats = NDArray[np.float64]

CONTEXT_FRAMES: Final = 20
"""Frames of the given motion, on either side, that the models see."""
CONTEXT_S: Final = CONTEXT_FRAMES / FPS
_ENCODED: Final = 60
"""Frames that features are made of; more than the models see, because the smoothed heading looks around."""


@dataclass(frozen=True)
class Context:
    """Given frames before and after the ones to be generated.

    Attributes:
        before, after: (P, 22, 3) and (Q, 22, 3) m, whole tokens of frames, perhaps none.
        unit: frames that the model makes together.
        before_text, after_text: what the person does there.
        rest: height of the ball of a standing foot in the whole given motion, m.
    """

    before: Floats
    after: Floats
    unit: int = 1
    before_text: str = ""
    after_text: str = ""
    rest: float = BALL_HEIGHT

    @classmethod
    def none(cls) -> Self:
        """Nothing before, nothing after."""
        return cls(np.zeros((0, JOINT_COUNT, 3)), np.zeros((0, JOINT_COUNT, 3)))

    @classmethod
    def of_range(cls, motion: HumanMotion, first: int, last: int, unit: int) -> Self:
        """Those of frames `first` to `last` (excluded) of a motion, in whole tokens of `unit` frames.

        Raises:
            InvalidOption: the motion is not at 20 frames a second.
        """
        if motion.fps != FPS:
            raise InvalidOption("motion", f"has {motion.fps:g} frames a second, the models need {FPS:g}")
        before = min(first, _ENCODED) // unit * unit
        after = min(len(motion.joints) - last, _ENCODED) // unit * unit
        return cls(
            motion.joints[first - before : first],
            motion.joints[last : last + after],
            unit,
            _text_at(motion, first - 1),
            _text_at(motion, last),
            standing_height(motion.joints),
        )

    @property
    def frames(self) -> tuple[int, int]:
        """How many frames before and after the models see."""
        before, after = (min(len(part), CONTEXT_FRAMES) // self.unit * self.unit for part in (self.before, self.after))
        return before, after

    def around(self, segments: Sequence[str], frames: NDArray[np.int64]) -> tuple[tuple[str, ...], NDArray[np.int64]]:
        """Segment texts and their frames (A,) with those of the given motion that the models see."""
        before, after = self.frames
        texts = (*[self.before_text][: before > 0], *segments, *[self.after_text][: after > 0])
        return texts, np.array([*[before][: before > 0], *frames, *[after][: after > 0]], dtype=np.int64)

    def known(self, totals: Sequence[int], device: torch.device | str) -> Known | None:
        """What motions of so many frames in all have to keep; None where nothing is given."""
        before, after = self.frames
        if not before and not after:
            return None
        given = [torch.from_numpy(part).float().to(device) for part in self.features()]
        features = torch.zeros(len(totals), max(totals), given[0].shape[1], device=device)
        mask = torch.zeros(features.shape[:2], dtype=torch.bool, device=device)
        for rows, stays, total in zip(features, mask, totals, strict=True):
            rows[:before], stays[:before] = given[0][len(given[0]) - before :], True
            rows[total - after : total], stays[total - after : total] = given[1][:after], True
        return Known(features, mask, given[0][: len(given[0]) - before], given[1][after:])

    def features(self) -> tuple[Floats, Floats]:
        """(P, 263) and (Q, 263) features of the frames before and after."""
        lift = [0.0, 0.0, BALL_HEIGHT - self.rest]
        before, after = (whole_features(part + lift) for part in (self.before, self.after))
        return before, after

    def stitched(self, features: NDArray[np.floating], *, foot_lock: bool) -> tuple[Floats, Floats]:
        """Joints of the generated frames, and of those after them in their new place.

        Args:
            features: (N, 263) of the frames that the models saw, the generated ones in the middle.
            foot_lock: hold standing feet still.
        """
        before, after = self.frames
        given = self.before[len(self.before) - before :], self.after[:after]
        window = decode(features) - [0.0, 0.0, BALL_HEIGHT - self.rest]
        middle, follows = stitch(given[0], window, given[1])
        if foot_lock:
            rest = self.rest if before or after else None
            window = lock_feet(np.concatenate([given[0], middle, follows]), features[:, -4:].astype(np.float64), rest)
            middle, follows = stitch(given[0], window, given[1])
        return middle, follows


def whole_features(joints: Floats) -> Floats:
    """(T, 263) features of all frames (T, 22, 3); the last one goes on as it came."""
    if not len(joints):
        return np.zeros((0, FEATURES))
    return encode(np.concatenate([joints, 2 * joints[-1:] - joints[-2:-1]]))


def _text_at(motion: HumanMotion, frame: int) -> str:
    """The text of the segment that holds a frame, or "a person stands still" where there is none."""
    time = (frame + 0.5) / motion.fps
    texts = [segment.text for segment in motion.segments if segment.start_s <= time < segment.end_s]
    return texts[0] if texts else "a person stands still"
