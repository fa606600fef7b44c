"""Legs that move on the spot."""

import numpy as np

from generator.corpus.actions.record import Count, Speed, action
from generator.corpus.actions.support import on_one_leg, stand_evenly
from generator.corpus.body import BALL_HEIGHT, OTHER, SIGN, Side
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe, above, below, within


@action(
    "legs",
    Entry(
        lambda d: {"count": d.count(2, 6), "speed": d.speed()},
        (
            "<bounce> up and down {reps}",
            "<bounce> up and down",
            "<bounce> in place",
            "<bounce> {reps}",
            "<bend> {poss} knees slightly {times}",
            "<bob> up and down",
            "<bounce> on {poss} feet",
        ),
        legs="<bounce> up and down",
        weight=1.0,
    ),
    Probe(
        "",
        {
            "turn_range": below(8),
            "tiptoe": below(0.2),
            "bounces": above(1),
            "pelvis_range": within(0.03, 0.16),
            "lifts": below(0),
            "pitch_high": below(20),
            "path": below(0.3),
        },
        count="bounces",
    ),
)
def bounce(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Bounce in the knees, `count` times, the feet staying on the floor."""
    beat = scene.vary(0.52) / speed
    keys = [(t + (i + 1) * beat / 2, 0.012 if i % 2 else scene.vary(0.075)) for i in range(2 * count)]
    scene.move("crouch", t, *keys, (t + count * beat + 0.25, 0.0))
    return t + count * beat + 0.25


@action(
    "legs",
    Entry(
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<swing> {leg} {times}",
            "<swing> {leg} back and forth {reps}",
            "<swing> {leg} forward and back {times}",
            "<swing> {leg} forwards and backwards",
            "<move> {leg} back and forth {reps}",
            "<stand> on one leg and <swing> the other",
            "<kick> {leg} back and forth",
        ),
        legs="<swing> {leg} forward and back",
        weight=0.9,
    ),
    Probe(
        "foot",
        {
            "foot.behind": below(-0.2),
            "foot.front": above(0.22),
            "foot.toe": within(0.15, 0.4),
            "other_foot.longest_up": below(0.3),
            "foot.longest_up": above(0.5),
            "travel": below(0.4),
        },
        count="foot.swings",
    ),
)
def swing_leg(scene: Scene, t: float, *, side: Side = "right", count: Count = 2, speed: Speed = 1.0) -> float:
    """Swing a leg forward and back, `count` times, standing on the other one."""
    t = on_one_leg(scene, t, OTHER[side])
    home, foot, roll = scene.foot(side), f"foot_{side}", f"roll_{side}"
    beat = scene.vary(1.15) / speed

    def at(forward: float, up: float) -> list[float]:
        return [*scene.local(forward, 0.03 * SIGN[side], origin=home), BALL_HEIGHT + up, home[3]]

    front, middle, rear = at(0.42, scene.vary(0.20)), at(0.05, 0.07), at(-0.34, scene.vary(0.18))
    keys, tips = [], []
    for i in range(count):
        now = t + i * beat
        keys += [(now + 0.3 * beat, front), (now + 0.52 * beat, middle), (now + 0.75 * beat, rear)]
        keys += [(now + beat, middle)]
        tips += [(now + 0.3 * beat, -4.0), (now + 0.75 * beat, 48.0)]
    end = t + count * beat + 0.3
    scene.move(foot, t, *keys, (end, home))
    scene.move(roll, t, *[(time, np.radians(a)) for time, a in tips], (end - 0.05, 0.1), (end + 0.1, 0.0))
    return stand_evenly(scene, end)
