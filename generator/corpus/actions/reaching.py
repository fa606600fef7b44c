"""Arms that reach, push, swing, circle, drink and wipe."""

from typing import Literal

import numpy as np

from generator.corpus.actions.record import AnySide, Count, Hold, Speed, action, sides
from generator.corpus.body import SIDES, SIGN, Floats, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter, within


def _reach_words(params: Params) -> Slots:
    return {
        "where": {
            "forward": ("forward", "out in front", "for something in front", "out"),
            "up": ("up", "upwards", "up high", "for something above", "for something up high"),
            "side": ("to the side", "out to the side", "sideways"),
        }[params["to"]]
    }


@action(
    "arms",
    Entry(
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
        slots=_reach_words,
        arms="<reach> {where} with {hand}",
        weight=1.3,
    ),
    Probe(
        "hand",
        {
            "hand.folded": above(0.42),
            "hand.extension": above(0.92),
            "hand.shortest": below(0.82),
            "hand.longest": above(0.96),
            "hand.hold": above(0.25),
            "hand.thrust": above(0.9),
        },
        {
            "forward": {"hand.still_x": above(0.75), "hand.lift": within(-0.3, 0.5)},
            "up": {"hand.lift": above(0.5)},
            "side": {"hand.still_y": above(0.6), "hand.lift": within(-0.4, 0.5)},
        },
        wanted=parameter("to"),
    ),
)
def reach(
    scene: Scene,
    t: float,
    *,
    side: AnySide = "right",
    to: Literal["forward", "up", "side"] = "forward",
    hold: Hold = 0.6,
    speed: Speed = 1.0,
) -> float:
    """Stretch a hand out towards something, the trunk following, and take it back."""
    span = scene.vary(0.85) / speed
    far, lead = {
        "forward": (aim(1, -0.02, 0.08, 0.99), hand_at(0.26, 0.16, -0.14)),
        "up": (aim(0.35, 0.05, 0.94, 0.99, 0.3), hand_at(0.26, 0.20, 0.10, 0.1)),
        "side": (aim(0.25, 1, 0.08, 0.99), hand_at(0.16, 0.34, -0.10)),
    }[to]
    end = t + span + hold
    for s in sides(side):
        scene.move(f"arm_{s}", t, (t + 0.45 * span, lead), (t + span, far), (end, far), (end + 0.4 * span, lead))
        scene.relax(s, end + span)
    aside = 0.0 if side == "both" else SIGN[side]
    bend = {"forward": [0, 10, -9 * aside], "up": [4 * aside, -5, 0], "side": [-9 * aside, 2, 5 * aside]}[to]
    scene.move("spine", t, (t + span, bend), (end, bend), (end + span, np.zeros(3)))
    scene.move(
        "gaze", t, (t + 0.4 * span, [20 * aside * (to == "side"), -18 if to == "up" else 4]), (end + span, [0, 0])
    )
    return end + span


@action(
    "arms",
    Entry(
        lambda d: {"side": d.sides(0.5), "count": d.repeats(), "speed": d.speed()},
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
    Probe(
        "hand",
        {
            "hand.folded": below(0.47),
            "hand.x": above(0.8),
            "hand.pushes": above(1),
            "hand.front": within(0.85, 1.0),
            "hand.shortest": below(0.8),
            "twist_range": below(24),
        },
        count="hand.pushes",
    ),
)
def push(scene: Scene, t: float, *, side: AnySide = "both", count: Count = 1, speed: Speed = 1.0) -> float:
    """Push something away in front, slowly and with the trunk behind it."""
    ready, spread = hand_at(0.17, 0.17, -0.10, 0.1), aim(1, -0.05, -0.02, 0.97, 0.3)
    up, out, back = (scene.vary(x) / speed for x in (0.55, 0.60, 0.55))
    keys, lean = [(t + up, ready)], [(t + up, [0, -2, 0])]
    for _ in range(count):
        now = keys[-1][0]
        keys += [(now + out, spread), (now + out + 0.15, spread), (now + out + back, ready)]
        lean += [(now + out, [0, 11, 0]), (now + out + back, [0, 0, 0])]
    for s in sides(side):
        scene.move(f"arm_{s}", t, *keys)
        scene.relax(s, keys[-1][0] + 0.75 / speed)
    scene.move("spine", t, *lean)
    return keys[-1][0] + 0.75 / speed


@action(
    "arms",
    Entry(
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
    Probe(
        "hands",
        {"hand.back": below(-0.02), "hand.x": above(0.6), "hand.fronts": above(1), "hand.lift": below(0.0)},
        count="hand.fronts",
    ),
)
def swing_arms(scene: Scene, t: float, *, count: Count = 3, speed: Speed = 1.0) -> float:
    """Swing both hanging arms forward and back together."""
    beat = scene.vary(1.0) / speed
    front, rear = aim(0.85, 0.12, -0.35, 0.95, -0.2), aim(-0.55, 0.22, -0.80, 0.95, -0.5)
    keys: list[tuple[float, Floats]] = []
    for i in range(count):
        keys += [(t + (i + 0.5) * beat, front), (t + (i + 1) * beat, rear if i < count - 1 else 0.7 * rear)]
    for s in SIDES:
        scene.move(f"arm_{s}", t, *[(time, key + 0.03 * scene.normal()) for time, key in keys[:-1]], keys[-1])
        scene.relax(s, t + (count + 0.6) * beat)
    return t + (count + 0.6) * beat


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {"hand.range_x": above(1.2), "hand.longest": above(0.9), "hand.tops": above(1)},
        count="hand.tops",
    ),
)
def circle_arms(scene: Scene, t: float, *, count: Count = 2, side: AnySide = "both", speed: Speed = 1.0) -> float:
    """Swing the straight arms in big circles: forward, up, back and down."""
    beat, lead = scene.vary(1.15) / speed, 0.25 / speed
    for s in sides(side):
        keys = []
        for i in range(8 * count):
            a = 2 * np.pi * (i + 1) / 8
            keys.append((t + lead + (i + 1) / 8 * beat, aim(np.sin(a), 0.45 - 0.15 * np.cos(a), -np.cos(a), 0.97)))
        scene.move(f"arm_{s}", t, *keys[:-1], (keys[-1][0] + 0.1, scene.rest[s]))
    return t + lead + count * beat + 0.1


@action(
    "arms",
    Entry(
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
    Probe("hands", {"hand.flaps": above(1), "hand.y": above(0.6)}, count="hand.flaps"),
)
def flap_arms(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Beat the spread arms up and down like wings."""
    beat, up = scene.vary(0.62) / speed, scene.vary(0.5) / speed
    high, low = aim(0.10, 0.95, 0.40, 0.93, 0.3), aim(0.15, 0.85, -0.50, 0.95)
    keys = [(t + up + i / 2 * beat, low if i % 2 else high) for i in range(2 * count)]
    for s in SIDES:
        scene.move(f"arm_{s}", t, *keys)
        scene.relax(s, keys[-1][0] + 0.6 / speed)
    return keys[-1][0] + 0.6 / speed


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "hand.ins": below(1),
            "hand.x": above(0.28),
            "hand.still_z": below(0.35),
            "hand.head_mid": below(0.6),
            "hand.y": below(0.06),
            "hand.lift": above(0.0),
            "gap_low": above(0.3),
        },
    ),
)
def drink(scene: Scene, t: float, *, side: Side = "right", speed: Speed = 1.0) -> float:
    """Lift a cup to the mouth, tip it with the head back, and lower it."""
    up, sip = scene.vary(0.95) / speed, scene.vary(1.1) / speed
    cup, tipped = hand_at(0.24, 0.10, 0.02, 0.1), hand_at(0.22, 0.09, 0.08, 0.1)
    scene.move(
        f"arm_{side}", t, (t + 0.5 * up, hand_at(0.30, 0.20, -0.20)), (t + up, cup), (t + up + 0.5 * sip, tipped),
        (t + up + 0.8 * sip, tipped), (t + up + sip, cup), (t + 1.5 * up + sip, hand_at(0.30, 0.20, -0.20)),
    )  # fmt: skip
    scene.relax(side, t + 2 * up + sip)
    scene.move("gaze", t, (t + up, [0, 0]), (t + up + 0.5 * sip, [0, -24]), (t + up + 1.2 * sip, [0, 0]))
    return t + 2 * up + sip


@action(
    "arms",
    Entry(
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
    Probe(
        "hand",
        {
            "other_hand.lift": below(-0.3),
            "hand.top": above(0.15),
            "hand.range_y": above(0.13),
            "hand.extension": within(0.65, 0.93),
            "hand.x": above(0.48),
        },
        count="hand.ins",
    ),
)
def wipe(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Wipe a pane in front, from side to side in flat arcs."""
    up, beat = scene.vary(0.7) / speed, scene.vary(0.85) / speed
    outer, top, inner = hand_at(0.36, 0.34, 0.06), hand_at(0.42, 0.16, 0.14), hand_at(0.40, 0.0, 0.04)
    keys = [(t + up, outer)]
    for i in range(count):
        now = t + up + i * beat
        keys += [(now + share * beat, key) for share, key in ((0.25, top), (0.5, inner), (0.75, top), (1.0, outer))]
    scene.move(f"arm_{side}", t, *keys)
    scene.relax(side, keys[-1][0] + 0.75 / speed)
    look = [8 * SIGN[side], 0]
    scene.move("gaze", t, (t + up, look), (keys[-1][0], look), (keys[-1][0] + 0.6, [0, 0]))
    return keys[-1][0] + 0.75 / speed
