"""Ranges of motions: the tokens of one, the segments once it was replaced, and motions one after the other."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from generator.config import MAX_TOKENS, TOKEN_FRAMES, TOKEN_S
from generator.postprocess.context import CONTEXT_TOKENS
from ros_free_stack.errors import InvalidOption
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS


def token_range(start_s: float, end_s: float, frames: int) -> tuple[int, int]:
    """First and last (excluded) frame of a range; rests too short for a token belong to it.

    Raises:
        InvalidOption: it is not inside of the motion, is all of it, or has not the length that the models take.
    """
    duration = frames / FPS
    if not 0 <= start_s < end_s <= duration + 1e-9:
        raise InvalidOption("range", f"{start_s:g} to {end_s:g} s is not a range of a motion of {duration:g} s")
    first = round(start_s * FPS)
    tokens = -(-(round(end_s * FPS) - first) // TOKEN_FRAMES)
    if not 2 <= tokens <= MAX_TOKENS - 2 * CONTEXT_TOKENS:
        least, most = 2 * TOKEN_S, (MAX_TOKENS - 2 * CONTEXT_TOKENS) * TOKEN_S
        raise InvalidOption("range", f"must last {least:g} to {most:g} s, found {end_s - start_s:g} s")
    last = first + tokens * TOKEN_FRAMES
    first = first if first >= TOKEN_FRAMES else 0
    last = last if frames - last >= TOKEN_FRAMES else frames
    if (first, last) == (0, frames):
        raise InvalidOption("range", f"{start_s:g} to {end_s:g} s is the whole motion; generate a new one instead")
    return first, last


def replaced(motion: HumanMotion, new: HumanMotion, start_s: float, end_s: float) -> tuple[Segment, ...]:
    """The motion's segments with those of `new` from `start_s` to `end_s`."""
    before = [replace(s, end_s=min(s.end_s, start_s)) for s in motion.segments if s.start_s < start_s]
    after = [replace(s, start_s=max(s.start_s, end_s)) for s in motion.segments if s.end_s > end_s]
    middle = [Segment(s.text, s.start_s + start_s, min(s.end_s + start_s, end_s)) for s in new.segments]
    return (*before, *middle, *after)


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
