"""Going down and up: squats, a crouch, a knee."""

import numpy as np

from generator.corpus.actions.record import Count, Hold, Size, Speed, action
from generator.corpus.actions.support import lower, on_one_leg, share, stand_evenly
from generator.corpus.body import OTHER, SIDES, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe, above, below, within


@action(
    "whole",
    Entry(
        lambda d: {"count": d.repeats(), "depth": d.uniform(0.75, 1.2), "speed": d.speed()},
        (
            "<squat> {times}",
            "<do> {some:squat}",
            "<squat> down and <stand> up {times}",
            "<squat> down and <stand> back up {times}",
            "<squat> down {times}",
            "<perform> {some:squat}",
            "<bend> {poss} knees into a squat {times}",
            "<bend> down at the knees {times}",
            "<squat> with {poss} arms out in front {times}",
            "<do> {some:deep squat}",
            "<squat> down and <rise> again {times}",
        ),
        legs="<squat> down and <stand> up",
        weight=2.2,
    ),
    Probe(
        "hands",
        {
            "pelvis_low": below(0.75),
            "hand.hip_mid": above(1.5),
            "airborne": below(0.06),
            "pelvis_start": above(0.85),
            "hand.floor": above(0.55),
            "root_back": below(0.26),
            "gap_mid": below(1.4),
            "pelvis_end": above(0.8),
        },
        count="dips",
    ),
)
def squat(scene: Scene, t: float, *, count: Count = 1, depth: Size = 1.0, speed: Speed = 1.0) -> float:
    """Knee bends with the arms stretched forward."""
    front = aim(1, 0.12, -0.05, 0.94)
    for i in range(count):
        span, stay, pause = scene.vary(0.85) / speed, scene.vary(0.14), scene.vary(0.1)
        bottom, end = t + span, t + 2 * span + stay
        lower(scene, t, scene.vary(min(0.34 * depth, 0.48), 0.05), 44 * depth**0.7, span)
        lower(scene, bottom + stay, 0.0, 0.0, span)
        scene.move("offset", t, (bottom, [0.015, 0]), (end, [0, 0]))
        for s in SIDES:
            rest = scene.rest[s] if i == count - 1 else 0.7 * scene.rest[s] + 0.3 * front
            scene.move(f"arm_{s}", t, (bottom - 0.05 * span, front), (bottom + stay, front), (end, rest))
        t = end + pause
    return t


@action(
    "whole",
    Entry(
        lambda d: {"hold": d.hold(0.4, 1.4), "depth": d.uniform(0.8, 1.15), "speed": d.speed()},
        (
            "<crouch> down",
            "<crouch>",
            "<crouch> down and <stand> back up",
            "<crouch> down for a moment",
            "<hold> a low squat",
            "<get> down into a crouch",
            "<crouch> low and <rise> again",
            "<duck> down",
            "<squat> down low",
            "<go> into a crouch",
            "<crouch> down on {poss} feet",
        ),
        legs="<crouch> down and <rise> again",
        weight=1.2,
    ),
    Probe(
        "hands",
        {
            "pelvis_mid": below(0.88),
            "pelvis_low": below(0.8),
            "hand.shortest": within(0.65, 0.88),
            "hand.hip_mid": within(1.0, 1.5),
            "root_back": below(0.29),
        },
    ),
)
def crouch(scene: Scene, t: float, *, hold: Hold = 1.0, depth: Size = 1.0, speed: Speed = 1.0) -> float:
    """Go down low, stay there with the hands on the knees, and rise."""
    span = scene.vary(1.0) / speed
    bottom = t + span + hold
    lower(scene, t, min(0.36 * depth, 0.46), 58 * depth**0.5, span)
    lower(scene, bottom, 0.0, 0.0, span)
    for s in SIDES:
        low = aim(0.80, 0.02, -0.60, 0.78)
        scene.move(f"arm_{s}", t, (t + span, low), (bottom, low), (bottom + span, scene.rest[s]))
    return bottom + 1.05 * span


@action(
    "whole",
    Entry(
        lambda d: {"side": d.side(), "hold": d.hold(0.3, 1.2), "speed": d.speed()},
        (
            "<kneel> down on {knee}",
            "<kneel> on {knee}",
            "<kneel> down",
            "<go> down on {knee}",
            "<kneel> down on {knee} and <get> up again",
            "<get> down on {knee}",
            "<take> a knee",
            "<kneel> on {knee} and <stand> back up",
        ),
        legs="<kneel> on {knee}",
        weight=1.2,
    ),
    Probe("foot", {"pelvis_low": below(0.55), "foot.knee_low": below(0.3), "foot.behind": below(-0.4)}),
)
def kneel(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Step back with one foot, go down on that knee, stay, and come up again."""
    other, home = OTHER[side], scene.foot(side)
    span, drop = scene.vary(1.15) / speed, 0.44
    t = on_one_leg(scene, t, other)
    landed = t + 0.55 / speed
    scene.swing_foot(side, t, landed, scene.local(-0.62, 0, origin=home), home[3], toe_off=20, strike=32)
    scene.tracks[f"roll_{side}"].key(landed + 0.12, np.radians(40))
    stand_evenly(scene, landed, 0.6 * span)
    down, leave = landed + span, landed + span + hold
    up = leave + span
    lower(scene, landed, drop, 10, span)
    scene.move(f"roll_{side}", landed + 0.12, (down, np.radians(72)), (leave, np.radians(72)), (up, np.radians(35)))
    lower(scene, leave, 0.0, 0.0, span)
    for s in SIDES:
        thigh = hand_at(0.34, 0.14, -0.42) if s == other else aim(0.35, 0.12, -0.85, 0.9)
        scene.move(f"arm_{s}", landed, (down, thigh), (leave, thigh), (up, scene.rest[s]))
    scene.tracks["weight"].hold(leave + 0.3 * span)
    scene.tracks["weight"].key(up, share(other))
    scene.swing_foot(side, up, up + 0.6 / speed, home[:2], home[3], toe_off=35, strike=-4)
    return stand_evenly(scene, up + 0.6 / speed)
