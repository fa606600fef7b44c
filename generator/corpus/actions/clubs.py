"""Clubs and rackets, swung with the whole body."""

from typing import Literal

from generator.corpus.actions.record import Speed, action
from generator.corpus.body import OTHER, SIDES, SIGN, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, within


def _both_hands(scene: Scene, t: float, side: Side, *keys: tuple[float, tuple[float, float, float]]) -> None:
    """Both hands on one grip: (time, (forward, towards `side`, up)) from the middle between the shoulders."""
    for s in SIDES:
        sign = 1 if s == side else -1
        places = [(time, f, sign * a + 0.03, u) for time, (f, a, u) in keys]
        # The elbow of an arm that reaches across the chest is lifted before it.
        scene.move(f"arm_{s}", t, *[(time, hand_at(f, a, u, 0.1 + 8 * max(0.0, -a))) for time, f, a, u in places])
        scene.relax(s, keys[-1][0] + 0.9)


def _unwind(scene: Scene, t: float, turn: float, times: tuple[float, float, float, float], bend: float) -> None:
    """Trunk, hips and weight of a two-handed swing: bent forward, wound up, through, and upright again."""
    ready, back, hit, through = times
    scene.move(
        "spine", t, (ready, [0, bend, 0]), (back, [0, bend, -30 * turn]), (hit, [0, bend, 6 * turn]),
        (through, [0, 0.5 * bend, 30 * turn]), (through + 0.9, [0, 0, 0]),
    )  # fmt: skip
    hips = [(ready, [0, bend, 0]), (back, [0, bend, -16 * turn]), (hit, [0, bend, 12 * turn])]
    scene.move("pelvis", t, *hips, (through, [0, 0.4 * bend, 24 * turn]), (through + 0.9, [0, 0, 0]))
    scene.move("crouch", t, (ready, 0.05), (hit, 0.05), (through + 0.9, 0.0))
    scene.move("weight", t, (back, 0.5 - 0.15 * turn), (hit, 0.5 + 0.15 * turn), (through + 0.9, 0.5))


def _club_words(params: Params) -> Slots:
    golf = params["sport"] == "golf"
    way = {"right": "from right to left", "left": "from left to right"}[params["side"]]
    return {
        "club": ("a golf club",) if golf else ("a bat", "a baseball bat"),
        "ball": ("a golf ball",) if golf else ("a baseball", "a ball with a bat"),
        "swing": ("golf swing",) if golf else ("baseball swing",),
        "game": ("golf",) if golf else ("baseball",),
        "way": ("", "", way),
    }


def _racket_words(params: Params) -> Slots:
    stroke = params["stroke"]
    return {
        "stroke": (stroke,),
        "doing": ("<serve> a tennis ball", "<do> a tennis serve", "<serve> a ball")
        if stroke == "serve"
        else (f"<hit> a {stroke}", f"<play> a {stroke}", f"<swing> a tennis racket in a {stroke}"),
    }


@action(
    "whole",
    Entry(
        lambda d: {
            "sport": d.pick("golf", "baseball"),
            "side": d.pick("left", "right", p=(0.3, 0.7)),
            "speed": d.speed(),
        },
        (
            "<swing> {club} {way}",
            "<swing> {club}",
            "<hit> {ball}",
            "<do> a {swing}",
            "<take> a {swing}",
            "<play> {game}",
            "<swing> at {ball} {way}",
            "<swing> {club} with both hands {way}",
        ),
        slots=_club_words,
        arms="<swing> {club}",
        weight=1.0,
    ),
    Probe(
        "hands",
        {"gap_mid": below(0.78), "turn_range": within(30, 60), "twist_range": above(30), "hand.range_y": above(0.2)},
    ),
)
def swing_club(
    scene: Scene,
    t: float,
    *,
    sport: Literal["golf", "baseball"] = "golf",
    side: Side = "right",
    speed: Speed = 1.0,
) -> float:
    """Swing a golf club from below or a baseball bat at the height of the chest; `side` is where it is swung from."""
    set_up, wind, whip, follow = (scene.vary(x) / speed for x in (0.85, 0.75, 0.30, 0.40))
    ready, back = t + set_up, t + set_up + wind
    hit, through = back + whip, back + whip + follow
    start, far, contact, after = {
        "golf": ((0.30, 0.0, -0.44), (0.16, 0.30, 0.08), (0.32, 0.0, -0.42), (0.16, -0.30, 0.12)),
        "baseball": ((0.24, 0.16, -0.04), (0.16, 0.24, 0.06), (0.42, 0.0, -0.16), (0.20, -0.28, 0.06)),
    }[sport]
    _both_hands(scene, t, side, (ready, start), (back, far), (hit, contact), (through, after))
    _unwind(scene, t, -SIGN[side], (ready, back, hit, through), {"golf": 16.0, "baseball": 5.0}[sport])
    down = [0, 24 if sport == "golf" else 4]
    scene.move("gaze", t, (ready, down), (hit, down), (through, [-20 * SIGN[side], 0]), (through + 0.9, [0, 0]))
    return through + 0.95


@action(
    "whole",
    Entry(
        lambda d: {"stroke": d.pick("forehand", "backhand", "serve"), "side": d.side(), "speed": d.speed()},
        (
            "{doing} with {hand}",
            "{doing}",
            "<swing> a racket with {hand} for a {stroke}",
            "<hit> a tennis ball with a {stroke}",
            "<play> a tennis {stroke} with {hand}",
            "<make> a tennis {stroke} with {arm}",
            "<play> tennis",
            "<play> tennis with {hand}",
        ),
        slots=_racket_words,
        arms="{doing} with {hand}",
        weight=1.0,
    ),
    Probe(
        "hand",
        {
            "twist_range": above(38),
            "hand.range_z": above(0.3),
            "other_hand.folded": above(0.75),
            "hand.speed": above(4),
        },
    ),
)
def swing_racket(
    scene: Scene,
    t: float,
    *,
    stroke: Literal["forehand", "backhand", "serve"] = "forehand",
    side: Side = "right",
    speed: Speed = 1.0,
) -> float:
    """A tennis stroke with the hand of `side`: forehand, backhand, or a serve overhead."""
    turn = SIGN[side] if stroke == "backhand" else -SIGN[side]
    wind, whip, follow = (scene.vary(x) / speed for x in (0.75, 0.28, 0.42))
    back, hit = t + wind, t + wind + whip
    through = hit + follow
    far, contact, after = {
        "forehand": (aim(-0.30, 0.92, -0.25, 0.92), aim(0.85, 0.40, -0.12, 0.95), hand_at(0.30, -0.14, 0.04, 1.5)),
        "backhand": (hand_at(0.27, -0.20, -0.18, 1.2), aim(0.80, 0.40, -0.12, 0.95), aim(0.20, 0.95, 0.25, 0.94)),
        "serve": (hand_at(-0.08, 0.30, 0.20, 0.4), aim(0.40, 0.12, 0.90, 0.97, 0.4), aim(0.60, -0.25, -0.70, 0.93)),
    }[stroke]
    end = through + 0.9 / speed
    scene.move(f"arm_{side}", t, (back, far), (hit, contact), (through, after), (end, scene.rest[side]))
    free = aim(0.4, 0.15, 0.90, 0.96, 0.3) if stroke == "serve" else aim(0.6, 0.55, -0.35, 0.85)
    scene.move(
        f"arm_{OTHER[side]}", t, (back, free), (through, aim(0.2, 0.4, -0.85, 0.85)), (end, scene.rest[OTHER[side]])
    )
    scene.move(
        "spine", t, (back, [0, 0, -26 * turn]), (hit, [0, 4, 10 * turn]), (through, [0, 8, 22 * turn]), (end, [0, 0, 0])
    )
    scene.move("pelvis", t, (back, [0, 0, -14 * turn]), (hit, [0, 2, 10 * turn]), (end, [0, 0, 0]))
    scene.move("crouch", t, (back, 0.05), (through, 0.02), (end, 0.0))
    if stroke == "serve":
        scene.move("gaze", t, (back, [0, -25]), (hit, [0, -10]), (through, [0, 0]))
    return end
