"""Standing, stepping and walking."""

from typing import Literal

from generator.corpus.actions.footsteps import Curve, footstep, path, take
from generator.corpus.actions.record import Count, Hold, Size, Speed, action
from generator.corpus.actions.support import some_side
from generator.corpus.body import OTHER, SIGN, Side
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.english import number
from generator.corpus.vocabulary.entry import Draw, Entry, Params, Slots
from generator.corpus.vocabulary.ways import MAX_STRAIGHT_DEG, curved_ways
from generator.probes.spec import Probe, above, below, parameter, within

_WAYS = {
    "forward": ("forward", "forwards", "ahead"),
    "backward": ("backwards", "backward", "back"),
    "left": ("to the left", "left", "sideways to the left", "to {poss} left"),
    "right": ("to the right", "right", "sideways to the right", "to {poss} right"),
    "diagonal_left": ("diagonally to the left", "diagonally forward to the left", "forward and to the left"),
    "diagonal_right": ("diagonally to the right", "diagonally forward to the right", "forward and to the right"),
}
_STRAIGHT = ("forward", "forward", "forward", "forwards", "straight ahead", "ahead", "straight forward", "")


def _walk_words(params: Params) -> Slots:
    direction, curve, count = params["direction"], params.get("curve", 0.0), params.get("steps", 0)
    verb, way = ("<walk>",), _WAYS[direction]
    if direction in ("left", "right"):
        verb = ("<walk>", "<walk>", "<step>", "<sidestep>", "<shuffle>")
        count = count // 2  # a side step closes with the other foot
    elif direction == "forward":
        way = curved_ways(curve) if abs(curve) > MAX_STRAIGHT_DEG else _STRAIGHT
    onward = tuple(word for word in way if word)
    exact = (f"{number(count)} steps",) if count > 1 else ()
    steps = ("a few steps", "several steps", "some steps", *exact, *exact, *exact)
    return {"way": way, "onward": onward, "verb": verb, "steps": steps}


def _step_words(params: Params) -> Slots:
    return {"way": _WAYS[params["direction"]]}


def _draw_walk_words(draw: Draw) -> Params:
    direction = draw.pick("forward", "backward", "left", "right", p=(0.62, 0.18, 0.1, 0.1))
    curve = draw.pick(0, 45, -45, 80, -80, p=(0.68, 0.08, 0.08, 0.08, 0.08)) if direction == "forward" else 0
    sideways = direction in ("left", "right")
    steps = 2 * draw.count(2, 4) if sideways else draw.count(3, 9)
    return {"direction": direction, "steps": steps, "size": draw.size(), "speed": draw.speed(), "curve": float(curve)}


@action(
    "legs",
    Entry(
        lambda d: {"hold": d.hold(1.0, 2.6)},
        (
            "<stand> still",
            "<stand> in place",
            "<pause>",
            "<stay> still",
            "<wait> for a moment",
            "<stand> still for a moment",
            "<stand>",
            "<stop>",
        ),
        weight=0.8,
    ),
    Probe(
        "hands",
        {
            "hand.speed": below(2.2),
            "shake_range": below(5),
            "pelvis_range": below(0.04),
            "nod_range": below(9),
            "shrug": below(0.03),
            "roll_range": below(6),
            "path": below(0.17),
            "lifts": below(1),
            "turn_range": below(6),
        },
    ),
)
def stand(scene: Scene, t: float, *, hold: Hold = 1.0) -> float:
    """Stand for a while."""
    return t + hold


@action(
    "legs",
    Entry(
        lambda d: {
            "direction": d.pick(*_WAYS, p=(0.26, 0.22, 0.2, 0.2, 0.06, 0.06)),
            "count": d.repeats(),
            "size": d.size(),
            "speed": d.speed(),
        },
        (
            "<take> {some:{big} step} {way}",
            "<step> {way} {times}",
            "<take> {some:{big} step} {way}",
            "<step> {way} {times}",
            "<make> {some:{big} step} {way}",
            "<move> {some:step} {way}",
        ),
        slots=_step_words,
        legs="<step> {way}",
        weight=2.4,
    ),
    Probe(
        "",
        {"travel": within(0.15, 2.2), "pelvis_mid": above(0.955), "pace": below(0.7), "turn_range": below(30)},
        {
            "forward": {"ahead": above(0.15), "slant": within(-25, 25)},
            "backward": {
                "ahead": below(-0.15),
            },
            "left": {"slant": within(62, 118)},
            "right": {"slant": within(-118, -62)},
            "diagonal_left": {"slant": within(20, 66)},
            "diagonal_right": {"slant": within(-66, -20)},
        },
        wanted=parameter("direction"),
        count="paces",
    ),
)
def step(
    scene: Scene,
    t: float,
    *,
    direction: Literal["forward", "backward", "left", "right", "diagonal_left", "diagonal_right"] = "forward",
    count: Count = 1,
    size: Size = 1.0,
    speed: Speed = 1.0,
) -> float:
    """Single steps: one foot goes, the other one closes."""
    forward, left = {
        "forward": (0.42, 0), "backward": (-0.36, 0), "left": (0, 0.36), "right": (0, -0.36),
        "diagonal_left": (0.32, 0.28), "diagonal_right": (0.32, -0.28),
    }[direction]  # fmt: skip
    lead: Side = "left" if left > 0 else "right" if left < 0 else some_side(scene)
    centre, heading, plan = scene.centre, scene.heading, []
    for _ in range(count):
        centre = scene.local(forward * scene.vary(size, 0.05), left * size, origin=centre)
        plan += [footstep(scene, side, centre, heading) for side in (lead, OTHER[lead])]
    toe_off, strike = (16, -8) if forward > 0 else (8, 0)
    return take(scene, t, plan, scene.vary(0.62) / speed, shared=0.2, toe_off=toe_off, strike=strike)


@action(
    "legs",
    Entry(
        _draw_walk_words,
        (
            "{verb} {way}",
            "{verb} {way}",
            "{verb} {way}",
            "<take> {steps} {way}",
            "<move> {onward}",
            "<walk> {onward}",
        ),
        slots=_walk_words,
        arms="<swing> naturally",
        legs="<walk> {way}",
        weight=10.0,
    ),
    Probe(
        "",
        {"path": above(0.4), "pace": below(1.8), "lifts": above(2)},
        {
            "forward": {"ahead": above(0.4), "aside": within(-1.0, 1.0)},
            "backward": {"ahead": below(-0.35)},
            "left": {"aside": above(0.3), "ahead": within(-0.5, 0.5)},
            "right": {"aside": below(-0.3), "ahead": within(-0.5, 0.5)},
        },
        wanted=parameter("direction"),
    ),
)
def walk(
    scene: Scene,
    t: float,
    *,
    direction: Literal["forward", "backward", "left", "right"] = "forward",
    steps: Count = 6,
    curve: Curve = 0.0,
    size: Size = 1.0,
    speed: Speed = 1.0,
) -> float:
    """Walk; `curve` bends a forward walk (degrees in all, left positive); left and right are side steps."""
    period = scene.vary(0.56, 0.04) / speed**0.55
    if direction in ("left", "right"):
        lead: Side = "left" if direction == "left" else "right"
        centre, plan = scene.centre, []
        for _ in range(max(1, round(steps / 2))):
            centre = scene.local(0, SIGN[lead] * scene.vary(0.33, 0.06) * size, origin=centre)
            plan += [footstep(scene, s, centre, scene.heading) for s in (lead, OTHER[lead])]
        return take(scene, t, plan, period, shared=0.2, toe_off=12, strike=0)
    if direction == "backward":
        plan = path(scene, steps, -0.38 * size * speed**0.45, 0.0, width=0.085)
        return take(scene, t, plan, period, shared=0.2, toe_off=10, strike=10)
    plan = path(scene, steps, 0.62 * size * speed**0.45, curve)
    return take(scene, t, plan, period, shared=0.2, lift=0.045, toe_off=min(56 * speed**0.3 * size, 62), strike=-22)
