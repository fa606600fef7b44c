"""Playing music, and leading those who do."""

from generator.corpus.actions.hands import around, there_and_back
from generator.corpus.actions.record import Count, Speed, action
from generator.corpus.body import OTHER, SIGN, Side, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe, above, below, within


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.ups": above(1),
            "hand.lift": within(-0.85, -0.35),
            "hand.y": below(0.0),
            "other_hand.y": above(0.15),
            "other_hand.lift": within(-0.5, 0.1),
        },
    ),
)
def play_guitar(scene: Scene, t: float, *, side: Side = "right", count: Count = 5, speed: Speed = 1.0) -> float:
    """Strum with one hand before the belly while the other one holds the neck out to its own side."""
    up, beat = scene.vary(0.8) / speed, scene.vary(0.5) / speed
    strings = hand_at(0.24, 0.08, -0.22, 0.3), hand_at(0.24, 0.06, -0.36, 0.3)
    end = around(scene, t, side, strings, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.28, 0.40, -0.10), up=up, hold=end - t - 2 * up)
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.range_y": above(0.4),
            "other_hand.extension": below(0.75),
            "other_hand.lift": above(-0.25),
            "other_hand.y": within(-0.1, 0.4),
        },
    ),
)
def play_violin(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Bow to and fro with one hand; the other one holds the violin out from the chin."""
    up, beat = scene.vary(0.95) / speed, scene.vary(1.0) / speed
    strings = hand_at(0.30, 0.04, 0.00, 0.4), hand_at(0.32, 0.34, -0.16, 0.3)
    end = around(scene, t, side, strings, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.32, 0.26, 0.02, -0.3), up=up, hold=end - t - 2 * up)
    look = [20 * SIGN[OTHER[side]], 14]
    scene.move("gaze", t, (t + up, look), (end - 0.75, look), (end, [0, 0]))
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hands",
        {
            "hand.thrust": above(1.3),
            "hand.lift": within(-0.5, -0.12),
            "hand.range_z": above(0.25),
            "hand.downs": above(1),
            "gap_mid": within(0.4, 1.1),
        },
    ),
)
def play_drums(scene: Scene, t: float, *, count: Count = 6, speed: Speed = 1.0) -> float:
    """Drum: `count` strokes of either hand, in turn."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.44) / speed
    high, low = hand_at(0.32, 0.20, -0.08), hand_at(0.40, 0.16, -0.28)
    first: Side = "left" if scene.rng.random() < 0.5 else "right"
    end = around(scene, t, first, (high, low), count=count, up=up, beat=beat)
    around(scene, t, OTHER[first], (low, high), count=count, up=up, beat=beat)
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hands",
        {
            "gap_low": below(0.72),
            "hand.head_mid": above(1.0),
            "hand.lift": within(-0.65, -0.35),
            "hand.top": above(-0.52),
            "hand.range_y": above(0.12),
            "hand.extension": below(0.95),
        },
    ),
)
def play_piano(scene: Scene, t: float, *, count: Count = 5, speed: Speed = 1.0) -> float:
    """Both hands over a keyboard, going to and fro along it and up and down."""
    up, beat = scene.vary(0.75) / speed, scene.vary(0.8) / speed
    keys = (
        hand_at(0.38, 0.10, -0.28),
        hand_at(0.38, 0.16, -0.23),
        hand_at(0.38, 0.24, -0.28),
        hand_at(0.38, 0.17, -0.23),
    )
    first: Side = "left" if scene.rng.random() < 0.5 else "right"
    end = around(scene, t, first, keys, count=count, up=up, beat=beat)
    around(scene, t, OTHER[first], (*keys[2:], *keys[:2]), count=count, up=up, beat=beat)
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hands",
        {
            "hand.range_y": above(0.35),
            "hand.range_z": above(0.35),
            "hand.range_x": below(0.3),
            "hand.x": above(0.5),
            "hand.top": above(0.0),
        },
    ),
)
def conduct(scene: Scene, t: float, *, count: Count = 3, speed: Speed = 1.0) -> float:
    """Conduct an orchestra with both hands: down, in, out and up, `count` bars."""
    up, beat = scene.vary(0.75) / speed, scene.vary(1.3) / speed
    bar = hand_at(0.34, 0.20, 0.10), hand_at(0.38, 0.18, -0.20), hand_at(0.36, 0.08, -0.10), hand_at(0.32, 0.38, -0.10)
    return around(scene, t, "both", bar, count=count, up=up, beat=beat)
