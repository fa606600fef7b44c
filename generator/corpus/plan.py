"""Drawing what a clip shows: which actions, authored or captured, one after the other or at the same time."""

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np

from generator.config import MAX_FRAMES
from generator.corpus.actions import ACTIONS, perform
from generator.corpus.excerpts import Excerpt, mirror_params
from generator.corpus.joins import cut, length
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Draw, Params
from generator.corpus.words import VOCABULARY, entry
from ros_free_stack.skeleton import FPS

SEGMENT_SHARES: Final = (0.26, 0.29, 0.20, 0.15, 0.10)
BRIEF_SHARES: Final = (0.0, 0.3, 0.5, 1.0, 1.0)
"""How often a clip has one, two, ... five segments, and how often the actions of such a clip are kept short."""
_SIMULTANEOUS = 0.20  # of authored segments: legs and arms apart
_ARMS_OVER_EXCERPT = 0.45
_SAME_AGAIN = 0.07
_LEAST_FITTING = 0.15
_AFTER_SITTING = ("look_around", "nod", "shake_head", "wave", "clap", "cross_arms", "drink", "point", "raise_arm")
_EXCERPT_WEIGHTS: Final = {"walk": 1.2, "kick": 0.4, "walk as told": 0.3}
_UNKNOWN_EXCERPT = 0.2  # of names that the vocabulary lacks


@dataclass(frozen=True)
class ActionCall:
    """One action with its parameters."""

    name: str
    params: Params


@dataclass(frozen=True)
class Part:
    """One segment to be: an authored action, or a captured one, with an arm action at the same time or not."""

    action: ActionCall | None = None
    excerpt: Excerpt | None = None
    arms: ActionCall | None = None

    @property
    def name(self) -> str:
        main = self.excerpt.name if self.excerpt else self.action.name if self.action else ""
        return f"{main}+{self.arms.name}" if self.arms else main

    @property
    def actions(self) -> tuple[tuple[str, Params], ...]:
        return tuple((action.name, action.params) for action in (self.excerpt, self.action, self.arms) if action)


def draw_plan(rng: np.random.Generator, count: int, excerpts: tuple[Excerpt, ...] = ()) -> tuple[Part, ...]:
    """The parts of a clip of `count` segments; with excerpts at least one of them is captured."""
    draw = Draw(rng, brief=rng.random() < BRIEF_SHARES[count - 1])
    captured = _captured_slots(rng, count) if excerpts else frozenset()
    plan: list[Part] = []
    for slot in range(count):
        if slot in captured:
            part = _draw_excerpt(rng, excerpts, first=slot == 0, last=slot == count - 1, brief=draw.brief)
        else:
            part = _draw_authored(draw, plan, limit=_longest(count), joined=slot + 1 in captured)
        plan.append(part)
    return tuple(plan)


def _captured_slots(rng: np.random.Generator, count: int) -> frozenset[int]:
    slots = frozenset(int(slot) for slot in range(count) if rng.random() < 0.4)
    return slots or frozenset((int(rng.integers(count)),))


def _draw_excerpt(
    rng: np.random.Generator, excerpts: tuple[Excerpt, ...], *, first: bool, last: bool, brief: bool
) -> Part:
    usable = [a for a in excerpts if not a.role or (a.role == "first" and first) or (a.role == "last" and last)]
    names = sorted({excerpt.name for excerpt in usable})
    takes = {name: {excerpt.take for excerpt in usable if excerpt.name == name} for name in names}
    weights = np.array([_excerpt_weight(name, len(takes[name])) for name in names])
    name = names[int(rng.choice(len(names), p=weights / weights.sum()))]
    same = [excerpt for excerpt in usable if excerpt.name == name]
    excerpt = same[int(rng.integers(len(same)))]
    excerpt = excerpt.mirrored if rng.random() < 0.5 else excerpt
    arms = None
    if name in ("walk", "jog") and rng.random() < _ARMS_OVER_EXCERPT:
        arms = _draw_action(Draw(rng), "arms", (), length(excerpt.pose) / FPS)
    elif excerpt.cyclic:
        excerpt = _window(rng, excerpt, brief=brief)
    return Part(excerpt=excerpt, arms=arms)


def _excerpt_weight(name: str, takes: int) -> float:
    """How often an excerpt of that name is drawn: the more, the more takes show it, as few would be seen too often."""
    return _EXCERPT_WEIGHTS.get(name, 1.0 if name in VOCABULARY else _UNKNOWN_EXCERPT) * takes**0.5


def _window(rng: np.random.Generator, excerpt: Excerpt, *, brief: bool) -> Excerpt:
    frames = length(excerpt.pose)
    longest = min(frames, round((2.2 if brief else 5.0) * FPS))
    size = int(rng.integers(min(longest, round(1.5 * FPS)), longest + 1))
    start = int(rng.integers(frames - size + 1))
    params = dict(excerpt.params)
    if "curve" in params:
        params["curve"] = params["curve"] * size / frames
    return Excerpt(**{**vars(excerpt), "pose": cut(excerpt.pose, start, start + size), "params": params})


def _draw_authored(draw: Draw, plan: list[Part], *, limit: float, joined: bool) -> Part:
    """The next authored part, mostly below `limit` s; `joined` where a captured one follows a standing person."""
    rng = draw.rng
    before = plan[-1] if plan else None
    if _sits(plan):
        names = [name for name in _AFTER_SITTING if name in ACTIONS]
        name = "stand_up" if joined or rng.random() < 0.7 else names[int(rng.integers(len(names)))]
        return Part(action=ActionCall(name, entry(name).sample(draw)))
    if before and before.action and not before.arms and rng.random() < _SAME_AGAIN:
        other = mirror_params(before.action.params)
        if other != before.action.params:
            return Part(action=ActionCall(before.action.name, other))
    avoid = (
        "stand_up",
        *(("sit_down",) if joined else ()),
        *((before.action.name,) if before and before.action else ()),
    )
    if rng.random() < _SIMULTANEOUS:
        legs = _draw_action(draw, "legs", ("stand", *avoid), limit, evenness=0.5)
        return Part(action=legs, arms=_draw_action(draw, "arms", (), limit, evenness=0.5))
    return Part(action=_draw_action(draw, "", avoid, limit))


def _sits(plan: list[Part]) -> bool:
    names = [part.action.name for part in plan if part.action]
    return "sit_down" in names and "stand_up" not in names[len(names) - names[::-1].index("sit_down") :]


def _draw_action(draw: Draw, part: str, avoid: tuple[str, ...], limit: float, evenness: float = 0.0) -> ActionCall:
    """An authored action of a part of the body ("" for any) that usually lasts at most `limit` s.

    At an `evenness` of 0 it is drawn as often as its weight says, at 1 all are alike: combinations want many kinds.
    Actions that fit into few clips are drawn the more often there.
    """
    names = [n for n in VOCABULARY if n in ACTIONS and n not in avoid and (not part or ACTIONS[n].part == part)]
    short = [name for name in names if usual_duration(name, draw.brief) <= limit] or names
    weights = np.array([VOCABULARY[name].weight ** (1 - evenness) / _fitting(name) for name in short])
    name = short[int(draw.rng.choice(len(short), p=weights / weights.sum()))]
    return ActionCall(name, entry(name).sample(draw))


def _longest(count: int) -> float:
    """How long an action in a clip of `count` segments should last at most, s."""
    return 1.15 * MAX_FRAMES / FPS / count


@cache
def _fitting(name: str) -> float:
    """Share of the segments of all clips that an action is short enough for."""
    share = np.array(SEGMENT_SHARES) * np.arange(1, len(SEGMENT_SHARES) + 1)
    share /= share.sum()
    fits = np.zeros((2, len(share)))
    for brief in (False, True):
        fits[int(brief)] = [usual_duration(name, brief) <= _longest(count) for count in range(1, len(share) + 1)]
    plain = 1 - np.array(BRIEF_SHARES)
    return float(max(_LEAST_FITTING, share @ (plain * fits[0] + (1 - plain) * fits[1])))


@cache
def usual_duration(name: str, brief: bool) -> float:
    """Median time in s that an action takes as it is drawn."""
    times = []
    for seed in range(5):
        scene = Scene(seed=seed)
        start = perform(scene, "sit_down") if name == "stand_up" else 0.0
        times.append(perform(scene, name, **entry(name).sample(Draw(np.random.default_rng(seed), brief))) - start)
    return float(np.median(times))
