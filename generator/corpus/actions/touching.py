"""Shoulders, the own body, and hands held out to others."""

from typing import Literal

from generator.corpus.actions.hands import around, there_and_back
from generator.corpus.actions.record import AnySide, Count, Hold, Speed, action
from generator.corpus.body import SIDES, Side, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter, within


def _touch_words(params: Params) -> Slots:
    target = params["target"]
    plain = target
    if params["side"] == "both" and target in ("shoulder", "hip"):
        plain += "s"
    return {"target": (plain,)}


@action(
    "arms",
    Entry(
        lambda d: {"count": d.repeats(3), "speed": d.speed()},
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
    Probe("hands", {"shrug": above(0.06), "hand.lift": below(0.0), "shrugs": within(1, 4)}, count="shrugs"),
)
def shrug(scene: Scene, t: float, *, count: Count = 1, speed: Speed = 1.0) -> float:
    """Lift both shoulders and open the hands."""
    up, keep, down = (scene.vary(x) / speed for x in (0.45, 0.35, 0.5))
    beat, open_hands = up + keep + down, hand_at(0.22, 0.33, -0.30, -0.2)
    for i in range(count):
        now = t + i * beat
        scene.move("shrug", now, (now + up, 0.38), (now + up + keep, 0.36), (now + beat, 0.0))
        for s in SIDES:
            last = scene.rest[s] if i == count - 1 else 0.5 * (scene.rest[s] + open_hands)
            scene.move(f"arm_{s}", now, (now + up, open_hands), (now + up + keep, open_hands), (now + beat + 0.1, last))
    return t + count * beat + 0.1


@action(
    "arms",
    Entry(
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
        slots=_touch_words,
        arms="<touch> the {target} with {hand}",
        weight=1.2,
    ),
    Probe(
        "hand",
        {"hand.active": within(0.4, 2.5), "hand.shortest": below(0.8)},
        {
            "head": {"hand.to_head": below(0.5), "hand.still_z": above(0.25)},
            "shoulder": {
                "hand.still_z": within(-0.1, 0.2),
                "hand.still_y": within(-0.5, 0.2),
                "hand.extension": below(0.45),
            },
            "chest": {"hand.still_y": below(-0.1), "hand.to_chest": below(0.45), "hand.lift": within(-0.7, 0.0)},
            "hip": {"hand.hip_hold": above(0.45), "hand.range_x": below(0.25)},
            "face": {"hand.to_head": below(0.55), "hand.still_z": within(-0.05, 0.25)},
            "stomach": {"hand.still_y": below(-0.05), "hand.lift": within(-0.9, -0.5), "hand.extension": below(0.85)},
        },
        wanted=parameter("target"),
    ),
)
def touch(
    scene: Scene,
    t: float,
    *,
    side: AnySide = "right",
    target: Literal["head", "face", "shoulder", "chest", "stomach", "hip"] = "head",
    hold: Hold = 0.5,
    speed: Speed = 1.0,
) -> float:
    """Touch the own body with a hand and let go."""
    place, via = {
        "head": (hand_at(0.06, 0.12, 0.26, -0.9), hand_at(0.28, 0.26, 0.0, -0.2)),
        "face": (hand_at(0.20, 0.09, 0.06, -0.2), hand_at(0.28, 0.24, -0.10)),
        "shoulder": (hand_at(0.12, 0.16, 0.02, -0.9), None),
        "chest": (hand_at(0.16, 0.05, -0.16, 0.1), None),
        "stomach": (hand_at(0.18, 0.08, -0.34, 0.1), None),
        "hip": (hand_at(0.06, 0.20, -0.40, -0.1), None),
    }[target]
    return there_and_back(scene, t, side, place, up=scene.vary(0.8) / speed, hold=hold, via=via)


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.range_x": above(0.3),
            "hand.pulls": above(1),
            "hand.lift": within(-0.42, 0.05),
            "hand.longest": below(1.0),
            "hand.extension": below(0.92),
        },
        count="hand.pulls",
    ),
)
def beckon(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Beckon someone to come: the forearm folds towards the chest."""
    keys = hand_at(0.42, 0.22, -0.10, 0.1), hand_at(0.22, 0.17, -0.02, 0.1)
    up, beat = scene.vary(0.7) / speed, scene.vary(0.62) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.y": below(0.0),
            "hand.lift": within(-0.85, -0.35),
            "hand.downs": above(1),
            "hand.x": above(0.5),
            "gap_low": above(0.5),
        },
        count="hand.downs",
    ),
)
def shake_hand(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Offer a hand and shake another's."""
    keys = hand_at(0.42, 0.10, -0.24), hand_at(0.42, 0.10, -0.34)
    up, beat = scene.vary(0.75) / speed, scene.vary(0.38) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)
