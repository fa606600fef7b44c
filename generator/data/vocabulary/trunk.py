"""What the trunk and the head do while the feet stay."""

from generator.data.vocabulary.entry import Entry, Params, Slots

_LEAN = {
    "left": ("to the left", "left", "to the left side", "towards the left"),
    "right": ("to the right", "right", "to the right side", "towards the right"),
    "forward": ("forward", "forwards"),
    "back": ("back", "backwards", "backward"),
}
_LOOK = {
    "left": ("to the left", "left", "over {poss} left shoulder"),
    "right": ("to the right", "right", "over {poss} right shoulder"),
    "up": ("up", "upwards", "up at the sky"),
    "down": ("down", "downwards", "down at the floor"),
}


def _bow(params: Params) -> Slots:
    depth = params["depth"]
    return {"deeply": ("deeply", "low", "") if depth > 1.18 else ("slightly", "a little", "") if depth < 0.8 else ("",)}


def _lean(params: Params) -> Slots:
    return {"way": _LEAN[params["direction"]]}


def _look(params: Params) -> Slots:
    return {"way": _LOOK[params["direction"]]}


ENTRIES = (
    Entry(
        "bow",
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
        slots=_bow,
        weight=2.2,
    ),
    Entry(
        "bend_forward",
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
    Entry(
        "lean",
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
        slots=_lean,
        weight=1.5,
    ),
    Entry(
        "twist",
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
    Entry(
        "sway",
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
    Entry(
        "circle_hips",
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
    Entry(
        "look_around",
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
    Entry(
        "look",
        lambda d: {"direction": d.pick("left", "right", "up", "down"), "hold": d.hold(0.4, 1.2), "speed": d.speed()},
        (
            "<look> {way}",
            "<turn> {poss} head and <look> {way}",
            "<gaze> {way}",
            "<glance> {way}",
            "<look> {way} for a moment",
            "<take> a look {way}",
        ),
        slots=_look,
        weight=1.3,
    ),
    Entry(
        "nod",
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
    Entry(
        "shake_head",
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
)
