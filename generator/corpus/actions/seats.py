"""Down on a seat, and up again."""

from typing import Annotated

from generator.corpus.actions.record import Hold, Range, Speed, action
from generator.corpus.actions.support import ZERO
from generator.corpus.body import SIDES, STANDING_HEIGHT, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below

SeatHeight = Annotated[float, Range(0.3, 0.7)]
_LAP = hand_at(0.36, 0.12, -0.40, 0.1)


def _sit_words(params: Params) -> Slots:
    return {"chair": ("", "", "on a chair", "in a chair")}


@action(
    "whole",
    Entry(
        lambda d: {"height": d.uniform(0.42, 0.52), "speed": d.speed()},
        (
            "<sit> down {chair}",
            "<sit> down",
            "<take> a seat",
            "<sit> {chair}",
            "<sit> down {chair} with {poss} hands on {poss} lap",
            "<sit> down with {poss} hands on {poss} thighs",
            "<sit> down for a rest",
            "<lower> into a chair",
            "<have> a seat",
        ),
        slots=_sit_words,
        legs="<sit> down",
        weight=1.6,
    ),
    Probe(
        "",
        {"pelvis_start": above(0.75), "pelvis_end": below(0.82), "pitch_high": above(15), "travel": below(0.95)},
    ),
)
def sit_down(scene: Scene, t: float, *, height: SeatHeight = 0.46, speed: Speed = 1.0) -> float:
    """Sit down on a seat behind, hands on the thighs, and stay seated."""
    span = scene.vary(1.3) / speed
    drop = STANDING_HEIGHT - height - 0.16  # the hips go back, which lowers the legs' reach
    scene.move("crouch", t, (t + 0.5 * span, 0.45 * drop), (t + span, drop))
    scene.move("offset", t, (t + 0.35 * span, [0, 0]), (t + span, [-0.27, 0]))
    scene.move("pelvis", t, (t + 0.5 * span, [0, 26, 0]), (t + span, [0, 8, 0]), (t + 1.35 * span, [0, -8, 0]))
    scene.move("spine", t, (t + 0.5 * span, [0, 22, 0]), (t + span, [0, 20, 0]), (t + 1.4 * span, [0, 12, 0]))
    for s in SIDES:
        scene.move(f"arm_{s}", t, (t + 0.6 * span, aim(0.6, 0.15, -0.8, 0.85)), (t + 1.25 * span, _LAP))
    scene.rest = dict.fromkeys(SIDES, _LAP)
    scene.standing = False
    return t + 1.4 * span


@action(
    "whole",
    Entry(
        lambda d: {"speed": d.speed()},
        (
            "<stand> up",
            "<stand> back up",
            "<get> up",
            "<get> back up",
            "<rise> to {poss} feet",
            "<rise> up",
            "<come> to a stand",
            "<return> to a standing position",
            "<stand> up from the chair",
            "<get> up from the chair",
        ),
        legs="<stand> up",
    ),
    Probe("", {"pelvis_start": below(0.82), "pelvis_end": above(0.85), "travel": above(0.15)}),
)
def stand_up(scene: Scene, t: float, *, speed: Speed = 1.0) -> float:
    """Rise from a seat: lean forward, over the feet, and up."""
    span = scene.vary(1.35) / speed
    low = scene.tracks["crouch"].last[0]
    scene.rest = scene.hanging
    scene.move("spine", t, (t + 0.38 * span, [0, 26, 0]), (t + 1.08 * span, ZERO))
    scene.move("pelvis", t, (t + 0.42 * span, [0, 30, 0]), (t + span, ZERO))
    scene.move("crouch", t, (t + 0.30 * span, low), (t + span, 0.0))
    scene.move("offset", t, (t + 0.25 * span, [-0.24, 0]), (t + 0.62 * span, [0.01, 0]), (t + span, [0, 0]))
    for s in SIDES:
        scene.move(f"arm_{s}", t, (t + 0.5 * span, hand_at(0.42, 0.10, -0.36, 0.1)), (t + 1.15 * span, scene.rest[s]))
    scene.standing = True
    return t + 1.15 * span


@action(
    "whole",
    Entry(
        lambda d: {"height": d.uniform(0.42, 0.52), "hold": d.hold(0.3, 1.2), "speed": d.speed()},
        (
            "<sit> down and <stand> up",
            "<sit> down and <stand> back up",
            "<sit> down {chair} and <get> up",
            "<sit> {chair} and <stand> up again",
            "<take> a seat and <get> back up",
            "<sit> down for a moment and <stand> up",
        ),
        slots=_sit_words,
        legs="<sit> down and <stand> up",
        weight=1.2,
    ),
    Probe(
        "",
        {
            "pelvis_low": below(0.7),
            "pelvis_start": above(0.8),
            "pelvis_end": above(0.8),
            "root_back": above(0.25),
            "knee_low": above(0.4),
            "hand_low": above(0.6),
            "airborne": below(0.08),
        },
    ),
)
def sit_and_stand(scene: Scene, t: float, *, height: SeatHeight = 0.46, hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Sit down, stay for a while and stand up again."""
    seated = sit_down(scene, t, height=height, speed=speed)
    return stand_up(scene, seated + hold, speed=speed)
