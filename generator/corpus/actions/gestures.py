"""Hands at the head, the chest and the hips."""

from generator.corpus.actions.hands import around, there_and_back
from generator.corpus.actions.record import Count, Hold, Speed, action
from generator.corpus.body import SIDES, SIGN, Side, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe, above, below, within


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.head_mid": below(0.62),
            "hand.y": within(-0.12, 0.3),
            "hand.still_z": within(0.05, 0.4),
            "hand.ups": below(1),
            "hand.hold": above(0.3),
            "hand.shortest": above(0.15),
        },
    ),
)
def salute(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 0.8, speed: Speed = 1.0) -> float:
    """Bring the flat hand to the brow."""
    via, up = hand_at(0.30, 0.26, -0.05, 0.4), scene.vary(0.6) / speed
    return there_and_back(scene, t, side, hand_at(0.12, 0.19, 0.14, -0.6), up=up, hold=hold, via=via)


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {"hand.to_head": below(0.42), "hand.still_z": above(0.33), "hand.ups": above(1)},
        count="hand.ups",
    ),
)
def scratch_head(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Scratch the side of the head."""
    scene.move("gaze", t, (t + 0.7, [6 * SIGN[side], 12]), (t + 1.6, [0, 0]))
    keys = hand_at(0.09, 0.15, 0.22, -0.8), hand_at(0.05, 0.15, 0.28, -0.8)
    up, beat = scene.vary(0.9) / speed, scene.vary(0.36) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action(
    "arms",
    Entry(
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
    Probe("hands", {"hand.y": below(-0.38), "hand.lift": within(-0.9, -0.1)}),
)
def cross_arms(scene: Scene, t: float, *, hold: Hold = 1.5, speed: Speed = 1.0) -> float:
    """Fold the arms in front of the chest."""
    up = scene.vary(0.85) / speed
    upper: Side = "left" if scene.rng.random() < 0.5 else "right"
    for s in SIDES:
        place = hand_at(0.27, -0.06, -0.18, 0.5) if s == upper else hand_at(0.23, -0.06, -0.26, 0.5)
        there_and_back(scene, t, s, place, up=up, hold=hold, via=hand_at(0.30, 0.16, -0.25))
    return t + 2 * up + hold


@action(
    "arms",
    Entry(
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
    Probe("hands", {"hand.range_x": below(0.25), "hand.hip_hold": above(0.45)}),
)
def hands_on_hips(scene: Scene, t: float, *, hold: Hold = 1.5, speed: Speed = 1.0) -> float:
    """Set both hands on the hips, elbows out."""
    up = scene.vary(0.75) / speed
    return there_and_back(scene, t, "both", hand_at(0.04, 0.21, -0.38, 0.35), up=up, hold=hold)
