"""Hands that clap, and hands that point."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from generator.corpus import body
from generator.corpus.actions.record import Angle, Count, Hold, Size, Speed, action
from generator.corpus.body import SIDES, Side, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter, within


def _point_words(params: Params) -> Slots:
    azimuth, elevation = params["azimuth"], params["elevation"]
    if elevation > 35:
        where = ("up", "upwards", "up at the sky")
    elif elevation < -25:
        where = ("down", "at the floor", "at the ground")
    elif azimuth > 35:
        where = ("to the left", "left", "towards the left")
    elif azimuth < -35:
        where = ("to the right", "right", "towards the right")
    else:
        where = ("forward", "ahead", "in front", "straight ahead", "at something in front")
    return {"where": where}


def _clap_words(params: Params) -> Slots:
    return {"where": {"chest": ("",), "head": ("above {poss} head", "overhead", "over {poss} head")}[params["height"]]}


def _pointed_wanted(params: Mapping[str, Any]) -> str:
    if "elevation" not in params or "azimuth" not in params:
        return ""
    azimuth, elevation = params["azimuth"], params["elevation"]
    if elevation > 35 or elevation < -25:
        return "up" if elevation > 0 else "down"
    return "left" if azimuth > 35 else "right" if azimuth < -35 else "forward"


@action(
    "arms",
    Entry(
        lambda d: {
            "count": d.count(1, 6),
            "size": d.size(),
            "height": d.pick("chest", "head", p=(0.75, 0.25)),
            "speed": d.speed(),
        },
        (
            "<clap> {where} {reps}",
            "<clap> {poss} hands {where} {reps}",
            "<clap> both hands {where} {reps}",
            "<applaud> {where}",
            "<bring> {poss} hands together {where} {reps}",
            "<give> a round of applause {where}",
            "<do> {some:clap} {where}",
            "<put> {poss} hands together and <clap> {where} {reps}",
        ),
        slots=_clap_words,
        arms="<clap> both hands {where}",
        weight=2.0,
    ),
    Probe(
        "hands",
        {"gap_low": below(0.27), "hand.y": above(-0.22), "hand.lift": above(-0.5), "claps": above(1)},
        {"chest": {"hand.lift": below(0.15)}, "head": {"hand.lift": above(0.15)}},
        wanted=parameter("height"),
        count="claps",
    ),
)
def clap(
    scene: Scene,
    t: float,
    *,
    count: Count = 4,
    size: Size = 1.0,
    height: Literal["chest", "head"] = "chest",
    speed: Speed = 1.0,
) -> float:
    """Clap the hands in front of the chest or over the head."""
    up, beat = scene.vary(0.6) / speed, scene.vary(0.42) / speed
    forward, z = (0.33, -0.16) if height == "chest" else (0.22, 0.36)
    together, apart = hand_at(forward, 0.035, z, -0.1), hand_at(forward - 0.02, 0.12 + 0.07 * size, z, -0.1)
    keys = [(t + up, apart)]
    for i in range(count):
        keys += [(t + up + (i + 0.45) * beat, together), (t + up + (i + 1) * beat, apart)]
    for s in SIDES:
        scene.move(f"arm_{s}", t, *keys)
        scene.relax(s, keys[-1][0] + 0.8 / speed)
    return keys[-1][0] + 0.8 / speed


@action(
    "arms",
    Entry(
        lambda d: {
            "side": d.side(),
            "azimuth": float(d.pick(0, 10, -10, 60, -60, p=(0.35, 0.15, 0.15, 0.175, 0.175))),
            "elevation": float(d.pick(0, 8, 50, -35, p=(0.4, 0.3, 0.2, 0.1))),
            "hold": d.hold(0.4, 1.4),
            "speed": d.speed(),
        },
        (
            "<point> {where} with {hand}",
            "<point> {where} with {arm}",
            "<point> {hand} {where}",
            "<point> {where}",
            "<point> {arm} {where}",
            "<use> {hand} to point {where}",
            "<point> {where} using {hand}",
            "<point> at something {where} with {hand}",
            "<gesture> {where} with {hand}",
        ),
        slots=_point_words,
        arms="<point> {where} with {hand}",
        weight=2.0,
    ),
    Probe(
        "hand",
        {
            "pelvis_range": below(0.16),
            "hand.extension": above(0.95),
            "hand.shortest": within(0.6, 0.985),
            "other_hand.lift": below(-0.45),
            "hand.away": above(0.55),
            "hand.hold": above(0.3),
            "hand.strokes": below(2),
        },
        {
            "forward": {"hand.still_x": above(0.75), "hand.lift": within(-0.3, 0.45)},
            "up": {"hand.lift": above(0.45)},
            "down": {"hand.lift": within(-0.85, -0.3), "hand.still_x": above(0.4)},
            "left": {"hand.azimuth": above(35)},
            "right": {"hand.azimuth": below(-35)},
        },
        wanted=_pointed_wanted,
    ),
)
def point(
    scene: Scene,
    t: float,
    *,
    side: Side = "right",
    azimuth: Angle = 0.0,
    elevation: Angle = 5.0,
    hold: Hold = 0.9,
    speed: Speed = 1.0,
) -> float:
    """Point and look in a direction: azimuth to the left of forward, elevation above the horizon (degrees)."""
    span = scene.vary(0.6) / speed
    a, e = np.radians([azimuth, elevation])
    direction = [np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)]
    out = np.append(body.direction_to_chart(direction, side), [0.985, 0.0])
    begin = 0.5 * (out + scene.rest[side]) - [0, 0.05, 0.18, 0]
    end = t + span + hold
    scene.move(f"arm_{side}", t, (t + 0.45 * span, begin), (t + span, out), (end, out))
    scene.relax(side, end + 0.75 / speed)
    look, turn = [np.clip(0.8 * azimuth, -70, 70), -0.5 * elevation], [0, 0, np.clip(0.25 * azimuth, -25, 25)]
    scene.move("gaze", t, (t + 0.35 * span, look), (end, look), (end + 0.7, [0, 0]))
    scene.move("spine", t, (t + span, turn), (end, turn), (end + 0.7, np.zeros(3)))
    return end + 0.75 / speed
