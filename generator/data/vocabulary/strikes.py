"""Punches, kicks and throws."""

from generator.data.vocabulary.entry import Entry, Params, Slots


def _kick(params: Params) -> Slots:
    return {
        "high": {"low": ("low", ""), "middle": ("",), "high": ("high", "high", "")}[params["height"]],
        "way": {
            "forward": ("", "forward", "in front", "out in front"),
            "side": ("to the side", "sideways", "out to the side"),
        }[params["direction"]],
        "kick_name": {"forward": ("kick", "front kick"), "side": ("side kick", "sideways kick")}[params["direction"]],
    }


ENTRIES = (
    Entry(
        "punch",
        lambda d: {"side": d.side(), "count": d.deeds(), "speed": d.speed()},
        (
            "<punch> with {hand} {times}",
            "<punch> with {fist} {times}",
            "<punch> forward with {hand} {times}",
            "<throw> {some:punch} with {hand}",
            "<throw> {some:punch} with {arm}",
            "<throw> {some:punch}",
            "<punch> the air with {hand} {times}",
            "<punch> forward {times}",
            "<punch> {times}",
            "<jab> with {hand} {times}",
        ),
        arms="<punch> with {hand}",
        weight=1.8,
    ),
    Entry(
        "alternate",
        lambda d: {"count": d.count(2, 6), "speed": d.speed()},
        (
            "<box>",
            "<punch> with both hands in turn",
            "<throw> punches with both hands",
            "<punch> left and right in turn",
            "<throw> {some:punch} with alternating hands",
            "<do> some boxing",
            "<punch> with alternating hands {reps}",
            "<practice> boxing",
            "<fight> with both fists",
            "<spar>",
            "<throw> punches left and right",
            "<shadow> box",
        ),
        arms="<punch> with both hands in turn",
        weight=1.2,
    ),
    Entry(
        "throw",
        lambda d: {"side": d.side(), "speed": d.speed()},
        (
            "<throw> something with {hand}",
            "<throw> a ball with {hand}",
            "<throw> an object with {hand}",
            "<throw> something forward with {hand}",
            "<throw> something",
            "<throw> a ball",
            "<make> a throwing motion with {hand}",
            "<throw> with {arm}",
            "<toss> a ball with {hand}",
            "<throw> something overhand with {hand}",
            "<pitch> a ball with {hand}",
            "<toss> something with {hand}",
            "<do> an overhand throw with {arm}",
        ),
        arms="<throw> something with {hand}",
        weight=1.8,
    ),
    Entry(
        "kick",
        lambda d: {
            "side": d.side(),
            "height": d.pick("low", "middle", "high"),
            "direction": d.pick("forward", "side", p=(0.75, 0.25)),
            "count": d.deeds(),
            "speed": d.speed(),
        },
        (
            "<kick> {way} {high} with {leg} {times}",
            "<kick> with {leg} {way} {times}",
            "<kick> {leg} {way} {high} {times}",
            "<kick> with {foot} {way} {times}",
            "<do> {some:{high} {kick_name}} with {leg}",
            "<kick> {way} {times}",
            "<give> {some:{high} {kick_name}} with {foot}",
            "<kick> {way} {high} using {leg} {times}",
            "<kick> something {way} with {foot} {times}",
            "<kick> {foot} up {way} {times}",
            "<kick> out {way} with {leg} {times}",
            "<make> {some:kick} {way} with {leg}",
        ),
        slots=_kick,
        legs="<kick> {way} with {leg}",
        weight=2.2,
    ),
    Entry(
        "knee_lift",
        lambda d: {"side": d.side(), "count": d.deeds(), "speed": d.speed()},
        (
            "<lift> {knee} {times}",
            "<raise> {knee} {times}",
            "<raise> {leg} {times}",
            "<bring> {knee} up {times}",
            "<lift> {leg} up {times}",
            "<do> {some:knee lift} with {leg}",
            "<lift> {knee} high {times}",
            "<lift> {leg} off the ground {times}",
            "<bring> {knee} up to {poss} chest {times}",
            "<raise> {foot} {times}",
        ),
        legs="<lift> {knee}",
        weight=1.2,
    ),
)
