"""Composing one clip of the corpus: a drawn plan performed, cut into segments, and told.

Authored actions that follow each other are performed in one scene; captured ones are warped, mirrored, sometimes given
authored arms, and joined by a bridging step. Captions say what was performed.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Final

import numpy as np

from generator.config import MAX_FRAMES, MIN_FRAMES
from generator.corpus import pose as poses
from generator.corpus.actions import ACTIONS, perform
from generator.corpus.captions import compose_caption, draw_voice, together
from generator.corpus.excerpts import Excerpt
from generator.corpus.joins import flat_speed, join, layer, length, warp
from generator.corpus.plan import SEGMENT_SHARES, Part, draw_plan
from generator.corpus.pose import ARM_CHANNELS, Pose
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.english import Phrase
from generator.corpus.vocabulary.entry import Voice
from generator.corpus.words import STILL, VOCABULARY, entry, parts
from generator.datasets.dataset import Caption, LabelledSegment
from ros_free_stack.skeleton import FPS

MAX_JOINT_SPEED: Final = 14.0  # m/s
_QUICKEST, _SLOWEST = 0.85, 1.15  # time warp of captured motion
_REAL_CLIPS = 0.32
_ATTEMPTS = 200
_STANDING_ENDS = 0.85  # how often a clip that would begin or end in mid-stride starts from, or stops in, standing
_MID_STRIDE = 0.25  # m/s


@dataclass(frozen=True)
class ComposedClip:
    """A clip: joints (T, 22, 3), segments that tile its T - 1 steps, captions, and where it comes from."""

    joints: np.ndarray
    segments: tuple[LabelledSegment, ...]
    captions: tuple[Caption, ...]
    source: str
    names: tuple[str, ...]


class _Redraw(Exception):
    """The clip drawn cannot be used: too long, too short, or not a motion."""


@dataclass(frozen=True)
class _Run:
    """A pose with the spans (frames) of its segments."""

    pose: Pose
    spans: tuple[tuple[float, float], ...]


def compose_clip(rng: np.random.Generator, excerpts: tuple[Excerpt, ...] = ()) -> ComposedClip:
    """Draw a clip. The same generator state gives the same clip.

    Args:
        rng: all randomness.
        excerpts: captured actions; without them all is authored.
    """
    count = 1 + int(rng.choice(len(SEGMENT_SHARES), p=SEGMENT_SHARES))
    real = bool(excerpts) and rng.random() < _REAL_CLIPS
    for attempt in range(_ATTEMPTS):
        if attempt and attempt % 50 == 0 and count > 1:
            count -= 1
        try:
            return _draw_clip(rng, count, excerpts if real else ())
        except _Redraw:
            continue
    raise RuntimeError(f"no usable clip in {_ATTEMPTS} draws")


def _draw_clip(rng: np.random.Generator, count: int, excerpts: tuple[Excerpt, ...]) -> ComposedClip:
    plan = draw_plan(rng, count, excerpts)
    pose, spans = _perform(plan, rng)
    frames = length(pose)
    if not MIN_FRAMES <= frames - 1 <= MAX_FRAMES:
        raise _Redraw
    joints = poses.joints(pose)
    if not is_motion(joints):
        raise _Redraw
    captions = _captions(plan, rng)
    edges = _tile(spans, frames - 1)
    segments = tuple(
        LabelledSegment(text, start, end, *_part_texts(part), part.actions)
        for text, start, end, part in zip(captions[0].segments, edges[:-1], edges[1:], plan, strict=True)
    )
    captured = sum(part.excerpt is not None for part in plan)
    source = "authored" if captured == 0 else "cmu" if captured == count and not any(p.arms for p in plan) else "mixed"
    return ComposedClip(joints, segments, captions, source, tuple(part.name for part in plan))


def is_motion(joints: np.ndarray) -> bool:
    """Whether joints (T, 22, 3) are finite, above the floor and slower than a body can be."""
    if not np.isfinite(joints).all() or joints[..., 2].min() < -0.12:
        return False
    return bool(np.linalg.norm(np.diff(joints, axis=0), axis=-1).max() * FPS < MAX_JOINT_SPEED)


def _perform(plan: tuple[Part, ...], rng: np.random.Generator) -> tuple[Pose, tuple[tuple[float, float], ...]]:
    """The pose of a whole plan and the spans of its parts, in frames."""
    if sum(length(part.excerpt.pose) for part in plan if part.excerpt) * _QUICKEST > MAX_FRAMES:
        raise _Redraw
    runs: list[_Run] = []
    index = 0
    while index < len(plan):
        if plan[index].excerpt:
            runs.append(_capture(plan[index], rng))
            index += 1
        else:
            stop = index
            while stop < len(plan) and not plan[stop].excerpt:
                stop += 1
            runs.append(_author(plan[index:stop], rng, lone=stop - index == len(plan)))
            index = stop
    first, last = runs[0].pose, runs[-1].pose
    before = _standing(rng) if flat_speed(first, 0) * FPS > _MID_STRIDE and rng.random() < _STANDING_ENDS else None
    after = _standing(rng) if flat_speed(last, -1) * FPS > _MID_STRIDE and rng.random() < _STANDING_ENDS else None
    pose, spans = before, ()
    for run in runs:
        pose, begin = _joined(pose, run.pose)
        spans += tuple((start + begin, end + begin) for start, end in run.spans)
    assert pose is not None
    return (join(pose, after)[0] if after else pose), spans


def _joined(before: Pose | None, after: Pose) -> tuple[Pose, int]:
    """Both in one, if there are two, and the frame at which the latter begins."""
    if before is None:
        return after, 0
    pose, _, begin = join(before, after)
    return pose, begin


def _standing(rng: np.random.Generator) -> Pose:
    """A moment of standing with the feet side by side."""
    return Scene(seed=int(rng.integers(2**31))).solve(tail=float(rng.uniform(0.2, 0.5)))


def _author(plan: tuple[Part, ...], rng: np.random.Generator, *, lone: bool) -> _Run:
    """Perform consecutive authored parts in one scene."""
    scene = Scene(seed=int(rng.integers(2**31)))
    scene.time = float(rng.uniform(0.1, 0.45)) if lone else float(rng.uniform(0.05, 0.2))
    spans: list[tuple[float, float]] = []
    for part, following in zip(plan, (*plan[1:], None), strict=True):
        start = scene.time
        end = _perform_part(scene, part, rng)
        spans.append((start * FPS, end * FPS))
        if following:
            scene.time = end + _gap(part, following, rng)
    tail = float(rng.uniform(0.15, 0.6)) if lone else float(rng.uniform(0.05, 0.25))
    if lone:
        tail = max(tail, (MIN_FRAMES + 2) / FPS - scene.time)
    if (scene.time + tail) * FPS > MAX_FRAMES + 1:
        raise _Redraw
    return _Run(scene.solve(tail=tail), tuple(spans))


def _perform_part(scene: Scene, part: Part, rng: np.random.Generator) -> float:
    assert part.action is not None
    start = scene.time
    end = perform(scene, part.action.name, **part.action.params)
    if part.arms:
        late = start + float(rng.uniform(0.05, 0.5))
        end = max(end, perform(scene, part.arms.name, start=late, advance=False, **part.arms.params))
        scene.time = end
    return end


def _gap(part: Part, following: Part, rng: np.random.Generator) -> float:
    """A pause, or an overlap where one of the two needs the arms alone."""
    free = any(p.action and ACTIONS[p.action.name].part == "arms" for p in (part, following))
    return float(rng.uniform(-0.15 if free else 0.0, 0.35))


def _capture(part: Part, rng: np.random.Generator) -> _Run:
    """A captured part: warped, with authored arms where the part has them."""
    assert part.excerpt is not None
    pose = warp(part.excerpt.pose, float(rng.uniform(_QUICKEST, _SLOWEST)))
    if part.arms:
        scene = Scene(seed=int(rng.integers(2**31)))
        perform(scene, part.arms.name, start=0.0, **part.arms.params)
        over = scene.solve(tail=0.0)
        if length(over) > length(pose) + 4:
            raise _Redraw
        room = max(0, length(pose) - length(over))
        pose = layer(pose, over, int(rng.integers(min(room, 8) + 1)), ARM_CHANNELS)
    return _Run(pose, ((0.0, float(length(pose))),))


def _tile(spans: tuple[tuple[float, float], ...], frames: int) -> list[int]:
    """Edges of segments that cover 0..frames, each inner one in the middle of its transition."""
    inner = [round(0.5 * (end + start)) for (_, end), (start, _) in pairwise(spans)]
    edges = [0, *inner, frames]
    if any(b - a < 6 for a, b in pairwise(edges)):
        raise _Redraw
    return edges


def _captions(plan: tuple[Part, ...], rng: np.random.Generator) -> tuple[Caption, ...]:
    captions: dict[str, Caption] = {}
    for _ in range(2 + int(rng.random() < 0.5)):
        voice = draw_voice(rng)
        caption = compose_caption(tuple(_phrase(part, voice, rng) for part in plan), voice, rng)
        captions.setdefault(caption.text, caption)
    return tuple(captions.values())


def _phrase(part: Part, voice: Voice, rng: np.random.Generator) -> Phrase:
    if part.excerpt:
        main = _excerpt_phrase(part.excerpt, voice, rng)
    else:
        assert part.action is not None
        main = entry(part.action.name).phrase(part.action.params, voice, rng)
    if not part.arms:
        return main
    return together(main, entry(part.arms.name).phrase(part.arms.params, voice, rng), rng)


def _excerpt_phrase(excerpt: Excerpt, voice: Voice, rng: np.random.Generator) -> Phrase:
    known = excerpt.name in VOCABULARY
    if excerpt.words and (not known or rng.random() < 0.5):
        return Phrase(excerpt.words[int(rng.integers(len(excerpt.words)))])
    return entry(excerpt.name).phrase(excerpt.params, voice, rng)


def _part_texts(part: Part) -> tuple[str, str]:
    arms, legs = "", ""
    for name, params in part.actions:
        own = part.excerpt if part.excerpt and name == part.excerpt.name and name not in VOCABULARY else None
        more = (own.arms, own.legs) if own else parts(name, params)
        arms, legs = (more[0] or arms, legs or more[1])
    return arms or STILL, legs or STILL


def plain(params: dict[str, Any]) -> dict[str, Any]:
    """Parameters as JSON can hold them."""
    return {key: round(value, 3) if isinstance(value, float) else value for key, value in params.items()}
