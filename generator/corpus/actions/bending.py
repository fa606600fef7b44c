"""Bending, leaning and twisting the trunk, and hips."""

from typing import Literal

import numpy as np

from generator.corpus.actions.record import Count, Hold, Size, Speed, action
from generator.corpus.actions.support import ZERO
from generator.corpus.body import OTHER, aim
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter, within


def _bend(scene: Scene, t: float, *, spine: float, pelvis: float, span: float, hold: float) -> float:
    """Bend forward by degrees at spine and hips, stay, straighten up; the end time."""
    down, end = t + span, t + span + hold
    scene.move("spine", t, (down, [0, spine, 0]), (end, [0, 1.03 * spine, 0]), (end + 1.1 * span, ZERO))
    scene.move("pelvis", t, (t + 0.92 * span, [0, pelvis, 0]), (end, [0, pelvis, 0]), (end + 0.9 * span, ZERO))
    scene.move("crouch", t, (down, 0.012), (end, 0.012), (end + span, 0.0))
    scene.move("gaze", t, (t + 0.7 * span, [0, 35]), (end + 0.2, [0, 35]), (end + 1.25 * span, [0, 0]))
    return end + 1.15 * span


_LEAN = {
    "left": ("to the left", "left", "to the left side", "towards the left"),
    "right": ("to the right", "right", "to the right side", "towards the right"),
    "forward": ("forward", "forwards"),
    "back": ("back", "backwards", "backward"),
}


def _bow_words(params: Params) -> Slots:
    depth = params["depth"]
    return {"deeply": ("deeply", "low", "") if depth > 1.18 else ("slightly", "a little", "") if depth < 0.8 else ("",)}


def _lean_words(params: Params) -> Slots:
    return {"way": _LEAN[params["direction"]]}


@action(
    "trunk",
    Entry(
        lambda d: {"depth": d.uniform(0.7, 1.3), "hold": d.hold(0.1, 0.8), "speed": d.speed()},
        (
            "<bow> {deeply}",
            "<take> a bow",
            "<bow> {deeply} forward",
            "<bend> forward at the waist to bow",
            "<bow> down {deeply}",
            "<bow> politely",
            "<do> a bow",
            "<bow> {deeply} and <straighten> up",
        ),
        slots=_bow_words,
        weight=2.2,
    ),
    Probe(
        "",
        {
            "one_leg": below(0.6),
            "pitch_high": within(20, 63),
            "pelvis_low": above(0.9),
            "turn_range": below(20),
            "travel": below(0.25),
        },
    ),
)
def bow(scene: Scene, t: float, *, depth: Size = 1.0, hold: Hold = 0.5, speed: Speed = 1.0) -> float:
    """Bow and rise again."""
    return _bend(scene, t, spine=24 * depth, pelvis=30 * depth, span=scene.vary(0.95) / speed, hold=hold)


@action(
    "trunk",
    Entry(
        lambda d: {"depth": d.uniform(0.75, 1.2), "hold": d.hold(0.2, 1.0), "speed": d.speed()},
        (
            "<bend> forward",
            "<bend> over",
            "<bend> down",
            "<bend> down towards {poss} toes",
            "<bend> over and <straighten> up",
            "<bend> down to touch {poss} toes",
            "<touch> {poss} toes",
            "<reach> down to {poss} toes",
            "<bend> over to touch the ground with {poss} hands",
            "<hunch> over",
            "<bend> at the waist",
            "<bend> forward towards the floor",
            "<lean> down towards {poss} feet",
        ),
        arms="<reach> down towards the toes",
        weight=1.5,
    ),
    Probe("", {"pitch_high": above(56), "pelvis_low": above(0.84)}),
)
def bend_forward(scene: Scene, t: float, *, depth: Size = 1.0, hold: Hold = 0.6, speed: Speed = 1.0) -> float:
    """Bend down towards the toes, the arms hanging."""
    spine, pelvis = min(56 * depth, 75), min(58 * depth, 75)
    return _bend(scene, t, spine=spine, pelvis=pelvis, span=scene.vary(1.35) / speed, hold=hold)


@action(
    "trunk",
    Entry(
        lambda d: {
            "direction": d.pick("left", "right", "forward", "back"),
            "hold": d.hold(0.3, 1.0),
            "speed": d.speed(),
        },
        (
            "<lean> {way}",
            "<tilt> {poss} body {way}",
            "<lean> {poss} body {way}",
            "<lean> {poss} upper body {way}",
            "<bend> {way}",
            "<tilt> {way}",
        ),
        slots=_lean_words,
        weight=1.5,
    ),
    Probe(
        "",
        {"one_leg": below(0.6), "turn_range": below(20), "travel": below(0.25), "pelvis_low": above(0.9)},
        {
            "left": {"roll_high": above(15), "roll_low": above(-8)},
            "right": {"roll_low": below(-15), "roll_high": below(8)},
            "forward": {"pitch_high": above(18), "roll_range": below(12)},
            "back": {"pitch_low": below(-14), "roll_range": below(12)},
        },
        wanted=parameter("direction"),
    ),
)
def lean(
    scene: Scene,
    t: float,
    *,
    direction: Literal["left", "right", "forward", "back"] = "left",
    hold: Hold = 0.6,
    speed: Speed = 1.0,
) -> float:
    """Lean the trunk over to one side, forward or back, and come upright."""
    span = scene.vary(0.9) / speed
    spine, pelvis = {
        "left": ([-26, 0, 3], [-6, 0, 0]),
        "right": ([26, 0, -3], [6, 0, 0]),
        "forward": ([0, 22, 0], [0, 16, 0]),
        "back": ([0, -24, 0], [0, -8, 0]),
    }[direction]
    end = t + span + hold
    scene.move("spine", t, (t + span, spine), (end, spine), (end + span, ZERO))
    scene.move("pelvis", t, (t + span, pelvis), (end, pelvis), (end + span, ZERO))
    if direction in ("left", "right"):
        upper, along = f"arm_{OTHER[direction]}", aim(0.08, 0.55, -0.83, 0.96)  # lies on the trunk, not in it
        rest = scene.tracks[upper].last
        scene.move(upper, t, (t + span, along), (end, along), (end + span, rest))
    return end + span


@action(
    "trunk",
    Entry(
        lambda d: {"count": d.count(1, 4), "speed": d.speed()},
        (
            "<twist> {poss} torso left and right",
            "<twist> {poss} upper body from side to side",
            "<twist> from side to side",
            "<twist> {poss} body left and right",
            "<rotate> {poss} torso from side to side",
            "<twist> {poss} waist",
            "<turn> {poss} upper body left and right",
        ),
    ),
    Probe(
        "",
        {"twist_low": below(-32), "twist_high": above(32), "pelvis_low": above(0.93), "travel": below(0.2)},
        count="twists",
    ),
)
def twist(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Turn the trunk to the left and to the right `count` times over still feet."""
    beat, spine, pelvis = scene.vary(1.5) / speed, [], []
    first = 1 if scene.rng.random() < 0.5 else -1
    for i in range(2 * count):
        side, now = first * (1 - 2 * (i % 2)), t + (i + 0.6) * beat / 2
        spine.append((now, [0, 2, scene.vary(42, 0.06) * side]))
        pelvis.append((now, [0, 0, 16 * side]))
    end = t + (count + 0.3) * beat
    scene.move("spine", t, *spine, (end, ZERO))
    scene.move("pelvis", t, *pelvis, (end, ZERO))
    return end


@action(
    "trunk",
    Entry(
        lambda d: {"count": d.count(1, 4), "speed": d.speed()},
        (
            "<sway> from side to side",
            "<sway> side to side",
            "<sway>",
            "<sway> left and right",
            "<shift> {poss} weight from side to side",
            "<rock> from side to side",
            "<sway> back and forth",
            "<sway> {poss} body from side to side",
            "<rock> back and forth",
            "<sway> {poss} hips",
            "<move> {poss} hips from side to side",
        ),
        legs="<shift> the weight from side to side",
    ),
    Probe(
        "hands",
        {
            "hand.lift": below(-0.4),
            "one_leg": below(0.6),
            "sways": above(1),
            "sway": above(0.1),
            "roll_range": above(8),
            "path": above(0.2),
            "turn_range": below(15),
        },
        count="sways",
    ),
)
def sway(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Shift the weight from side to side `count` times."""
    beat = scene.vary(1.9) / speed
    first = 1 if scene.rng.random() < 0.5 else -1
    offset, spine = [], []
    for i in range(2 * count):
        side, now = first * (1 - 2 * (i % 2)), t + (i + 0.7) * beat / 2
        offset.append((now, [0, scene.vary(0.13, 0.06) * side]))
        spine.append((now, [-9 * side, 0, 0]))
    end = t + (count + 0.4) * beat
    scene.move("offset", t, *offset, (end, [0, 0]))
    scene.move("spine", t, *spine, (end, ZERO))
    return end


@action(
    "trunk",
    Entry(
        lambda d: {"count": d.count(1, 4), "speed": d.speed()},
        (
            "<circle> {poss} hips {reps}",
            "<move> {poss} hips in circles",
            "<rotate> {poss} hips {reps}",
            "<move> {poss} hips in a circle {reps}",
            "<swing> {poss} hips around",
            "<sway> {poss} hips in a circle",
            "<do> {some:hip circle}",
            "<use> a hula hoop",
        ),
        legs="<circle> the hips",
    ),
    Probe(
        "hands",
        {
            "roll_range": above(8),
            "hand.away": below(0.4),
            "sway": within(0.08, 0.4),
            "shakes": above(0),
            "one_leg": below(0.3),
            "pitch_range": above(6),
        },
        count="sways",
    ),
)
def circle_hips(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Move the hips in level circles over still feet."""
    beat = scene.vary(1.7) / speed
    first = 1 if scene.rng.random() < 0.5 else -1
    offset, spine = [], []
    for i in range(8 * count):
        a, now = 2 * np.pi * i / 8, t + 0.4 + i / 8 * beat
        offset.append((now, [0.045 * np.cos(a), 0.10 * first * np.sin(a)]))
        spine.append((now, [10 * first * np.sin(a), 8 * np.cos(a), 0]))
    end = t + 0.8 + count * beat
    scene.move("offset", t, *offset, (end, [0, 0]))
    scene.move("spine", t, *spine, (end, ZERO))
    return end
