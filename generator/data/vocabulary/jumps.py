"""Leaving the floor."""

from generator.data.vocabulary.entry import Entry, Params, Slots


def _jump(params: Params) -> Slots:
    if params["distance"] > 0.1:
        return {"way": ("forward", "forwards", "ahead")}
    if params["distance"] < -0.1:
        return {"way": ("backwards", "back", "backward")}
    repeated = ("up and down",) if params["count"] > 1 else ()
    high = ("high", "high in the air") if params["height"] > 0.27 else ()
    return {"way": ("", "up", "in place", "in the air", "straight up", *repeated, *high)}


ENTRIES = (
    Entry(
        "jump",
        lambda d: {
            "count": d.deeds(),
            "height": d.uniform(0.12, 0.32),
            "distance": float(d.pick(0.0, 0.4, 0.6, -0.35, p=(0.55, 0.2, 0.15, 0.1))),
            "speed": d.uniform(0.9, 1.15),
        },
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
        lambda d: {"side": d.side(), "count": d.count(2, 5), "speed": d.uniform(0.9, 1.15)},
        (
            "<hop> on {leg} {times}",
            "<hop> on {foot} {times}",
            "<hop> on one leg {times}",
            "<hop> up and down on {leg}",
            "<do> {some:hop} on {leg}",
            "<jump> on {leg} {times}",
            "<jump> on one leg {times}",
        ),
        legs="<hop> on {leg}",
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
