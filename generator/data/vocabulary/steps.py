"""What the feet do: steps, walks, turns, marching, jogging, dancing, standing."""

from generator.data.vocabulary.english import number
from generator.data.vocabulary.entry import Draw, Entry, Params, Slots

_WAYS = {
    "forward": ("forward", "forwards", "ahead"),
    "backward": ("backwards", "backward", "back"),
    "left": ("to the left", "left", "sideways to the left", "to {poss} left"),
    "right": ("to the right", "right", "sideways to the right", "to {poss} right"),
    "diagonal_left": ("diagonally to the left", "diagonally forward to the left", "forward and to the left"),
    "diagonal_right": ("diagonally to the right", "diagonally forward to the right", "forward and to the right"),
}
_STRAIGHT = ("forward", "forward", "forward", "forwards", "straight ahead", "ahead", "straight forward", "")
_FORWARD = ("forward", "forward", "forwards", "ahead")
MAX_STRAIGHT_DEG = 25.0


def _curve(curve: float) -> tuple[str, ...]:
    side = "left" if curve > 0 else "right"
    return (
        f"forward in a curve to the {side}",
        f"in a curve to the {side}",
        f"forward and to the {side}",
        f"forward curving to the {side}",
        f"in an arc to the {side}",
        f"forward while curving {side}",
    )


def _walk(params: Params) -> Slots:
    direction, curve, count = params["direction"], params.get("curve", 0.0), params.get("steps", 0)
    verb, way = ("<walk>",), _WAYS[direction]
    if direction in ("left", "right"):
        verb = ("<walk>", "<walk>", "<step>", "<sidestep>", "<shuffle>")
        count = count // 2  # a side step closes with the other foot
    elif direction == "forward":
        way = _curve(curve) if abs(curve) > MAX_STRAIGHT_DEG else _STRAIGHT
    onward = tuple(word for word in way if word)
    exact = (f"{number(count)} steps",) if count > 1 else ()
    steps = ("a few steps", "several steps", "some steps", *exact, *exact, *exact)
    return {"way": way, "onward": onward, "verb": verb, "steps": steps}


def _jog(params: Params) -> Slots:
    curve = params.get("curve", 0.0)
    fast = params.get("speed", 1.0) > 1.2
    way = _curve(curve) if abs(curve) > MAX_STRAIGHT_DEG else _FORWARD
    return {"way": way, "verb": ("<run>",) if fast else ("<jog>", "<jog>", "<run>")}


def _step(params: Params) -> Slots:
    return {"way": _WAYS[params["direction"]]}


def _circle(params: Params) -> Slots:
    side, other = params["direction"], {"left": "counterclockwise", "right": "clockwise"}[params["direction"]]
    return {
        "circle": (
            f"in a {other} circle",
            "in a circle",
            f"around in a circle to the {side}",
            f"{other} in a circle",
            "around in a circle",
            f"in a circle to the {side}",
        )
    }


def _turn(params: Params) -> Slots:
    angle = params["angle"]
    side, clock = ("left", "counterclockwise") if angle > 0 else ("right", "clockwise")
    size = abs(angle)
    if size > 300:
        return {
            "round": (
                "in a full circle",
                "360 degrees",
                f"in a full circle to the {side}",
                f"all the way around {clock}",
            ),
            "turn": ("<turn>", "<spin>", "<turn> around"),
        }
    if size > 150:
        around = ("around", "around", "around", f"around to the {side}", "180 degrees", f"around {clock}")
        return {"round": around, "turn": ("<turn>", "<turn>", "<rotate>")}
    ways = [f"to the {side}", f"to the {side}", side, f"to {{poss}} {side}"]
    ways += [f"90 degrees to the {side}", f"a quarter turn to the {side}"] if 80 < size < 100 else []
    ways += [f"slightly to the {side}", f"a little to the {side}"] if size < 55 else []
    return {"round": tuple(ways), "turn": ("<turn>", "<turn>", "<rotate>", "<pivot>")}


def _draw_walk(draw: Draw) -> Params:
    direction = draw.pick("forward", "backward", "left", "right", p=(0.62, 0.18, 0.1, 0.1))
    curve = draw.pick(0, 45, -45, 80, -80, p=(0.68, 0.08, 0.08, 0.08, 0.08)) if direction == "forward" else 0
    sideways = direction in ("left", "right")
    steps = 2 * draw.count(2, 4) if sideways else draw.count(3, 9)
    return {"direction": direction, "steps": steps, "size": draw.size(), "speed": draw.speed(), "curve": float(curve)}


ENTRIES = (
    Entry(
        "stand",
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
    Entry(
        "step",
        lambda d: {
            "direction": d.pick(*_WAYS, p=(0.26, 0.22, 0.2, 0.2, 0.06, 0.06)),
            "count": d.deeds(),
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
        slots=_step,
        legs="<step> {way}",
        weight=2.4,
    ),
    Entry(
        "walk",
        _draw_walk,
        (
            "{verb} {way}",
            "{verb} {way}",
            "{verb} {way}",
            "<take> {steps} {way}",
            "<move> {onward}",
            "<walk> {onward}",
        ),
        slots=_walk,
        arms="<swing> naturally",
        legs="<walk> {way}",
        weight=10.0,
    ),
    Entry(
        "walk_circle",
        lambda d: {"direction": d.side(), "steps": d.count(7, 12), "speed": d.speed()},
        (
            "<walk> {circle}",
            "<walk> {circle}",
            "<move> {circle}",
            "<go> {circle}",
            "<pace> {circle}",
            "<travel> {circle}",
        ),
        slots=_circle,
        arms="<swing> naturally",
        legs="<walk> {circle}",
        weight=2.5,
    ),
    Entry(
        "turn",
        lambda d: {
            "angle": float(d.pick(45, 90, 135, 180, 360, p=(0.12, 0.43, 0.1, 0.27, 0.08)) * d.pick(1, -1)),
            "speed": d.speed(),
        },
        (
            "{turn} {round}",
            "{turn} {round}",
            "<turn> {round}",
            "<turn> {round}",
            "{turn} {round} on the spot",
            "<turn> {poss} body {round}",
        ),
        slots=_turn,
        legs="<turn> {round}",
        weight=5.0,
    ),
    Entry(
        "march",
        lambda d: {"count": d.count(4, 9), "speed": d.speed()},
        (
            "<march> in place",
            "<march> on the spot",
            "<march>",
            "<march> in place with high knees",
            "<walk> in place",
            "<march> in place lifting {poss} knees",
            "<step> in place",
        ),
        arms="<swing> naturally",
        legs="<march> in place",
        weight=1.8,
    ),
    Entry(
        "jog_in_place",
        lambda d: {"count": d.count(5, 12), "speed": d.uniform(0.9, 1.2)},
        (
            "<jog> in place",
            "<run> in place",
            "<jog> on the spot",
            "<run> on the spot",
            "<jog> in one place",
            "<jog> without moving forward",
        ),
        arms="<swing> with bent elbows",
        legs="<jog> in place",
        weight=1.5,
    ),
    Entry(
        "jog",
        lambda d: {
            "steps": d.count(5, 11),
            "curve": float(d.pick(0, 60, -60, 100, -100, p=(0.6, 0.1, 0.1, 0.1, 0.1))),
            "speed": d.uniform(0.85, 1.35),
        },
        (
            "{verb} {way}",
            "{verb} {way}",
            "<jog> {way}",
            "{verb} {way}",
            "<jog> {way} lightly",
            "{verb} {way} at a steady pace",
        ),
        slots=_jog,
        arms="<swing> with bent elbows",
        legs="{verb} {way}",
        weight=3.0,
    ),
    Entry(
        "sneak",
        lambda d: {"steps": d.count(3, 6), "speed": d.uniform(0.8, 1.1)},
        (
            "<sneak> forward",
            "<sneak>",
            "<sneak> ahead quietly",
            "<tiptoe> forward",
            "<creep> forward",
            "<sneak> around",
            "<walk> forward stealthily",
        ),
        legs="<sneak> forward",
    ),
    Entry(
        "stomp",
        lambda d: {"side": d.side(), "count": d.deeds(4), "speed": d.speed()},
        (
            "<stomp> {foot} {times}",
            "<stomp> with {foot} {times}",
            "<stamp> {foot} {times}",
            "<stomp> {foot} on the floor {times}",
            "<stomp> {times}",
            "<stamp> {foot} on the ground {times}",
        ),
        legs="<stomp> {foot}",
    ),
    Entry(
        "dance",
        lambda d: {"count": d.count(3, 8), "speed": d.uniform(0.85, 1.25)},
        (
            "<dance>",
            "<dance> around",
            "<dance> from side to side",
            "<do> a little dance",
            "<dance> to music",
            "<dance> happily",
            "<do> a dance",
        ),
        arms="<swing> to the rhythm",
        legs="<dance> from side to side",
        weight=1.5,
    ),
)
