"""What the arms do, free to be done over moving legs."""

from generator.data.vocabulary.entry import Entry, Params, Slots

_RAISED = {
    "up": ("above {poss} head", "overhead", "up", "up in the air", "over {poss} head", "high"),
    "side": ("out to the side", "to the side", "sideways"),
    "forward": ("in front", "forward", "out in front", "straight out in front"),
}


def _raise(params: Params) -> Slots:
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


def _lift(params: Params) -> Slots:
    aside = {"up": ("", "overhead"), "side": ("to the side", "sideways"), "forward": ("in front", "in front")}
    if params["side"] == "both":
        aside["side"] = ("to the sides", "out to the sides")
    return {"where": _raise({**params, "lower": False})["where"], "aside": aside[params["to"]]}


def _point(params: Params) -> Slots:
    azimuth, elevation = params["azimuth"], params["elevation"]
    if elevation > 35:
        where = ("up", "upwards", "up at the sky")
    elif elevation < -25:
        where = ("down", "at the floor", "at the ground")
    elif azimuth > 35:
        where = ("to the left", "left", "towards the left")
    elif azimuth < -35:
        where = ("to the right", "right", "towards the right")
    else:
        where = ("forward", "ahead", "in front", "straight ahead", "at something in front")
    return {"where": where}


def _reach(params: Params) -> Slots:
    return {
        "where": {
            "forward": ("forward", "out in front", "for something in front", "out"),
            "up": ("up", "upwards", "up high", "for something above", "for something up high"),
            "side": ("to the side", "out to the side", "sideways"),
        }[params["to"]]
    }


def _clap(params: Params) -> Slots:
    return {"where": {"chest": ("",), "head": ("above {poss} head", "overhead", "over {poss} head")}[params["height"]]}


def _touch(params: Params) -> Slots:
    target = params["target"]
    plain = target
    if params["side"] == "both" and target in ("shoulder", "hip"):
        plain += "s"
    return {"target": (plain,)}


ENTRIES = (
    Entry(
        "wave",
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
    Entry(
        "raise_arm",
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
        slots=_raise,
        arms="<raise> {arm} {where} {after}",
        weight=3.0,
    ),
    Entry(
        "lift_arms",
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
        slots=_lift,
        arms="<raise> and <lower> {arm}",
        weight=2.2,
    ),
    Entry(
        "clap",
        lambda d: {
            "count": d.count(1, 6),
            "size": d.size(),
            "height": d.pick("chest", "head", p=(0.75, 0.25)),
            "speed": d.speed(),
        },
        (
            "<clap> {where} {reps}",
            "<clap> {poss} hands {where} {reps}",
            "<clap> both hands {where} {reps}",
            "<applaud> {where}",
            "<bring> {poss} hands together {where} {reps}",
            "<give> a round of applause {where}",
            "<do> {some:clap} {where}",
            "<put> {poss} hands together and <clap> {where} {reps}",
        ),
        slots=_clap,
        arms="<clap> both hands {where}",
        weight=2.0,
    ),
    Entry(
        "point",
        lambda d: {
            "side": d.side(),
            "azimuth": float(d.pick(0, 10, -10, 60, -60, p=(0.35, 0.15, 0.15, 0.175, 0.175))),
            "elevation": float(d.pick(0, 8, 50, -35, p=(0.4, 0.3, 0.2, 0.1))),
            "hold": d.hold(0.4, 1.4),
            "speed": d.speed(),
        },
        (
            "<point> {where} with {hand}",
            "<point> {where} with {arm}",
            "<point> {hand} {where}",
            "<point> {where}",
            "<point> {arm} {where}",
            "<use> {hand} to point {where}",
            "<point> {where} using {hand}",
            "<point> at something {where} with {hand}",
            "<gesture> {where} with {hand}",
        ),
        slots=_point,
        arms="<point> {where} with {hand}",
        weight=2.0,
    ),
    Entry(
        "salute",
        lambda d: {"side": d.pick("left", "right", p=(0.3, 0.7)), "hold": d.hold(0.4, 1.2), "speed": d.speed()},
        (
            "<salute> with {hand}",
            "<salute>",
            "<give> a salute with {hand}",
            "<give> a salute",
            "<do> a military salute",
            "<raise> {hand} to salute",
            "<salute> using {hand}",
        ),
        arms="<salute> with {hand}",
    ),
    Entry(
        "scratch_head",
        lambda d: {"side": d.side(), "count": d.count(1, 5), "speed": d.speed()},
        (
            "<scratch> {poss} head with {hand}",
            "<scratch> {poss} head",
            "<raise> {hand} to scratch {poss} head",
            "<use> {hand} to scratch {poss} head",
            "<scratch> {poss} hair with {hand}",
            "<rub> {poss} head with {hand}",
        ),
        arms="<scratch> the head with {hand}",
    ),
    Entry(
        "cross_arms",
        lambda d: {"hold": d.hold(0.5, 1.6), "speed": d.speed()},
        (
            "<cross> {poss} arms",
            "<fold> {poss} arms",
            "<cross> both arms in front of {poss} chest",
            "<cross> {poss} arms over {poss} chest",
            "<fold> {poss} arms across {poss} chest",
            "<stand> with {poss} arms crossed",
            "<have> {poss} arms crossed",
            "<fold> {poss} hands in front of {poss} chest",
            "<hold> {poss} arms crossed in front",
        ),
        arms="<cross> both arms",
        paced=False,
    ),
    Entry(
        "hands_on_hips",
        lambda d: {"hold": d.hold(0.5, 1.6), "speed": d.speed()},
        (
            "<put> {poss} hands on {poss} hips",
            "<place> both hands on {poss} hips",
            "<put> both hands on {poss} hips",
            "<rest> {poss} hands on {poss} hips",
            "<stand> with {poss} hands on {poss} hips",
            "<hold> {poss} hips with both hands",
            "<have> {poss} hands on {poss} hips",
            "<stand> with both hands on {poss} waist",
            "<place> {poss} hands on {poss} waist",
        ),
        arms="<put> both hands on the hips",
        paced=False,
    ),
    Entry(
        "reach",
        lambda d: {
            "side": d.sides(),
            "to": d.pick("forward", "up", "side", p=(0.45, 0.35, 0.2)),
            "hold": d.hold(0.2, 0.8),
            "speed": d.speed(),
        },
        (
            "<reach> {where} with {hand}",
            "<reach> {where} with {arm}",
            "<reach> {where}",
            "<extend> {arm} {where}",
            "<reach> {hand} {where}",
            "<use> {hand} to reach {where}",
        ),
        slots=_reach,
        arms="<reach> {where} with {hand}",
        weight=1.3,
    ),
    Entry(
        "push",
        lambda d: {"side": d.sides(0.5), "count": d.deeds(), "speed": d.speed()},
        (
            "<push> something away with {hand} {times}",
            "<push> forward with {hand} {times}",
            "<push> something forward with {hand} {times}",
            "<push> with {hand} {times}",
            "<push> something {times}",
            "<push> {hand} forward {times}",
            "<shove> something away with {hand} {times}",
            "<make> {some:pushing motion} with {hand}",
            "<press> {hand} forward {times}",
            "<shove> something {times}",
        ),
        arms="<push> forward with {hand}",
        weight=1.2,
    ),
    Entry(
        "swing_arms",
        lambda d: {"count": d.count(1, 5), "speed": d.speed()},
        (
            "<swing> {poss} arms {reps}",
            "<swing> both arms {reps}",
            "<swing> {poss} arms back and forth {reps}",
            "<swing> both arms forward and back {reps}",
            "<swing> {poss} arms forwards and backwards",
            "<move> {poss} arms back and forth",
            "<swing> {poss} arms by {poss} sides {reps}",
            "<sway> {poss} arms back and forth",
            "<swing> {poss} arms around",
        ),
        arms="<swing> both arms forward and back",
    ),
    Entry(
        "circle_arms",
        lambda d: {"side": d.sides(0.5), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<circle> {arm} {reps}",
            "<rotate> {arm} {reps}",
            "<swing> {arm} in big circles {reps}",
            "<make> big circles with {arm}",
            "<make> {some:arm circle} with {arm}",
            "<move> {arm} in circles",
            "<do> arm circles",
            "<make> circular motions with {arm}",
            "<spin> {arm} around {reps}",
            "<move> {arm} in a circular motion {reps}",
            "<rotate> {arm} in circles {reps}",
        ),
        arms="<circle> {arm}",
    ),
    Entry(
        "flap_arms",
        lambda d: {"count": d.count(1, 6), "speed": d.speed()},
        (
            "<flap> {poss} arms {reps}",
            "<flap> both arms {reps}",
            "<flap> {poss} arms like a bird {reps}",
            "<flap> {poss} arms like wings",
            "<flap> {poss} arms up and down {reps}",
            "<flap> {poss} arms like a chicken",
            "<move> both arms like wings",
        ),
        arms="<flap> both arms",
    ),
    Entry(
        "drink",
        lambda d: {"side": d.side(), "speed": d.speed()},
        (
            "<drink> with {hand}",
            "<drink> something with {hand}",
            "<take> a drink with {hand}",
            "<drink> from a cup with {hand}",
            "<raise> a cup to {poss} mouth with {hand}",
            "<take> a drink",
            "<drink> from a cup",
            "<take> a sip with {hand}",
            "<drink> a glass of water",
            "<raise> {hand} to {poss} mouth to drink",
            "<drink>",
        ),
        arms="<drink> with {hand}",
    ),
    Entry(
        "wipe",
        lambda d: {"side": d.side(), "count": d.count(1, 5), "speed": d.speed()},
        (
            "<wipe> something with {hand}",
            "<wipe> a window with {hand} {reps}",
            "<wash> a window with {hand}",
            "<clean> a window with {hand}",
            "<wipe> a window",
            "<wipe> with {hand} {reps}",
            "<make> a wiping motion with {hand}",
        ),
        arms="<wipe> with {hand}",
    ),
    Entry(
        "shrug",
        lambda d: {"count": d.deeds(3), "speed": d.speed()},
        (
            "<shrug> {times}",
            "<shrug> {poss} shoulders {times}",
            "<raise> and <lower> {poss} shoulders {times}",
            "<lift> both shoulders {times}",
            "<give> {some:shrug}",
            "<shrug> both shoulders {times}",
        ),
        arms="<shrug> both shoulders",
    ),
    Entry(
        "touch",
        lambda d: {
            "side": d.sides(),
            "target": d.pick(
                "head", "face", "shoulder", "chest", "stomach", "hip", p=(0.3, 0.15, 0.15, 0.14, 0.13, 0.13)
            ),
            "speed": d.speed(),
        },
        (
            "<touch> {poss} {target} with {hand}",
            "<put> {hand} on {poss} {target}",
            "<bring> {hand} to {poss} {target}",
            "<touch> {poss} {target}",
            "<place> {hand} on {poss} {target}",
            "<reach> {hand} to {poss} {target}",
            "<hold> {hand} to {poss} {target}",
            "<raise> {hand} to {poss} {target}",
            "<rub> {poss} {target} with {hand}",
        ),
        slots=_touch,
        arms="<touch> the {target} with {hand}",
        weight=1.2,
    ),
    Entry(
        "beckon",
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<beckon> with {hand} {reps}",
            "<beckon>",
            "<beckon> someone over with {hand}",
            "<motion> someone to come closer with {hand}",
            "<wave> someone over with {hand}",
            "<gesture> to come here with {hand}",
        ),
        arms="<beckon> with {hand}",
    ),
    Entry(
        "shake_hand",
        lambda d: {"side": d.side(), "count": d.count(2, 4), "speed": d.speed()},
        (
            "<shake> hands with {hand}",
            "<shake> hands",
            "<shake> hands with someone",
            "<give> a handshake with {hand}",
            "<offer> {hand} for a handshake",
            "<extend> {hand} to shake hands",
        ),
        arms="<shake> hands with {hand}",
    ),
)
