"""Hands that move things: doors, bottles, ropes, boxes, weights."""

from typing import Literal

from generator.corpus.actions.hands import around, look_at_hands, there_and_back
from generator.corpus.actions.record import AnySide, Count, Hold, Speed, action
from generator.corpus.body import OTHER, SIGN, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter, within


def _weights_words(params: Params) -> Slots:
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


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "twist_range": above(16),
            "hand.front": within(0.68, 0.97),
            "hand.lift": within(-0.75, -0.35),
            "nod_high": above(6),
            "hand.still_y": above(-0.25),
        },
    ),
)
def open_door(scene: Scene, t: float, *, side: Side = "right", speed: Speed = 1.0) -> float:
    """Take a handle at the height of the waist and pull the door open past the own side."""
    reach, pull = scene.vary(0.8) / speed, scene.vary(0.95) / speed
    handle, past = hand_at(0.42, 0.16, -0.28), hand_at(0.12, 0.42, -0.26, -0.2)
    grasp = t + reach + 0.2
    end = grasp + pull + 0.8 / speed
    scene.move(f"arm_{side}", t, (t + reach, handle), (grasp, handle), (grasp + pull, past), (end, scene.rest[side]))
    turn = [0, 0, 14 * SIGN[side]]
    scene.move("spine", t, (t + reach, [0, 6, 0]), (grasp, [0, 6, 0]), (grasp + pull, turn), (end, [0, 0, 0]))
    scene.move("gaze", t, (t + 0.5 * reach, [0, 20]), (grasp, [0, 16]), (grasp + pull, [0, 0]))
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.to_head": above(0.6),
            "nod_high": above(13),
            "hand.lift": within(-0.3, 0.05),
            "hand.y": below(0.05),
            "other_hand.lift": within(-0.8, -0.3),
            "other_hand.extension": below(0.92),
            "hand.hold": above(0.3),
        },
    ),
)
def pour(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 0.8, speed: Speed = 1.0) -> float:
    """Tilt a jug, elbow lifted, over a cup that the other hand holds."""
    up = scene.vary(0.9) / speed
    tilted = hand_at(0.30, 0.10, -0.06, 0.6)
    end = there_and_back(scene, t, side, tilted, up=up, hold=hold, via=hand_at(0.32, 0.20, -0.24))
    there_and_back(scene, t, OTHER[side], hand_at(0.32, 0.06, -0.28), up=up, hold=hold)
    look_at_hands(scene, t, end)
    return end


@action(
    "arms",
    Entry(
        lambda d: {"side": d.sides(0.5), "count": d.repeats(), "speed": d.speed()},
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
    Probe(
        "hand",
        {
            "hand.thrust": below(2.7),
            "hand.front": within(0.86, 1.0),
            "hand.range_x": above(0.5),
            "hand.lift": within(-0.5, 0.0),
            "hand.pulls": above(1),
            "hand.back": above(-0.2),
        },
        count="hand.pulls",
    ),
)
def pull(scene: Scene, t: float, *, side: AnySide = "both", count: Count = 2, speed: Speed = 1.0) -> float:
    """Reach out in front and pull something to the waist, the trunk leaning back, `count` times."""
    up, beat = scene.vary(0.7) / speed, scene.vary(1.15) / speed
    keys = aim(1, -0.1, -0.12, 0.96), hand_at(0.14, 0.24, -0.26, 0.1)
    end = around(scene, t, side, keys, count=count, up=up, beat=beat)
    lean = [(t + up, [0, 10, 0])]
    for i in range(count):
        lean += [(t + up + (i + 0.5) * beat, [0, -6, 0]), (t + up + (i + 1) * beat, [0, 8, 0])]
    scene.move("spine", t, *lean, (end, [0, 0, 0]))
    return end


@action(
    "arms",
    Entry(
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
    Probe(
        "hands",
        {
            "gap_mid": below(0.85),
            "gap_low": above(0.42),
            "hand.to_head": above(0.95),
            "hand.extension": below(0.93),
            "hand.hold": above(0.8),
            "hand.lift": above(-0.75),
        },
    ),
)
def carry(scene: Scene, t: float, *, hold: Hold = 2.0, speed: Speed = 1.0) -> float:
    """Hold a box before the belly with both hands."""
    up = scene.vary(0.8) / speed
    return there_and_back(scene, t, "both", hand_at(0.34, 0.17, -0.28, 0.1), up=up, hold=hold)


@action(
    "arms",
    Entry(
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
        slots=_weights_words,
        arms="{doing} with {hand}",
        weight=1.0,
    ),
    Probe(
        "hand",
        {
            "hand.head_mid": above(0.6),
            "hand.folded": below(0.5),
            "hand.still_y": above(-0.1),
            "hand.x": below(0.6),
            "hand.lift_range": above(0.55),
        },
        {"curl": {"hand.top": below(0.3)}, "press": {"hand.top": above(0.6)}},
        wanted=parameter("style"),
        count="hand.curls",
    ),
)
def lift_weights(
    scene: Scene,
    t: float,
    *,
    style: Literal["curl", "press"] = "curl",
    side: AnySide = "both",
    count: Count = 3,
    speed: Speed = 1.0,
) -> float:
    """Lift weights: "curl" folds the elbows, "press" goes from the shoulders to overhead, `count` times."""
    low, high = {
        "curl": (aim(0.35, 0.08, -0.94, 0.96), hand_at(0.20, 0.19, -0.04, 0.0)),
        "press": (hand_at(0.15, 0.25, 0.02, 0.0), aim(0.10, 0.12, 0.98, 0.97, 0.4)),
    }[style]
    up, beat = scene.vary({"curl": 0.45, "press": 0.8}[style]) / speed, scene.vary(1.15) / speed
    return around(scene, t, side, (low, high), count=count, up=up, beat=beat)
