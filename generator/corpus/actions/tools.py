"""Hands with a tool: wiping, stirring, chopping, hammering, knocking."""

from generator.corpus.actions.hands import around, look_at_hands, there_and_back
from generator.corpus.actions.record import Count, Speed, action
from generator.corpus.body import OTHER, SIGN, Side, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe, above, below, within


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {"other_hand.away": below(0.6), "hand.range_y": above(0.45), "hand.lift": within(-0.75, -0.45)},
        count="hand.ins",
    ),
)
def wipe_table(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Wipe a table in level circles, the trunk bent a little over it."""
    ring = (
        hand_at(0.36, 0.36, -0.36),
        hand_at(0.46, 0.18, -0.34),
        hand_at(0.38, 0.00, -0.36),
        hand_at(0.28, 0.18, -0.38),
    )
    up, beat = scene.vary(0.75) / speed, scene.vary(1.05) / speed
    end = around(scene, t, side, ring, count=count, up=up, beat=beat)
    bend = [0, 18, 0]
    scene.move("spine", t, (t + up, bend), (end - 0.75, bend), (end, [0, 0, 0]))
    look_at_hands(scene, t, end, left=6 * SIGN[side])
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.range_y": above(0.24),
            "hand.extension": below(0.9),
            "hand.lift": within(-0.8, -0.22),
            "nod_high": above(14),
            "hand.ins": above(1),
        },
    ),
)
def stir(scene: Scene, t: float, *, side: Side = "right", count: Count = 4, speed: Speed = 1.0) -> float:
    """Stir in a pot that the other hand holds: `count` small level circles."""
    ring = (
        hand_at(0.33, 0.12, -0.20),
        hand_at(0.40, 0.05, -0.19),
        hand_at(0.33, -0.02, -0.20),
        hand_at(0.26, 0.05, -0.21),
    )
    up, beat = scene.vary(0.75) / speed, scene.vary(0.75) / speed
    end = around(scene, t, side, ring, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.28, 0.17, -0.32), up=up, hold=end - t - 2 * up)
    look_at_hands(scene, t, end)
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.downs": above(1),
            "hand.range_z": above(0.22),
            "hand.y": below(0.0),
            "hand.lift": within(-0.75, -0.2),
            "nod_high": above(13),
            "other_hand.extension": below(0.96),
        },
        count="hand.downs",
    ),
)
def chop(scene: Scene, t: float, *, side: Side = "right", count: Count = 4, speed: Speed = 1.0) -> float:
    """Cut on a board in front, up and down, the other hand holding what is cut."""
    up, beat = scene.vary(0.75) / speed, scene.vary(0.5) / speed
    keys = hand_at(0.32, 0.08, -0.18), hand_at(0.34, 0.08, -0.34)
    end = around(scene, t, side, keys, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.30, 0.08, -0.34), up=up, hold=end - t - 2 * up)
    look_at_hands(scene, t, end)
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {"hand.tops": above(2), "hand.shortest": below(0.62), "hand.front": within(0.55, 0.92)},
        count="hand.downs",
    ),
)
def hammer(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Swing a hammer from beside the head down in front."""
    up, beat = scene.vary(0.8) / speed, scene.vary(0.8) / speed
    keys = hand_at(0.12, 0.28, 0.16, 0.1), hand_at(0.40, 0.14, -0.22)
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.shortest": within(0.5, 0.62),
            "hand.folded": above(0.5),
            "hand.lift": within(-0.2, 0.15),
            "hand.x": above(0.5),
            "hand.longest": below(1.0),
            "hand.range_x": within(0.12, 0.35),
        },
        count="hand.pulses_x",
    ),
)
def knock(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Knock at a door in front at the height of the shoulder."""
    up, beat = scene.vary(0.75) / speed, scene.vary(0.36) / speed
    keys = hand_at(0.28, 0.15, 0.02, 0.1), hand_at(0.40, 0.13, 0.00, 0.1)
    return around(scene, t, side, keys, count=count, up=up, beat=beat)
