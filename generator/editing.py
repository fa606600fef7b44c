"""A range of a motion made anew from a prompt."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from generator.model import FeatureSpec
from generator.performer import Performer, PerformerSettings
from generator.postprocess.context import CONTEXT_FRAMES, Context
from generator.postprocess.stitch import placed
from generator.timing import whole_frames
from ros_free_stack.errors import InvalidOption
from ros_free_stack.messages import HumanMotion, Segment
from ros_free_stack.skeleton import FPS

SHORTEST_S = 0.4
"""Of a range."""


def edit(
    performer: Performer,
    motion: HumanMotion,
    prompt: str,
    segments: Sequence[str],
    *,
    start_s: float,
    end_s: float,
    seed: int,
    candidates: int = 1,
    settings: PerformerSettings | None = None,
) -> tuple[HumanMotion, ...]:
    """Motions like the given one with the time from `start_s` to `end_s` generated anew from a prompt.

    The range ends after whole tokens of the model. The frames before it do not change; those after it keep their
    poses, and move over the floor as a whole to where the new range leads.

    Args:
        motion: what to change, at 20 frames a second.
        prompt: what happens in the range instead.
        segments: its segment texts, 1 to 5 less one for either side that the motion goes on at.
        start_s, end_s: the range, 0.4 to 7.8 s long, not the whole motion.

    Raises:
        InvalidOption: a number is out of range, or the motion is not at 20 frames a second.
    """
    spec, frames = performer.model.spec, len(motion.joints)
    first, last = frame_range(start_s, end_s, frames, spec)
    context = Context.of_range(motion, first, last, spec.token_frames)
    total = -(-(last - first) // spec.token_frames) * spec.token_frames
    performer.check(len(segments) + sum(count > 0 for count in context.frames), spec.most_frames, candidates)
    performer.check(len(segments), total, candidates)
    settings = settings or PerformerSettings()
    noise = performer.noise(seed)
    seconds = performer.predicted(segments, candidates, settings.duration_spread, noise)
    lengths = [whole_frames(row, spec, least=total, most=total) for row in seconds]
    features = performer.around(prompt, segments, lengths, context, settings, noise)
    edited: list[HumanMotion] = []
    for rows, row in zip(features, lengths, strict=True):
        middle, follows = context.stitched(rows, foot_lock=settings.foot_lock)
        rest = motion.joints[last:]
        if len(rest):
            rest = placed(rest, rest[: len(follows)], follows)
        on_floor = first == 0 and last == frames
        new = performer.motion(middle[: last - first], prompt, segments, row, on_floor=on_floor)
        joints = np.concatenate([motion.joints[:first], new.joints, rest])
        edited.append(replace(new, joints=joints, segments=replaced(motion, new, first / FPS, last / FPS)))
    return tuple(edited)


def frame_range(start_s: float, end_s: float, frames: int, spec: FeatureSpec) -> tuple[int, int]:
    """First and last (excluded) frame of a range; rests too short for a token belong to it.

    Raises:
        InvalidOption: it is not inside of the motion, is all of it, or has not the length that the model takes.
    """
    duration, unit = frames / FPS, spec.token_frames
    if not 0 <= start_s < end_s <= duration + 1e-9:
        raise InvalidOption("range", f"{start_s:g} to {end_s:g} s is not a range of a motion of {duration:g} s")
    first = round(start_s * FPS)
    total = -(-(round(end_s * FPS) - first) // unit) * unit
    least, most = max(2 * unit, round(SHORTEST_S * FPS)), spec.whole(spec.most_frames - 2 * CONTEXT_FRAMES)
    if not least <= total <= most:
        raise InvalidOption("range", f"must last {least / FPS:g} to {most / FPS:g} s, found {end_s - start_s:g} s")
    last = first + total
    first = first if first >= unit else 0
    last = last if frames - last >= unit else frames
    if (first, last) == (0, frames):
        raise InvalidOption("range", f"{start_s:g} to {end_s:g} s is the whole motion; generate a new one instead")
    return first, last


def replaced(motion: HumanMotion, new: HumanMotion, start_s: float, end_s: float) -> tuple[Segment, ...]:
    """The motion's segments with those of `new` from `start_s` to `end_s`."""
    before = [replace(s, end_s=min(s.end_s, start_s)) for s in motion.segments if s.start_s < start_s]
    after = [replace(s, start_s=max(s.start_s, end_s)) for s in motion.segments if s.end_s > end_s]
    middle = [Segment(s.text, s.start_s + start_s, min(s.end_s + start_s, end_s)) for s in new.segments]
    return (*before, *middle, *after)
