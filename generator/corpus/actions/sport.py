"""Balls, swimming, a fighter's guard."""

from typing import Literal

import numpy as np

from generator.corpus.actions.hands import around, there_and_back
from generator.corpus.actions.record import AnySide, Count, Hold, Speed, action
from generator.corpus.body import OTHER, SIDES, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, within


def _swim_words(params: Params) -> Slots:
    return {
        "style": {"breast": ("breaststroke",), "crawl": ("front crawl", "freestyle", "crawl")}[params["stroke"]],
        "like": {
            "breast": ("<move> both arms forward and out as if swimming", "<swim> with both arms"),
            "crawl": ("<swing> {poss} arms over {poss} head as if swimming", "<swim> with {poss} arms in turn"),
        }[params["stroke"]],
    }


@action(
    "arms",
    Entry(
        lambda d: {"side": d.side(), "count": d.count(1, 5), "speed": d.speed()},
        (
            "<dribble> a ball with {hand} {reps}",
            "<dribble> a basketball with {hand}",
            "<dribble> a basketball",
            "<bounce> a ball with {hand} {times}",
            "<bounce> a ball {times}",
            "<dribble> with {hand}",
            "<bounce> a basketball with {hand} {reps}",
        ),
        arms="<dribble> a ball with {hand}",
        weight=0.8,
    ),
    Probe(
        "hand",
        {
            "hand.y": above(0.12),
            "hand.front": below(0.82),
            "hand.lift": within(-0.95, -0.35),
            "hand.downs": above(1),
            "hand.range_z": within(0.2, 0.6),
            "hand.x": above(0.4),
        },
        count="hand.downs",
    ),
)
def bounce_ball(scene: Scene, t: float, *, side: Side = "right", count: Count = 4, speed: Speed = 1.0) -> float:
    """Bounce a ball beside the body: the hand pushes down from the waist."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.58) / speed
    keys = hand_at(0.32, 0.30, -0.22), hand_at(0.26, 0.30, -0.42)
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action(
    "arms",
    Entry(
        lambda d: {"side": d.sides(0.6), "speed": d.speed()},
        (
            "<catch> a ball",
            "<catch> a ball with {hand}",
            "<catch> something with {hand}",
            "<catch> something",
            "<catch> an object with {hand}",
            "<reach> out to catch a ball with {hand}",
            "<make> a catching motion with {hand}",
            "<raise> {hand} to catch a ball",
        ),
        arms="<catch> something with {hand}",
        weight=1.2,
    ),
    Probe(
        "hand",
        {
            "hand.front": within(0.83, 0.98),
            "hand.folded": within(0.5, 0.66),
            "hand.lift": within(-0.4, 0.3),
            "hand.hold": below(0.6),
            "hand.pulses_x": below(1),
        },
    ),
)
def catch(scene: Scene, t: float, *, side: AnySide = "both", speed: Speed = 1.0) -> float:
    """Reach out for a ball that comes from the front, and take it to the chest."""
    up, take, keep = scene.vary(0.6) / speed, scene.vary(0.32) / speed, scene.vary(0.5)
    caught, end = t + up + 0.15, t + up + 0.15 + take + keep
    out, chest = hand_at(0.45, 0.11, -0.02, 0.1), hand_at(0.24, 0.09, -0.16, 0.1)
    for s in SIDES if side == "both" else (side,):
        scene.move(f"arm_{s}", t, (t + up, out), (caught, out), (caught + take, chest), (end, chest))
        scene.relax(s, end + 0.75 / speed)
    bend = [0, -5, 0]
    scene.move("spine", t, (t + up, [0, 5, 0]), (caught + take, bend), (end + 0.6, [0, 0, 0]))
    return end + 0.75 / speed


@action(
    "arms",
    Entry(
        lambda d: {"stroke": d.pick("breast", "crawl"), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<swim>",
            "<swim> {style}",
            "<do> the {style}",
            "<make> swimming motions with {poss} arms",
            "<do> {some:{style} stroke}",
            "<pretend> to swim",
            "{like} {reps}",
            "<make> a swimming motion with both arms",
            "{like}",
        ),
        slots=_swim_words,
        arms="<swim> {style}",
        weight=0.9,
    ),
    Probe(
        "hand",
        {"hand.longest": above(0.9), "hand.y": below(0.75), "pelvis_range": below(0.13)},
        {
            "breast": {"hand.range_y": above(0.8), "hand.front": above(0.85), "gap_low": below(0.45)},
            "crawl": {"hand.top": above(0.6), "hand.range_x": above(1.0)},
        },
        wanted=lambda params: params.get("stroke", ""),
    ),
)
def swim(
    scene: Scene,
    t: float,
    *,
    stroke: Literal["breast", "crawl"] = "crawl",
    count: Count = 3,
    speed: Speed = 1.0,
) -> float:
    """Strokes of a swimmer in the air, `count` in all: "breast" with both arms, "crawl" with the arms in turn."""
    if stroke == "breast":
        ring = hand_at(0.26, 0.07, -0.10), aim(1, -0.1, 0.0, 0.96), aim(0.5, 0.85, -0.1, 0.95)
        return around(scene, t, "both", ring, count=count, up=scene.vary(0.7) / speed, beat=scene.vary(1.35) / speed)
    beat, lead = scene.vary(0.75) / speed, 0.3 / speed
    first: Side = "left" if scene.rng.random() < 0.5 else "right"
    ends = [t]
    for s in SIDES:
        start = t + lead + (0.0 if s == first else beat)
        keys = []
        for i in range((count + (s == first)) // 2):
            now = start + 2 * i * beat
            for k in range(1, 8):  # up behind and over the head, down in front
                a = 2 * np.pi * k / 8
                way = aim(-np.sin(a), 0.40 - 0.15 * np.cos(a), -np.cos(a), 0.93)
                keys.append((now + 1.7 * k / 8 * beat, way))
            keys.append((now + 1.8 * beat, scene.rest[s]))
        if keys:
            scene.move(f"arm_{s}", start, *keys)
            ends.append(keys[-1][0])
    return max(ends)


@action(
    "arms",
    Entry(
        lambda d: {"hold": d.hold(0.6, 1.8), "speed": d.speed()},
        (
            "<put> {poss} fists up",
            "<raise> {poss} fists",
            "<hold> up {poss} fists",
            "<get> into a boxing stance",
            "<take> a boxing stance",
            "<put> {poss} guard up",
            "<get> into a fighting stance",
            "<raise> both fists in front of {poss} face",
            "<block> with both arms",
        ),
        arms="<raise> both fists",
        weight=0.8,
    ),
    Probe(
        "hands",
        {
            "gap_mid": below(0.62),
            "gap_low": above(0.22),
            "hand.extension": within(0.38, 0.75),
            "hand.hold": above(0.4),
            "hand.lift": within(-0.5, 0.1),
            "hand.x": above(0.3),
        },
    ),
)
def guard(scene: Scene, t: float, *, hold: Hold = 1.4, speed: Speed = 1.0) -> float:
    """Raise both fists before the chin as a boxer, and lower them."""
    up = scene.vary(0.5) / speed
    front: Side = "left" if scene.rng.random() < 0.5 else "right"
    end = there_and_back(scene, t, front, hand_at(0.30, 0.09, -0.02, -0.1), up=up, hold=hold)
    there_and_back(scene, t, OTHER[front], hand_at(0.21, 0.09, -0.05, -0.1), up=up, hold=hold)
    return end
