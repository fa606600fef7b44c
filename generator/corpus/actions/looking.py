"""The head: looking, nodding, shaking it."""

from typing import Literal

import numpy as np

from generator.corpus.actions.record import Count, Hold, Speed, action
from generator.corpus.actions.support import ZERO
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter

_LOOK = {
    "left": ("to the left", "left", "over {poss} left shoulder"),
    "right": ("to the right", "right", "over {poss} right shoulder"),
    "up": ("up", "upwards", "up at the sky"),
    "down": ("down", "downwards", "down at the floor"),
}


def _look_words(params: Params) -> Slots:
    return {"way": _LOOK[params["direction"]]}


@action(
    "trunk",
    Entry(
        lambda d: {"count": d.count(2, 3), "speed": d.speed()},
        (
            "<look> around",
            "<look> from side to side",
            "<look> left and right",
            "<look> around the room",
            "<look> in both directions",
            "<turn> {poss} head left and right",
            "<glance> around",
        ),
        weight=1.5,
    ),
    Probe(
        "",
        {
            "look_low": below(-20),
            "look_high": above(20),
            "turn_range": below(20),
            "travel": below(0.2),
            "gap_low": above(0.5),
        },
        count="looks",
    ),
)
def look_around(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Look to one side and the other, `count` looks in all."""
    side = 1 if scene.rng.random() < 0.5 else -1
    gaze, spine, pelvis = [], [], []
    for _ in range(count):
        angle, span, stay = scene.vary(62) * side, scene.vary(0.65) / speed, scene.vary(0.55)
        gaze += [(t + span, [angle, -3 + 4 * scene.normal()]), (t + span + stay, [1.04 * angle, 2])]
        spine += [(t + span + 0.12, [0, 0, 0.38 * angle]), (t + span + stay, [0, 0, 0.40 * angle])]
        pelvis.append((t + span + 0.15, [0, 0, 0.10 * angle]))
        t, side = t + span + stay, -side
    start = gaze[0][0] - 0.65 / speed
    scene.move("gaze", start, *gaze, (t + 0.7, [0, 0]))
    scene.move("spine", start, *spine, (t + 0.8, ZERO))
    scene.move("pelvis", start, *pelvis, (t + 0.8, ZERO))
    return t + 0.8


@action(
    "trunk",
    Entry(
        lambda d: {"direction": d.pick("left", "right", "up", "down"), "hold": d.hold(0.4, 1.2), "speed": d.speed()},
        (
            "<look> {way}",
            "<turn> {poss} head and <look> {way}",
            "<gaze> {way}",
            "<glance> {way}",
            "<look> {way} for a moment",
            "<take> a look {way}",
        ),
        slots=_look_words,
        weight=1.3,
    ),
    Probe(
        "",
        {"path": below(0.3), "turn_range": below(12)},
        {
            "left": {"look_high": above(20), "look_low": above(-10)},
            "right": {"look_low": below(-20), "look_high": below(10)},
            "up": {"nod_low": below(-20)},
            "down": {"nod_high": above(22), "nods": below(1), "nod_hold": above(0.5), "pitch_high": below(25)},
        },
        wanted=parameter("direction"),
    ),
)
def look(
    scene: Scene,
    t: float,
    *,
    direction: Literal["left", "right", "up", "down"] = "left",
    hold: Hold = 0.8,
    speed: Speed = 1.0,
) -> float:
    """Turn the head in a direction and back."""
    span = scene.vary(0.6) / speed
    left, down = {"left": (68, 0), "right": (-68, 0), "up": (0, -48), "down": (0, 46)}[direction]
    end = t + span + hold
    scene.move("gaze", t, (t + span, [left, down]), (end, [left, down]), (end + span, [0, 0]))
    bend = [0, 0.15 * down, 0.35 * left]
    scene.move("spine", t, (t + span + 0.1, bend), (end, bend), (end + span, ZERO))
    return end + span


@action(
    "trunk",
    Entry(
        lambda d: {"count": d.count(1, 4), "speed": d.speed()},
        (
            "<nod> {reps}",
            "<nod> {poss} head {reps}",
            "<nod> yes",
            "<nod> in agreement",
            "<move> {poss} head up and down",
            "<give> a nod",
        ),
    ),
    Probe(
        "",
        {"nod_high": above(12), "nods": above(1), "nod_hold": below(0.5), "path": below(0.3), "pitch_high": below(18)},
        count="nods",
    ),
)
def nod(scene: Scene, t: float, *, count: Count = 3, speed: Speed = 1.0) -> float:
    """Nod the head."""
    beat = scene.vary(0.55) / speed
    keys = [(t + (i + 0.5) * beat / 2 + 0.1, [0, -6 if i % 2 else scene.vary(30)]) for i in range(2 * count)]
    scene.move("gaze", t, *keys, (t + count * beat + 0.3, [0, 0]))
    return t + count * beat + 0.3


@action(
    "trunk",
    Entry(
        lambda d: {"count": d.count(1, 4), "speed": d.speed()},
        (
            "<shake> {poss} head",
            "<shake> {poss} head {reps}",
            "<shake> {poss} head no",
            "<shake> {poss} head from side to side",
            "<shake> {poss} head in disagreement",
            "<say> no by shaking {poss} head",
        ),
    ),
    Probe(
        "",
        {
            "shake_range": above(8),
            "shakes": above(1),
            "shake_high": above(3.5),
            "shake_low": below(-3.5),
            "turn_range": below(6),
            "path": below(0.2),
        },
        count="shakes",
    ),
)
def shake_head(scene: Scene, t: float, *, count: Count = 3, speed: Speed = 1.0) -> float:
    """Shake the head."""
    beat = scene.vary(0.62) / speed
    first = 1 if scene.rng.random() < 0.5 else -1
    angles = [scene.vary(40) * first * (1 - 2 * (i % 2)) for i in range(2 * count)]
    keys = [(t + (i + 0.5) * beat / 2 + 0.1, np.array([angle, 3.0])) for i, angle in enumerate(angles)]
    scene.move("gaze", t, *keys, (t + count * beat + 0.35, [0, 0]))
    turns = [(time + 0.03, [0, 0, 0.15 * angle]) for (time, _), angle in zip(keys, angles, strict=True)]
    scene.move("spine", t, *turns, (t + count * beat + 0.35, ZERO))
    return t + count * beat + 0.35
