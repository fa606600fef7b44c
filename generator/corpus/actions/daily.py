"""What hands do every day: eating, brushing, the watch, the telephone."""

from generator.corpus.actions.hands import around, look_at_hands, there_and_back
from generator.corpus.actions.record import Count, Hold, Speed, action
from generator.corpus.body import OTHER, SIGN, Side, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe, above, below, within


@action(
    "arms",
    Entry(
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<eat> with {hand}",
            "<eat> something",
            "<eat> something with {hand}",
            "<take> {some:bite} of food",
            "<eat> food with a spoon in {hand}",
            "<bring> food to {poss} mouth with {hand} {reps}",
            "<eat> from a plate with {hand}",
            "<eat>",
        ),
        arms="<eat> with {hand}",
        weight=0.7,
    ),
    Probe(
        "hand",
        {
            "hand.to_head": below(0.46),
            "hand.still_z": below(0.35),
            "nod_high": above(9),
            "other_hand.lift": below(-0.25),
            "other_hand.extension": below(0.9),
        },
        count="hand.bites",
    ),
)
def eat(scene: Scene, t: float, *, side: Side = "right", count: Count = 2, speed: Speed = 1.0) -> float:
    """Take `count` bites: the hand goes from a plate in front to the mouth, the other one holds the plate."""
    plate, mouth = hand_at(0.30, 0.08, -0.26, 0.0), hand_at(0.21, 0.07, 0.05, 0.1)
    up, beat = scene.vary(0.7) / speed, scene.vary(1.15) / speed
    end = around(scene, t, side, (plate, mouth), count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.27, 0.06, -0.30), up=up, hold=end - t - 2 * up)
    look_at_hands(scene, t, end, down=20)
    return end


@action(
    "arms",
    Entry(
        lambda d: {"side": d.side(), "count": d.count(4, 7), "speed": d.speed()},
        (
            "<brush> {poss} teeth",
            "<brush> {poss} teeth with {hand}",
            "<brush> {poss} teeth using {hand}",
            "<clean> {poss} teeth with {hand}",
            "<use> a toothbrush with {hand}",
            "<clean> {poss} teeth",
            "<move> {hand} back and forth in front of {poss} mouth",
        ),
        arms="<brush> the teeth with {hand}",
        weight=0.6,
    ),
    Probe(
        "hand",
        {
            "hand.extension": below(0.53),
            "hand.range_y": above(0.18),
            "gap_mid": above(0.9),
            "hand.head_mid": below(0.6),
        },
    ),
)
def brush_teeth(scene: Scene, t: float, *, side: Side = "right", count: Count = 5, speed: Speed = 1.0) -> float:
    """Move a brush to and fro at the mouth."""
    keys = hand_at(0.20, 0.17, 0.05, 0.5), hand_at(0.21, 0.08, 0.06, 0.5)
    up, beat = scene.vary(0.85) / speed, scene.vary(0.34) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action(
    "arms",
    Entry(
        lambda d: {"side": d.side(), "count": d.count(1, 4), "speed": d.speed()},
        (
            "<comb> {poss} hair with {hand}",
            "<comb> {poss} hair",
            "<brush> {poss} hair with {hand}",
            "<brush> {poss} hair",
            "<run> {hand} through {poss} hair {reps}",
            "<use> {hand} to brush {poss} hair",
            "<wash> {poss} hair with {hand}",
        ),
        arms="<comb> the hair with {hand}",
        weight=0.6,
    ),
    Probe("hand", {"hand.shortest": below(0.48), "hand.lift": above(0.36), "hand.to_head": below(0.6)}),
)
def comb_hair(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Draw a comb from the brow over the head to the neck."""
    brow, crown, nape = hand_at(0.17, 0.13, 0.24, 0.2), hand_at(0.05, 0.17, 0.33, 0.3), hand_at(-0.05, 0.20, 0.18, 0.4)
    up, beat = scene.vary(0.9) / speed, scene.vary(0.95) / speed
    back = hand_at(0.08, 0.25, 0.27, 0.3)
    return around(scene, t, side, (brow, crown, nape, back), count=count, up=up, beat=beat)


@action(
    "arms",
    Entry(
        lambda d: {"count": d.count(2, 6), "speed": d.speed()},
        (
            "<rub> {poss} hands together",
            "<rub> {poss} hands",
            "<rub> both hands together {reps}",
            "<wash> {poss} hands",
            "<wash> both hands in a sink",
            "<rub> {poss} palms together",
            "<warm> {poss} hands by rubbing them",
            "<dry> {poss} hands",
        ),
        arms="<rub> both hands together",
        weight=0.8,
    ),
    Probe(
        "hands",
        {
            "hand.y": above(-0.42),
            "gap_low": below(0.3),
            "hand.range_x": above(0.1),
            "hand.lift": within(-0.75, -0.2),
            "hand.shortest": below(0.82),
            "gap_mid": below(0.7),
        },
    ),
)
def rub_hands(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Rub the hands against each other in front of the chest."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.42) / speed
    near, far = hand_at(0.27, 0.045, -0.24), hand_at(0.36, 0.045, -0.22)
    around(scene, t, "left", (near, far), count=count, up=up, beat=beat)
    end = around(scene, t, "right", (far, near), count=count, up=up, beat=beat)
    look_at_hands(scene, t, end)
    return end


@action(
    "arms",
    Entry(
        lambda d: {"side": d.pick("left", "right", p=(0.65, 0.35)), "hold": d.hold(0.4, 1.2), "speed": d.speed()},
        (
            "<check> {poss} watch",
            "<look> at {poss} watch",
            "<look> at the watch on {hand}",
            "<check> the time on {hand}",
            "<raise> {hand} to check the time",
            "<check> the time",
            "<glance> at {poss} wrist",
        ),
        arms="<look> at the watch on {hand}",
        weight=0.7,
    ),
    Probe(
        "hand",
        {
            "hand.y": below(-0.25),
            "other_hand.lift": below(-0.6),
            "hand.lift": within(-0.5, 0.05),
            "hand.extension": within(0.45, 0.85),
        },
    ),
)
def check_watch(scene: Scene, t: float, *, side: Side = "left", hold: Hold = 0.9, speed: Speed = 1.0) -> float:
    """Lift a wrist before the chest, elbow out, and look at it."""
    up = scene.vary(0.7) / speed
    end = there_and_back(scene, t, side, hand_at(0.30, 0.0, -0.08, 0.7), up=up, hold=hold)
    look_at_hands(scene, t, end, left=4 * SIGN[side])
    return end


@action(
    "arms",
    Entry(
        lambda d: {"side": d.side(), "hold": d.hold(0.6, 2.2), "speed": d.speed()},
        (
            "<talk> on the phone",
            "<talk> on the phone with {hand} at {poss} ear",
            "<answer> the phone with {hand}",
            "<answer> a phone call",
            "<hold> a phone to {poss} ear with {hand}",
            "<make> a phone call with {hand}",
            "<pick> up the phone with {hand}",
            "<put> {hand} to {poss} ear",
        ),
        arms="<hold> a phone to the ear with {hand}",
        weight=0.8,
        paced=False,
    ),
    Probe("hand", {"hand.extension": below(0.34), "hand.lift": within(-0.05, 0.28), "hand.hold": above(0.4)}),
)
def phone(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 1.5, speed: Speed = 1.0) -> float:
    """Hold a telephone to the ear."""
    up = scene.vary(0.85) / speed
    end = there_and_back(
        scene, t, side, hand_at(0.11, 0.17, 0.08, -0.7), up=up, hold=hold, via=hand_at(0.28, 0.22, -0.15)
    )
    scene.move("gaze", t + 0.5 * up, (t + up, [0, 10]), (end - up, [0, 6]), (end, [0, 0]))
    return end
