"""Quick actions of the arms with a wind-up: punches and throws."""

from collections.abc import Sequence

from generator.corpus.actions.record import Count, Speed, action
from generator.corpus.body import OTHER, SIDES, SIGN, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe, above, below


def _punches(scene: Scene, t: float, order: Sequence[Side], speed: float) -> float:
    """Take the guard, punch with the given hands in turn, drop the guard; the end time."""
    guard, hit = hand_at(0.24, 0.10, -0.06, -0.15), aim(1, -0.12, 0.02, 0.985, 0.1)
    up = 0.45 / speed
    for s in SIDES:
        scene.move(f"arm_{s}", t, (t + up, guard))
    scene.move("crouch", t, (t + up, 0.05))
    scene.hold(t + up, "spine", "pelvis", "offset")
    t += up
    for side in order:
        turn = -SIGN[side]
        cock, strike, back = scene.vary(0.16) / speed, scene.vary(0.20) / speed, scene.vary(0.32) / speed
        contact, end = t + cock + strike, t + cock + strike + back
        ready = hand_at(0.14, 0.16, -0.12)
        scene.move(f"arm_{side}", t, (t + cock, ready), (contact, hit), (contact + 0.04, hit), (end, guard))
        scene.move(f"arm_{OTHER[side]}", t, (contact, hand_at(0.17, 0.12, -0.05, -0.1)), (end, guard))
        scene.move("spine", t, (t + cock, [0, 2, -14 * turn]), (contact - 0.03, [0, 4, 20 * turn]), (end, [0, 3, 0]))
        scene.move("pelvis", t, (t + cock, [0, 0, -8 * turn]), (contact - 0.06, [0, 2, 14 * turn]), (end, [0, 0, 0]))
        scene.move("offset", t, (t + cock, [-0.02, 0]), (contact, [0.04, 0]), (end, [0, 0]))
        t = end
    down = t + 0.1 + 0.7 / speed
    for s in SIDES:
        scene.move(f"arm_{s}", t + 0.1, (down, scene.rest[s]))
    scene.move("spine", t + 0.1, (down, [0, 0, 0]))
    scene.move("crouch", t + 0.1, (down, 0))
    return down


@action(
    "whole",
    Entry(
        lambda d: {"side": d.side(), "count": d.repeats(), "speed": d.speed()},
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
    Probe(
        "hand",
        {
            "hand.pushes": above(1),
            "hand.thrust": above(1.2),
            "other_hand.front": below(0.78),
            "gap_mid": below(0.97),
            "turn_range": above(12),
        },
        count="hand.pushes",
    ),
)
def punch(scene: Scene, t: float, *, side: Side = "right", count: Count = 1, speed: Speed = 1.0) -> float:
    """Punch straight ahead with one hand."""
    order: list[Side] = [side] * count
    return _punches(scene, t, order, speed)


@action(
    "whole",
    Entry(
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
    Probe(
        "hands",
        {"hand.thrust": above(0.8), "hand.pushes": above(1), "turn_range": above(12)},
        count="punches",
    ),
)
def alternate(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Box: `count` straight punches, left and right in turn."""
    first: Side = "left" if scene.rng.random() < 0.5 else "right"
    order: list[Side] = [first if i % 2 == 0 else OTHER[first] for i in range(count)]
    return _punches(scene, t, order, speed)


@action(
    "whole",
    Entry(
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
    Probe(
        "hand",
        {"hand.speed": above(4.0), "hand.back": below(-0.05), "twist_range": above(35), "hand.top": above(0.1)},
    ),
)
def throw(scene: Scene, t: float, *, side: Side = "right", speed: Speed = 1.0) -> float:
    """Throw overarm: reach back, whip forward, follow through across the body."""
    other, turn = OTHER[side], -SIGN[side]
    wind, whip, follow = scene.vary(0.7) / speed, scene.vary(0.25) / speed, scene.vary(0.35) / speed
    back, release = t + wind, t + wind + whip
    through = release + follow
    end = through + 0.9 / speed
    scene.move(
        f"arm_{side}", t, (back, hand_at(-0.12, 0.36, 0.20, 0.5)), (release, aim(0.85, 0.1, 0.50, 0.97, 0.4)),
        (through, aim(0.55, -0.35, -0.75, 0.93)), (end, scene.rest[side]),
    )  # fmt: skip
    scene.move(
        f"arm_{other}", t, (back, aim(0.9, 0.3, -0.05, 0.85)), (release, aim(0.2, 0.5, -0.8, 0.75)),
        (end, scene.rest[other]),
    )  # fmt: skip
    scene.move(
        "spine", t, (back, [6 * turn, -8, -28 * turn]), (release - 0.05, [-4 * turn, 8, 18 * turn]),
        (through, [-6 * turn, 22, 24 * turn]), (end, [0, 0, 0]),
    )  # fmt: skip
    scene.move("pelvis", t, (back, [0, 0, -16 * turn]), (release - 0.1, [0, 4, 12 * turn]), (end, [0, 0, 0]))
    rear = 0.5 + 0.15 * SIGN[side]
    scene.move("weight", t, (t + 0.7 * wind, rear), (release, 1 - rear), (end, 0.5))
    scene.move("offset", t, (back, [-0.03, 0]), (release, [0.05, 0]), (end, [0, 0]))
    scene.move("crouch", t, (back, 0.06), (release, 0.02), (end, 0.0))
    return end
