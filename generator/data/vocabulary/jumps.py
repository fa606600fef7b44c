"""Leaving the floor."""

from generator.data.vocabulary.entry import Draw, Entry, Params, Slots


def _turning(angle: float) -> tuple[str, ...]:
    """How a jump that turns by that many degrees is told."""
    side, size = "left" if angle > 0 else "right", abs(angle)
    if size > 300:
        return ("with a full turn", "360 degrees", "with a 360 degree spin")
    if size > 150:
        return ("with a half turn", "180 degrees", "around to face the other way", "with a 180 degree turn")
    return (f"with a quarter turn to the {side}", f"90 degrees to the {side}", f"with a turn to the {side}")


def _jump(params: Params) -> Slots:
    if angle := params.get("angle", 0.0):
        return {"way": _turning(angle)}
    if aside := params.get("aside", 0.0):
        side = "left" if aside > 0 else "right"
        return {"way": (f"to the {side}", f"sideways to the {side}", side)}
    if params["distance"] > 0.1:
        return {"way": ("forward", "forwards", "ahead")}
    if params["distance"] < -0.1:
        return {"way": ("backwards", "back", "backward")}
    repeated = ("up and down",) if params["count"] > 1 else ()
    high = ("high", "high in the air") if params["height"] > 0.27 else ()
    return {"way": ("", "up", "in place", "in the air", "straight up", *repeated, *high)}


def _hop(params: Params) -> Slots:
    return {"way": ("forward", "forwards", "ahead") if params["distance"] > 0 else ("",)}


def _draw_jump(draw: Draw) -> Params:
    """In place, forward, backward, to a side, or with a turn."""
    kind = draw.pick("", "forward", "backward", "aside", "turn", p=(0.40, 0.26, 0.08, 0.14, 0.12))
    sign, count = draw.pick(1, -1), draw.deeds()
    more: Params = {
        "": {},
        "forward": {"distance": draw.uniform(0.3, 0.75)},
        "backward": {"distance": -draw.uniform(0.25, 0.4)},
        "aside": {"aside": sign * draw.uniform(0.25, 0.45)},
        "turn": {"angle": float(sign * draw.pick(90, 180, 360, p=(0.5, 0.4, 0.1))), "count": 1},
    }[kind]
    height = draw.uniform(0.2, 0.34) if kind == "turn" else draw.uniform(0.12, 0.32)
    base = {"count": count, "height": height, "distance": 0.0, "speed": draw.uniform(0.9, 1.15)}
    return {**base, **more}


ENTRIES = (
    Entry(
        "jump",
        _draw_jump,
        (
            "<jump> {way} {times}",
            "<jump> {way} with both feet {times}",
            "<do> {some:jump} {way}",
            "<take> {some:jump} {way}",
            "<leap> {way} {times}",
            "<jump> {way} {times}",
        ),
        slots=_jump,
        legs="<jump> {way}",
        weight=2.2,
    ),
    Entry(
        "hop",
        lambda d: {
            "side": d.side(),
            "count": d.count(2, 5),
            "distance": d.pick(0.0, 0.0, d.uniform(0.2, 0.4)),
            "speed": d.uniform(0.9, 1.15),
        },
        (
            "<hop> {way} on {leg} {times}",
            "<hop> {way} on {foot} {times}",
            "<hop> {way} on one leg {times}",
            "<hop> {way} on {leg}",
            "<do> {some:hop} {way} on {leg}",
            "<jump> {way} on {leg} {times}",
            "<jump> {way} on one leg {times}",
        ),
        slots=_hop,
        legs="<hop> {way} on {leg}",
        weight=1.3,
    ),
    Entry(
        "jumping_jacks",
        lambda d: {"count": d.count(2, 5), "speed": d.uniform(0.9, 1.15)},
        (
            "<do> {some:jumping jack}",
            "<do> jumping jacks",
            "<perform> {some:jumping jack}",
            "<do> jumping jacks {reps}",
            "<perform> jumping jacks",
            "<do> some jumping jacks",
            "<jump> with {poss} arms and legs spreading out and in {reps}",
        ),
        arms="<raise> both arms to the sides and above the head",
        legs="<jump> with the legs apart and together",
        weight=1.5,
    ),
)
