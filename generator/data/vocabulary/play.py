"""Music and sport with the hands."""

from generator.data.vocabulary.entry import Entry, Params, Slots


def _swim(params: Params) -> Slots:
    return {
        "style": {"breast": ("breaststroke",), "crawl": ("front crawl", "freestyle", "crawl")}[params["stroke"]],
        "like": {
            "breast": ("<move> both arms forward and out as if swimming", "<swim> with both arms"),
            "crawl": ("<swing> {poss} arms over {poss} head as if swimming", "<swim> with {poss} arms in turn"),
        }[params["stroke"]],
    }


def _club(params: Params) -> Slots:
    golf = params["sport"] == "golf"
    way = {"right": "from right to left", "left": "from left to right"}[params["side"]]
    return {
        "club": ("a golf club",) if golf else ("a bat", "a baseball bat"),
        "ball": ("a golf ball",) if golf else ("a baseball", "a ball with a bat"),
        "swing": ("golf swing",) if golf else ("baseball swing",),
        "game": ("golf",) if golf else ("baseball",),
        "way": ("", "", way),
    }


def _racket(params: Params) -> Slots:
    stroke = params["stroke"]
    return {
        "stroke": (stroke,),
        "doing": ("<serve> a tennis ball", "<do> a tennis serve", "<serve> a ball")
        if stroke == "serve"
        else (f"<hit> a {stroke}", f"<play> a {stroke}", f"<swing> a tennis racket in a {stroke}"),
    }


ENTRIES = (
    Entry(
        "play_guitar",
        lambda d: {"side": d.pick("left", "right", p=(0.25, 0.75)), "count": d.count(2, 6), "speed": d.speed()},
        (
            "<play> the guitar",
            "<play> a guitar",
            "<play> guitar",
            "<play> air guitar",
            "<strum> a guitar with {hand} {reps}",
            "<strum> with {hand} {reps}",
            "<play> the guitar with {hand}",
        ),
        arms="<strum> a guitar with {hand}",
        weight=0.8,
    ),
    Entry(
        "play_violin",
        lambda d: {"side": d.pick("left", "right", p=(0.25, 0.75)), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<play> the violin",
            "<play> a violin",
            "<play> violin",
            "<play> the violin with the bow in {hand}",
            "<bow> a violin with {hand}",
            "<practice> the violin",
            "<play> the fiddle",
        ),
        arms="<play> the violin with {hand}",
        weight=0.7,
    ),
    Entry(
        "play_drums",
        lambda d: {"count": d.count(2, 6), "speed": d.speed()},
        (
            "<play> the drums",
            "<play> drums",
            "<play> a drum with both hands",
            "<drum> with both hands",
            "<beat> a drum with both hands",
            "<drum>",
            "<move> both hands up and down in turn",
        ),
        arms="<drum> with both hands",
        weight=0.7,
    ),
    Entry(
        "play_piano",
        lambda d: {"count": d.count(1, 4), "speed": d.speed()},
        (
            "<play> the piano",
            "<play> a piano",
            "<play> piano",
            "<play> the piano with both hands",
            "<play> a keyboard",
            "<type> on a keyboard",
            "<type> with both hands",
        ),
        arms="<play> the piano",
        weight=0.6,
    ),
    Entry(
        "conduct",
        lambda d: {"count": d.count(1, 4), "speed": d.speed()},
        (
            "<conduct> an orchestra",
            "<conduct> music with both hands",
            "<conduct>",
            "<move> {poss} hands like a conductor",
            "<wave> {poss} arms like a conductor",
            "<lead> an orchestra with both hands",
            "<move> {poss} hands around",
            "<gesture> with both hands",
        ),
        arms="<conduct> with both hands",
        weight=0.7,
    ),
    Entry(
        "bounce_ball",
        lambda d: {"side": d.side(), "count": d.count(1, 5), "speed": d.speed()},
        (
            "<dribble> a ball with {hand} {reps}",
            "<dribble> a basketball with {hand}",
            "<dribble> a basketball",
            "<bounce> a ball with {hand} {times}",
            "<bounce> a ball {times}",
            "<dribble> with {hand}",
            "<bounce> a basketball with {hand} {reps}",
        ),
        arms="<dribble> a ball with {hand}",
        weight=0.8,
    ),
    Entry(
        "catch",
        lambda d: {"side": d.sides(0.6), "speed": d.speed()},
        (
            "<catch> a ball",
            "<catch> a ball with {hand}",
            "<catch> something with {hand}",
            "<catch> something",
            "<catch> an object with {hand}",
            "<reach> out to catch a ball with {hand}",
            "<make> a catching motion with {hand}",
            "<raise> {hand} to catch a ball",
        ),
        arms="<catch> something with {hand}",
        weight=1.2,
    ),
    Entry(
        "swim",
        lambda d: {"stroke": d.pick("breast", "crawl"), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<swim>",
            "<swim> {style}",
            "<do> the {style}",
            "<make> swimming motions with {poss} arms",
            "<do> {some:{style} stroke}",
            "<pretend> to swim",
            "{like} {reps}",
            "<make> a swimming motion with both arms",
            "{like}",
        ),
        slots=_swim,
        arms="<swim> {style}",
        weight=0.9,
    ),
    Entry(
        "guard",
        lambda d: {"hold": d.hold(0.6, 1.8), "speed": d.speed()},
        (
            "<put> {poss} fists up",
            "<raise> {poss} fists",
            "<hold> up {poss} fists",
            "<get> into a boxing stance",
            "<take> a boxing stance",
            "<put> {poss} guard up",
            "<get> into a fighting stance",
            "<raise> both fists in front of {poss} face",
            "<block> with both arms",
        ),
        arms="<raise> both fists",
        weight=0.8,
    ),
    Entry(
        "swing_club",
        lambda d: {
            "sport": d.pick("golf", "baseball"),
            "side": d.pick("left", "right", p=(0.3, 0.7)),
            "speed": d.speed(),
        },
        (
            "<swing> {club} {way}",
            "<swing> {club}",
            "<hit> {ball}",
            "<do> a {swing}",
            "<take> a {swing}",
            "<play> {game}",
            "<swing> at {ball} {way}",
            "<swing> {club} with both hands {way}",
        ),
        slots=_club,
        arms="<swing> {club}",
        weight=1.0,
    ),
    Entry(
        "swing_racket",
        lambda d: {"stroke": d.pick("forehand", "backhand", "serve"), "side": d.side(), "speed": d.speed()},
        (
            "{doing} with {hand}",
            "{doing}",
            "<swing> a racket with {hand} for a {stroke}",
            "<hit> a tennis ball with a {stroke}",
            "<play> a tennis {stroke} with {hand}",
            "<make> a tennis {stroke} with {arm}",
            "<play> tennis",
            "<play> tennis with {hand}",
        ),
        slots=_racket,
        arms="{doing} with {hand}",
        weight=1.0,
    ),
)
