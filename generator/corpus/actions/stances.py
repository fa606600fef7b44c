"""Reaching down and up, and standing otherwise than on both flat feet."""

from typing import Literal

import numpy as np

from generator.corpus.actions.record import AnySide, Count, Hold, Speed, action, sides
from generator.corpus.actions.support import ZERO, lower, on_one_leg, share, stand_evenly
from generator.corpus.body import BALL_HEIGHT, OTHER, SIDES, SIGN, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, within


def _pick_up_words(params: Params) -> Slots:
    put_down = ("<set> {thing} down", "<put> {thing} down on the floor", "<place> {thing} on the ground")
    after = ("and <put> it up high", "and <place> it on a shelf", "and <lift> it up", "and <put> it up on a shelf")
    return {
        "thing": ("something", "an object", "a box" if params["side"] == "both" else "a ball"),
        "where": ("", "from the floor", "from the ground", "off the floor"),
        "moving": ("<lift> {thing} up", "<pick> up {thing}") if params["place"] == "up" else put_down,
        "handling": ("<grab> something", "<pick> something up", "<take> something"),
        "after": after if params["place"] == "up" else ("",),
    }


@action(
    "whole",
    Entry(
        lambda d: {
            "side": d.sides(0.4),
            "place": d.pick("none", "up", p=(0.7, 0.3)),
            "speed": d.speed(),
        },
        (
            "<pick> {thing} up {where} with {hand} {after}",
            "<pick> up {thing} {where} with {hand} {after}",
            "<bend> down and <pick> {thing} up with {hand} {after}",
            "<pick> something up {where} {after}",
            "<pick> up {thing} {where} {after}",
            "<bend> down to pick {thing} up with {hand} {after}",
            "<grab> {thing} {where} with {hand} {after}",
            "<lift> {thing} {where} with {hand} {after}",
            "{moving} with {hand}",
            "<bend> down and {handling} with {hand} {after}",
            "<reach> down and {handling} with {hand} {after}",
            "<reach> down to grab {thing} with {hand} {after}",
        ),
        slots=_pick_up_words,
        arms="<pick> something up with {hand}",
        legs="<bend> the knees",
        weight=2.0,
    ),
    Probe("hand", {"hand.floor": below(0.48), "pelvis_low": below(0.65)}),
)
def pick_up(
    scene: Scene, t: float, *, side: AnySide = "right", place: Literal["up", "none"] = "up", speed: Speed = 1.0
) -> float:
    """Take something from the floor in front and lift it to the chest ("up"), or only touch the floor ("none")."""
    span = scene.vary(1.15) / speed
    bottom, top = t + span + 0.28, t + 2 * span + 0.28
    end = top + 1.4 if place == "up" else top + 0.1 * span
    lower(scene, t, 0.37, 88, span)
    twist = 0.0 if side == "both" else -12 * SIGN[side]
    scene.tracks["spine"].key(t + span, [0, 44, -twist], 0.0)
    lower(scene, bottom, 0.0, 0.0, span)
    scene.move("gaze", t, (t + 0.4 * span, [0, 40]), (bottom + 0.9 * span, [0, 10]), (end, [0, 0]))
    if side != "both":
        knee = aim(0.60, 0.05, -0.80, 0.66)
        scene.move(f"arm_{OTHER[side]}", t, (t + span, knee), (bottom, knee), (top, scene.rest[OTHER[side]]))
    for s in sides(side):
        floor = scene.local(0.25, 0.10 * SIGN[s])
        scene.move(
            f"pin_{s}", t + 0.4 * span, (t + 0.45 * span, [*floor, 0.10, 0]), (t + span, [*floor, 0.09, 1]),
            (bottom, [*floor, 0.09, 1]), (bottom + 0.5 * span, [*floor, 0.10, 0]),
        )  # fmt: skip
        low, chest = aim(0.5, 0, -0.87, 0.97), hand_at(0.32, 0.06, -0.22)
        lifted = [(top, chest), (top + 0.6, chest)] if place == "up" else []
        scene.move(f"arm_{s}", t, (t + span, low), (bottom, low), *lifted, (end, scene.rest[s]))
        scene.move(f"roll_{s}", t, (t + span, 0.35), (bottom, 0.35), (bottom + 0.7 * span, 0.0))
    return end


@action(
    "whole",
    Entry(
        lambda d: {"speed": d.speed()},
        (
            "<stretch>",
            "<stretch> {poss} arms over {poss} head",
            "<stretch> both arms overhead while leaning to each side",
            "<stretch> {poss} arms",
            "<stretch> {poss} body from side to side",
            "<do> a stretch",
            "<stretch> {poss} arms above {poss} head",
            "<stretch> to both sides",
        ),
        arms="<stretch> both arms overhead",
        weight=1.5,
    ),
    Probe("hands", {"hand.away": above(1.8), "gap_low": below(1.2), "roll_range": above(20)}),
)
def stretch(scene: Scene, t: float, *, speed: Speed = 1.0) -> float:
    """Stretch both arms overhead and lean to one side and to the other."""
    span = scene.vary(1.5) / speed
    top = t + span + 0.5
    first = 1 if scene.rng.random() < 0.5 else -1
    spine, pelvis, now = [(t + span, [0, -10, 0]), (top, [0, -10, 0])], [(top, ZERO)], top
    for side in (first, -first):
        spine += [(now + 0.9, [-24 * side, -4, 5 * side]), (now + 1.5, [-20 * side, -4, 4 * side])]
        pelvis += [(now + 0.9, [-5 * side, 0, 0])]
        now += 1.5
    end = now + 0.95 * span
    scene.move("spine", t, *spine, (now + 0.8, ZERO))
    scene.move("pelvis", t, *pelvis, (now + 0.8, ZERO))
    scene.move("gaze", t, (t + span, [0, -25]), (now, [0, -15]), (now + 0.8, [0, 0]))
    for s in SIDES:
        scene.move(
            f"arm_{s}", t, (t + 0.5 * span, aim(0.8, 0.35, 0.1, 0.8, 0.3)), (t + span, aim(0, 0.12, 0.99, 0.985, 0.6)),
            (top, aim(-0.05, 0.10, 0.99, 0.99, 0.6)), (now, aim(-0.05, 0.10, 0.99, 0.99, 0.6)),
            (now + 0.5 * span, aim(0.4, 0.9, 0, 0.93, 0.1)), (end, scene.rest[s]),
        )  # fmt: skip
    return end


@action(
    "whole",
    Entry(
        lambda d: {"side": d.side(), "hold": d.hold(0.8, 2.6), "speed": d.speed()},
        (
            "<balance> on {leg}",
            "<stand> on {leg}",
            "<balance> on {foot}",
            "<lift> {other_leg} and <balance> on {leg}",
            "<stand> on one leg",
            "<balance> on one leg",
            "<hold> {poss} balance on {leg}",
            "<balance> on {leg} with {poss} arms out",
            "<stand> on {leg} with {poss} arms out to the sides",
            "<try> to balance on {leg}",
            "<stand> on {foot}",
        ),
        legs="<balance> on {leg}",
        weight=1.6,
        paced=False,
    ),
    Probe("foot", {"other_foot.longest_up": above(1.2), "airborne": below(0.08), "foot.longest_up": below(0.6)}),
)
def balance(scene: Scene, t: float, *, side: Side = "left", hold: Hold = 2.5, speed: Speed = 1.0) -> float:
    """Stand on one leg (`side`), the other one lifted and the arms spread."""
    free = OTHER[side]
    home, lift = scene.foot(free), on_one_leg(scene, t, side, 0.55)
    high = lift + 0.9 / speed
    end = high + hold
    raised = np.array([*scene.local(0.12, 0.02 * SIGN[side], origin=home), BALL_HEIGHT + scene.vary(0.22), home[3]])
    spread = aim(0.15, 1, -0.12, 0.95)
    beats = [high + i * 0.45 for i in range(1, int(hold / 0.45))]
    unrest = np.array([0.018, 0.018, 0.012, 0.04])
    wobble = [(x, raised + unrest * [scene.normal() for _ in range(4)]) for x in beats]
    scene.move(f"foot_{free}", lift, (high, raised), *wobble, (end, raised), (end + 0.8, home))
    scene.move(
        f"roll_{free}", lift - 0.1, *((x, np.radians(a)) for x, a in (
            (lift + 0.25, 24), (high, 22), (end, 22), (end + 0.7, 10), (end + 0.95, 0))),
    )  # fmt: skip
    hip = [-3 * SIGN[side], 0, 0]
    scene.move("pelvis", t, (high, hip), (end, hip), (end + 1, ZERO))
    for s in SIDES:
        sway = [(x, spread + np.array([0, 0.06 * scene.normal(), 0, 0])) for x in beats]
        scene.move(f"arm_{s}", t, (lift + 0.7, spread), *sway, (end, spread), (end + 1, scene.rest[s]))
    return stand_evenly(scene, end + 0.8, 0.6)


@action(
    "whole",
    Entry(
        lambda d: {"side": d.side(), "count": d.repeats(), "speed": d.speed()},
        (
            "<lunge> forward with {leg} {times}",
            "<lunge> with {leg} {times}",
            "<do> {some:lunge} with {leg}",
            "<step> forward into a lunge with {leg} {times}",
            "<lunge> {times}",
            "<lunge> forward {times}",
            "<do> {some:forward lunge}",
        ),
        legs="<lunge> with {leg}",
        weight=1.2,
    ),
    Probe(
        "foot",
        {
            "travel": below(0.3),
            "other_foot.knee_low": below(0.4),
            "foot.front": above(0.35),
            "pelvis_low": within(0.35, 0.86),
            "root_back": below(0.2),
            "foot.toe": below(0.22),
            "lifts": below(8),
        },
        count="foot.lunges",
    ),
)
def lunge(scene: Scene, t: float, *, side: Side = "right", count: Count = 1, speed: Speed = 1.0) -> float:
    """Step far out in front with one foot, dip, and push back."""
    other = OTHER[side]
    for _ in range(count):
        t = on_one_leg(scene, t, other)
        home, out, down = scene.foot(side), scene.vary(0.6) / speed, scene.vary(0.6) / speed
        landed, bottom = t + out, t + out + down
        up = bottom + 0.2 + down
        scene.swing_foot(side, t, landed, scene.local(scene.vary(0.70, 0.05), 0, origin=home), home[3], strike=-15)
        stand_evenly(scene, landed - 0.1, 0.4)
        scene.move(f"roll_{other}", t, (landed, 0.4), (bottom, 0.95), (bottom + 0.2, 0.95), (up + 0.5 * out, 0.0))
        lower(scene, landed, 0.26, 8, down)
        lower(scene, bottom + 0.2, 0.0, 0.0, down)
        scene.tracks["weight"].hold(bottom + 0.2)
        scene.tracks["weight"].key(up, share(other))
        scene.swing_foot(side, up, up + out, home[:2], home[3], toe_off=5, strike=4)
        t = stand_evenly(scene, up + out)
    return t


@action(
    "whole",
    Entry(
        lambda d: {"hold": d.hold(0.4, 1.4), "count": d.repeats(), "speed": d.speed()},
        (
            "<stand> on {poss} tiptoes {times}",
            "<rise> onto {poss} toes {times}",
            "<go> up on {poss} tiptoes {times}",
            "<stand> on {poss} toes {times}",
            "<raise> {poss} heels {times}",
            "<lift> {poss} heels off the floor {times}",
            "<do> {some:calf raise}",
        ),
        legs="<rise> onto the toes",
    ),
    Probe("", {"tiptoe": above(0.5)}, count="heels"),
)
def tiptoes(scene: Scene, t: float, *, hold: Hold = 1.0, count: Count = 1, speed: Speed = 1.0) -> float:
    """Rise on the toes, stay, and sink back, `count` times."""
    for _ in range(count):
        shift, up = scene.vary(0.5) / speed, scene.vary(0.6) / speed
        high, end = t + shift + up + hold, t + shift + 2 * up + hold
        scene.move("offset", t, (t + shift + 0.2 * up, [0.062, 0]), (high, [0.062, 0]), (end + 0.15, [0, 0]))
        for s in SIDES:
            angle = np.radians(scene.vary(36, 0.04))
            scene.move(f"roll_{s}", t + shift, (t + shift + up, angle), (high, angle), (end, 0.0))
        t = end + 0.15
    return t
