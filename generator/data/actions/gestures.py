"""Gestures of the hands at the body or towards another person; the legs stay free."""

from typing import Literal

from generator.data.actions.hands import around, there_and_back
from generator.data.actions.registry import AnySide, Count, Hold, Speed, action
from generator.data.body import SIDES, SIGN, Side, hand_at
from generator.data.scene import Scene


@action("arms")
def salute(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 0.8, speed: Speed = 1.0) -> float:
    """Bring the flat hand to the brow."""
    via, up = hand_at(0.30, 0.26, -0.05, 0.4), scene.vary(0.6) / speed
    return there_and_back(scene, t, side, hand_at(0.12, 0.19, 0.14, -0.6), up=up, hold=hold, via=via)


@action("arms")
def scratch_head(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Scratch the side of the head."""
    scene.move("gaze", t, (t + 0.7, [6 * SIGN[side], 12]), (t + 1.6, [0, 0]))
    keys = hand_at(0.09, 0.15, 0.22, -0.8), hand_at(0.05, 0.15, 0.28, -0.8)
    up, beat = scene.vary(0.9) / speed, scene.vary(0.36) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action("arms")
def cross_arms(scene: Scene, t: float, *, hold: Hold = 1.5, speed: Speed = 1.0) -> float:
    """Fold the arms in front of the chest."""
    up = scene.vary(0.85) / speed
    upper: Side = "left" if scene.rng.random() < 0.5 else "right"
    for s in SIDES:
        place = hand_at(0.27, -0.06, -0.18, 0.5) if s == upper else hand_at(0.23, -0.06, -0.26, 0.5)
        there_and_back(scene, t, s, place, up=up, hold=hold, via=hand_at(0.30, 0.16, -0.25))
    return t + 2 * up + hold


@action("arms")
def hands_on_hips(scene: Scene, t: float, *, hold: Hold = 1.5, speed: Speed = 1.0) -> float:
    """Set both hands on the hips, elbows out."""
    up = scene.vary(0.75) / speed
    return there_and_back(scene, t, "both", hand_at(0.04, 0.21, -0.38, 0.35), up=up, hold=hold)


@action("arms")
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


@action("arms")
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


@action("arms")
def beckon(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Beckon someone to come: the forearm folds towards the chest."""
    keys = hand_at(0.42, 0.22, -0.10, 0.1), hand_at(0.22, 0.17, -0.02, 0.1)
    up, beat = scene.vary(0.7) / speed, scene.vary(0.62) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action("arms")
def shake_hand(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Offer a hand and shake another's."""
    keys = hand_at(0.42, 0.10, -0.24), hand_at(0.42, 0.10, -0.34)
    up, beat = scene.vary(0.75) / speed, scene.vary(0.38) / speed
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action("arms")
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
