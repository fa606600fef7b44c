"""Work of the hands: wiping, stirring, doors, loads."""

from generator.data.vocabulary.entry import Entry, Params, Slots


def _weights(params: Params) -> Slots:
    if params["style"] == "press":
        return {
            "doing": ("<lift> weights overhead", "<press> weights over {poss} head", "<push> a barbell overhead"),
            "exercise": ("shoulder press", "overhead press"),
            "moving": ("<push> {arm} up overhead",),
        }
    return {
        "doing": ("<lift> weights", "<lift> a dumbbell", "<curl> weights"),
        "exercise": ("bicep curl", "arm curl", "curl"),
        "moving": ("<bend> {arm} at the elbow", "<curl> {arm}", "<curl> {arm} up"),
    }


ENTRIES = (
    Entry(
        "wipe_table",
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<wipe> a table with {hand}",
            "<wipe> down a table with {hand}",
            "<clean> a table with {hand}",
            "<wipe> a table",
            "<clean> a counter",
            "<scrub> a surface with {hand}",
            "<wipe> off a surface with {hand}",
            "<dust> a table with {hand}",
            "<clean> something in front with {hand}",
            "<move> {hand} in circles over a table {reps}",
        ),
        arms="<wipe> a table with {hand}",
        weight=0.9,
    ),
    Entry(
        "stir",
        lambda d: {"side": d.side(), "count": d.count(2, 5), "speed": d.speed()},
        (
            "<stir> something with {hand}",
            "<stir> a pot with {hand}",
            "<stir> a pot",
            "<mix> something in a bowl with {hand}",
            "<stir> something in a bowl",
            "<make> a stirring motion with {hand}",
            "<cook> something",
            "<whisk> something with {hand}",
        ),
        arms="<stir> with {hand}",
        weight=0.8,
    ),
    Entry(
        "chop",
        lambda d: {"side": d.side(), "count": d.count(2, 5), "speed": d.speed()},
        (
            "<chop> something with {hand}",
            "<chop> vegetables",
            "<cut> something with {hand}",
            "<cut> vegetables with a knife in {hand}",
            "<chop> vegetables with {hand}",
            "<make> a chopping motion with {hand}",
            "<slice> something with {hand}",
        ),
        arms="<chop> with {hand}",
        weight=0.6,
    ),
    Entry(
        "hammer",
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<hammer> a nail with {hand} {times}",
            "<hammer> something with {hand}",
            "<swing> a hammer with {hand} {times}",
            "<use> a hammer with {hand}",
            "<hit> something with a hammer {times}",
            "<hammer> {times}",
            "<slam> {fist} down {times}",
            "<pound> {fist} down {times}",
        ),
        arms="<hammer> with {hand}",
        weight=0.6,
    ),
    Entry(
        "knock",
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<knock> on a door with {hand} {reps}",
            "<knock> on a door {reps}",
            "<knock> with {hand} {reps}",
            "<knock> at the door with {hand}",
            "<knock> {reps}",
            "<tap> on a window with {hand} {reps}",
            "<bang> on a door with {fist} {reps}",
        ),
        arms="<knock> with {hand}",
        weight=0.8,
    ),
    Entry(
        "open_door",
        lambda d: {"side": d.side(), "speed": d.speed()},
        (
            "<open> a door with {hand}",
            "<open> a door",
            "<open> the door with {hand}",
            "<open> something with {hand}",
            "<pull> a door open with {hand}",
            "<grab> a door handle with {hand} and <pull> the door open",
            "<reach> out with {hand} to open a door",
        ),
        arms="<open> a door with {hand}",
        weight=0.8,
    ),
    Entry(
        "pour",
        lambda d: {"side": d.side(), "hold": d.hold(0.4, 1.2), "speed": d.speed()},
        (
            "<pour> something with {hand}",
            "<pour> water into a cup with {hand}",
            "<pour> a drink with {hand}",
            "<pour> a drink",
            "<pour> water into a glass",
            "<pour> something into a cup with {hand}",
            "<tilt> {hand} to pour something",
        ),
        arms="<pour> with {hand}",
        weight=0.6,
    ),
    Entry(
        "pull",
        lambda d: {"side": d.sides(0.5), "count": d.deeds(), "speed": d.speed()},
        (
            "<pull> something with {hand} {times}",
            "<pull> a rope with {hand} {times}",
            "<pull> something back with {hand} {times}",
            "<pull> something towards {poss} body {times}",
            "<pull> {arm} back {times}",
            "<pull> something {times}",
            "<make> {some:pulling motion} with {hand}",
            "<tug> on a rope {times}",
        ),
        arms="<pull> something with {hand}",
        weight=0.9,
    ),
    Entry(
        "carry",
        lambda d: {"hold": d.hold(1.0, 3.0), "speed": d.speed()},
        (
            "<carry> a box",
            "<carry> something with both hands",
            "<hold> a box with both hands",
            "<carry> something in front of {poss} body",
            "<hold> something in front with both hands",
            "<carry> a heavy box in both hands",
            "<hold> something in both hands",
            "<hold> {poss} hands in front of {poss} body",
        ),
        arms="<carry> something with both hands",
        weight=1.2,
        paced=False,
    ),
    Entry(
        "lift_weights",
        lambda d: {
            "style": d.pick("curl", "press"),
            "side": d.sides(0.55),
            "count": d.count(1, 4),
            "speed": d.speed(),
        },
        (
            "{doing} with {hand} {times}",
            "{doing} {times}",
            "<do> {some:{exercise}} with {arm}",
            "<do> {some:{exercise}}",
            "<perform> {some:{exercise}} with {arm}",
            "{moving} {times}",
        ),
        slots=_weights,
        arms="{doing} with {hand}",
        weight=1.0,
    ),
)
