"""Going down and coming up: squats, sitting, kneeling, picking up, balancing, stretching."""

from generator.data.vocabulary.entry import Entry, Params, Slots


def _pick_up(params: Params) -> Slots:
    after = ("and <put> it up high", "and <place> it on a shelf", "and <lift> it up", "and <put> it up on a shelf")
    return {
        "thing": ("something", "an object", "a box" if params["side"] == "both" else "a ball"),
        "where": ("", "from the floor", "from the ground", "off the floor"),
        "after": after if params["place"] == "up" else ("",),
    }


def _sit(params: Params) -> Slots:
    return {"chair": ("", "", "on a chair", "in a chair")}


ENTRIES = (
    Entry(
        "squat",
        lambda d: {"count": d.deeds(), "depth": d.uniform(0.75, 1.2), "speed": d.speed()},
        (
            "<squat> {times}",
            "<do> {some:squat}",
            "<squat> down and <stand> up {times}",
            "<squat> down and <stand> back up {times}",
            "<squat> down {times}",
            "<perform> {some:squat}",
            "<bend> {poss} knees into a squat {times}",
            "<squat> down and <rise> again {times}",
        ),
        legs="<squat> down and <stand> up",
        weight=2.2,
    ),
    Entry(
        "crouch",
        lambda d: {"hold": d.hold(0.4, 1.4), "depth": d.uniform(0.8, 1.15), "speed": d.speed()},
        (
            "<crouch> down",
            "<crouch>",
            "<crouch> down and <stand> back up",
            "<crouch> down for a moment",
            "<hold> a low squat",
            "<get> down into a crouch",
            "<crouch> low and <rise> again",
            "<duck> down",
        ),
        legs="<crouch> down and <rise> again",
        weight=1.2,
    ),
    Entry(
        "kneel",
        lambda d: {"side": d.side(), "hold": d.hold(0.3, 1.2), "speed": d.speed()},
        (
            "<kneel> down on {knee}",
            "<kneel> on {knee}",
            "<kneel> down",
            "<go> down on {knee}",
            "<kneel> down on {knee} and <get> up again",
            "<get> down on {knee}",
            "<take> a knee",
            "<kneel> on {knee} and <stand> back up",
        ),
        legs="<kneel> on {knee}",
        weight=1.2,
    ),
    Entry(
        "sit_down",
        lambda d: {"height": d.uniform(0.42, 0.52), "speed": d.speed()},
        (
            "<sit> down {chair}",
            "<sit> down",
            "<take> a seat",
            "<sit> {chair}",
            "<sit> down for a rest",
            "<lower> into a chair",
            "<have> a seat",
        ),
        slots=_sit,
        legs="<sit> down",
        weight=1.6,
    ),
    Entry(
        "stand_up",
        lambda d: {"speed": d.speed()},
        (
            "<stand> up",
            "<stand> back up",
            "<get> up",
            "<get> back up",
            "<rise> to {poss} feet",
            "<stand> up from the chair",
            "<get> up from the chair",
        ),
        legs="<stand> up",
    ),
    Entry(
        "sit_and_stand",
        lambda d: {"height": d.uniform(0.42, 0.52), "hold": d.hold(0.3, 1.2), "speed": d.speed()},
        (
            "<sit> down and <stand> up",
            "<sit> down and <stand> back up",
            "<sit> down {chair} and <get> up",
            "<sit> {chair} and <stand> up again",
            "<take> a seat and <get> back up",
            "<sit> down for a moment and <stand> up",
        ),
        slots=_sit,
        legs="<sit> down and <stand> up",
        weight=1.2,
    ),
    Entry(
        "pick_up",
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
        ),
        slots=_pick_up,
        arms="<pick> something up with {hand}",
        legs="<bend> the knees",
        weight=2.0,
    ),
    Entry(
        "stretch",
        lambda d: {"speed": d.speed()},
        (
            "<stretch>",
            "<stretch> {poss} arms over {poss} head",
            "<stretch> both arms overhead and <lean> to each side",
            "<stretch> {poss} arms",
            "<stretch> {poss} body from side to side",
            "<do> a stretch",
            "<stretch> {poss} arms above {poss} head",
            "<stretch> to both sides",
        ),
        arms="<stretch> both arms overhead",
        weight=1.5,
    ),
    Entry(
        "balance",
        lambda d: {"side": d.side(), "hold": d.hold(0.8, 2.6), "speed": d.speed()},
        (
            "<balance> on {leg}",
            "<stand> on {leg}",
            "<balance> on {foot}",
            "<lift> {other_leg} and <balance> on {leg}",
            "<stand> on one leg",
            "<balance> on one leg",
            "<hold> {poss} balance on {leg}",
            "<stand> on {foot}",
        ),
        legs="<balance> on {leg}",
        weight=1.6,
        paced=False,
    ),
    Entry(
        "lunge",
        lambda d: {"side": d.side(), "count": d.deeds(), "speed": d.speed()},
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
    Entry(
        "tiptoes",
        lambda d: {"hold": d.hold(0.4, 1.4), "count": d.deeds(), "speed": d.speed()},
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
)
