"""Arms that go up: waving, raising, lifting."""

from typing import Literal

from generator.corpus.actions.record import AnySide, Count, Hold, Size, Speed, action, sides
from generator.corpus.body import SIGN, Floats, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter, within

_RAISED = {
    "up": ("above {poss} head", "overhead", "up", "up in the air", "over {poss} head", "high"),
    "side": ("out to the side", "to the side", "sideways"),
    "forward": ("in front", "forward", "out in front", "straight out in front"),
}


def _raise_words(params: Params) -> Slots:
    both = params["side"] == "both"
    where = _RAISED[params["to"]]
    if both and params["to"] == "side":
        where = ("out to the sides", "to the sides", "out to both sides")
    it = "them" if both else "it"
    lowered = (
        f"and <lower> {it}",
        f"and <put> {it} down",
        f"and <lower> {it} again",
        f"and <bring> {it} back down",
        f"and <drop> {it}",
    )
    briefly = (*where, "", "", "") if params["to"] == "up" else where
    return {"where": where, "briefly": briefly, "after": lowered if params["lower"] else ("",)}


def _lift_words(params: Params) -> Slots:
    aside = {"up": ("", "overhead"), "side": ("to the side", "sideways"), "forward": ("in front", "in front")}
    if params["side"] == "both":
        aside["side"] = ("to the sides", "out to the sides")
    return {"where": _raise_words({**params, "lower": False})["where"], "aside": aside[params["to"]]}


@action(
    "arms",
    Entry(
        lambda d: {"side": d.sides(0.22), "count": d.count(1, 5), "size": d.size(), "speed": d.speed()},
        (
            "<wave> with {hand} {reps}",
            "<wave> {hand} {reps}",
            "<wave> with {hand}",
            "<wave> {arm} {reps}",
            "<wave> {reps}",
            "<wave> hello with {hand}",
            "<wave> goodbye with {hand}",
            "<raise> {hand} and <wave> {reps}",
            "<wave> {hand} in the air",
            "<greet> with {hand}",
            "<use> {hand} to wave",
            "<say> hello by waving {hand}",
            "<wave> {hand} back and forth {reps}",
            "<wave> {hand} from side to side {reps}",
            "<wave> at someone with {hand}",
            "<wave> to someone {reps}",
            "<make> a waving motion with {hand}",
            "<move> {hand} side to side {reps}",
            "<wave> {arm} in the air {reps}",
        ),
        arms="<wave> {hand}",
        weight=3.0,
    ),
    Probe(
        "hand",
        {
            "hand.extension": within(0.62, 0.9),
            "hand.x": below(0.62),
            "hand.range_x": below(0.6),
            "hand.ins": above(1),
            "hand.y": above(0.3),
            "hand.top": above(-0.1),
            "hand.range_y": above(0.1),
        },
        count="hand.ins",
    ),
)
def wave(
    scene: Scene, t: float, *, side: AnySide = "right", count: Count = 3, size: Size = 1.0, speed: Speed = 1.0
) -> float:
    """Raise a hand beside the head and wave it `count` times."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.46) / speed
    out, inside = hand_at(0.20, 0.40 + 0.10 * size, 0.22, -0.4), hand_at(0.18, 0.34 - 0.12 * size, 0.26, -0.5)
    end = t + up + count * beat
    for s in sides(side):
        swings = [
            (t + up + i / 2 * beat, (inside if i % 2 else out) + 0.03 * scene.normal()) for i in range(2 * count + 1)
        ]
        scene.move(f"arm_{s}", t, (t + 0.5 * up, hand_at(0.30, 0.32, -0.16, -0.2)), *swings)
        scene.relax(s, end + scene.vary(0.8) / speed)
    gaze = 0.0 if side == "both" else 6 * SIGN[side]
    scene.move("gaze", t, (t + 0.4, [gaze, -4]), (end, [gaze, -4]), (end + 0.6, [0, 0]))
    return end + 0.8 / speed


@action(
    "arms",
    Entry(
        lambda d: {
            "side": d.sides(0.45),
            "to": d.pick("up", "side", "forward", p=(0.55, 0.25, 0.2)),
            "hold": d.hold(0.3, 1.2),
            "lower": d.rng.random() < 0.45,
            "speed": d.speed(),
        },
        (
            "<raise> {arm} {briefly} {after}",
            "<lift> {arm} {briefly} {after}",
            "<raise> {hand} {briefly} {after}",
            "<lift> {hand} {briefly} {after}",
            "<put> {arm} {where} {after}",
            "<stretch> {arm} {where} {after}",
            "<hold> {arm} {where} {after}",
            "<bring> {arm} {where} {after}",
            "<extend> {arm} {where} {after}",
            "<reach> {arm} {where} {after}",
            "<move> {arm} {where} {after}",
        ),
        slots=_raise_words,
        arms="<raise> {arm} {where} {after}",
        weight=3.0,
    ),
    Probe(
        "hand",
        {
            "hand.shortest": above(0.85),
            "hand.to_chest": above(0.97),
            "hand.flaps": below(1),
            "hand.speed": above(1.5),
            "hand.range_x": below(1.35),
            "pelvis_range": below(0.16),
            "pitch_high": below(35),
        },
        {
            "up": {"hand.still_z": above(0.6)},
            "side": {"hand.still_y": above(0.7), "hand.lift": within(-0.35, 0.5)},
            "forward": {"hand.still_x": above(0.7), "hand.lift": within(-0.35, 0.5)},
        },
        wanted=parameter("to"),
    ),
)
def raise_arm(
    scene: Scene,
    t: float,
    *,
    side: AnySide = "both",
    to: Literal["up", "side", "forward"] = "up",
    hold: Hold = 0.8,
    lower: bool = True,
    speed: Speed = 1.0,
) -> float:
    """Raise the straight arm; `lower` brings it down again after `hold` seconds."""
    span = scene.vary({"up": 1.05, "side": 0.85, "forward": 0.75}[to]) / speed
    top = {
        "up": aim(0.12, 0.22, 0.97, 0.97, 0.5),
        "side": aim(0.10, 1, 0.05 + 0.04 * scene.normal(), 0.97),
        "forward": aim(1, 0.05, 0.04, 0.97),
    }[to]
    halfway = aim(0.75, 0.45, 0.05, 0.93, 0.2)
    for s in sides(side):
        start = t + (0.03 * abs(scene.normal()) if side == "both" else 0.0)
        arm = scene.tracks[f"arm_{s}"]
        scene.move(f"arm_{s}", start, *([(start + 0.52 * span, halfway)] if to == "up" else []), (start + span, top))
        arm.key(start + span + hold, top - [0, 0.05, 0, 0], 0.0)  # a held arm sinks a little
        if lower:
            if to == "up":
                arm.key(start + 1.5 * span + hold, halfway)
            scene.relax(s, start + 2 * span + hold)
    return t + (2 if lower else 1) * span + hold


@action(
    "arms",
    Entry(
        lambda d: {
            "side": d.sides(0.55),
            "to": d.pick("up", "side", "forward", p=(0.4, 0.35, 0.25)),
            "count": d.count(1, 4),
            "speed": d.speed(),
        },
        (
            "<move> {arm} up and down {aside} {reps}",
            "<lift> {arm} up and down {aside} {reps}",
            "<raise> and <lower> {arm} {aside} {times}",
            "<lift> and <lower> {arm} {aside} {times}",
            "<swing> {arm} up and down {aside} {reps}",
            "<move> {hand} up and down {aside} {reps}",
            "<lift> {arm} {where} {times}",
            "<raise> {arm} {where} {times}",
        ),
        slots=_lift_words,
        arms="<raise> and <lower> {arm}",
        weight=2.2,
    ),
    Probe(
        "hand",
        {
            "hand.speed": above(3.5),
            "hand.folded": above(0.82),
            "hand.back": above(-0.2),
            "hand.pulses": above(1),
            "hand.lift": above(-0.5),
        },
        {"up": {"hand.top": above(0.6)}, "side": {"hand.y": above(0.5)}, "forward": {"hand.x": above(0.5)}},
        wanted=parameter("to"),
        count="hand.pulses",
    ),
)
def lift_arms(
    scene: Scene,
    t: float,
    *,
    side: AnySide = "both",
    to: Literal["up", "side", "forward"] = "side",
    count: Count = 3,
    speed: Speed = 1.0,
) -> float:
    """Move the straight arms up and down, `count` times, overhead, sideways or in front."""
    beat = scene.vary({"up": 1.35, "side": 1.1, "forward": 1.0}[to]) / speed
    top = {
        "up": aim(0.15, 0.25, 0.95, 0.96, 0.4),
        "side": aim(0.10, 1, 0.10, 0.97),
        "forward": aim(1, 0.05, 0.10, 0.97),
    }
    low = aim(0.25, 0.25, -0.93, 0.96)
    keys: list[tuple[float, Floats]] = []
    for i in range(count):
        now = t + i * beat
        halfway = [(now + 0.25 * beat, aim(0.60, 0.65, 0.0, 0.94, 0.2))] if to == "up" else []
        again = [(now + 0.75 * beat, halfway[0][1])] if halfway else []
        keys += [*halfway, (now + 0.5 * beat, top[to]), *again, (now + beat, low)]
    for s in sides(side):
        scene.move(f"arm_{s}", t, *keys[:-1], (t + count * beat + 0.1, scene.rest[s]))
    return t + count * beat + 0.1
