"""Music and sport with the hands: instruments, balls, bats and strokes."""

from typing import Literal

import numpy as np

from generator.data.actions.hands import around, there_and_back
from generator.data.actions.registry import AnySide, Count, Hold, Speed, action
from generator.data.body import OTHER, SIDES, SIGN, Side, aim, hand_at
from generator.data.scene import Scene


@action("arms")
def play_guitar(scene: Scene, t: float, *, side: Side = "right", count: Count = 5, speed: Speed = 1.0) -> float:
    """Strum with one hand before the belly while the other one holds the neck out to its own side."""
    up, beat = scene.vary(0.8) / speed, scene.vary(0.5) / speed
    strings = hand_at(0.24, 0.08, -0.22, 0.3), hand_at(0.24, 0.06, -0.36, 0.3)
    end = around(scene, t, side, strings, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.28, 0.40, -0.10), up=up, hold=end - t - 2 * up)
    return end


@action("arms")
def play_violin(scene: Scene, t: float, *, side: Side = "right", count: Count = 3, speed: Speed = 1.0) -> float:
    """Bow to and fro with one hand; the other one holds the violin out from the chin."""
    up, beat = scene.vary(0.95) / speed, scene.vary(1.0) / speed
    strings = hand_at(0.30, 0.04, 0.00, 0.4), hand_at(0.32, 0.34, -0.16, 0.3)
    end = around(scene, t, side, strings, count=count, up=up, beat=beat)
    there_and_back(scene, t, OTHER[side], hand_at(0.32, 0.26, 0.02, -0.3), up=up, hold=end - t - 2 * up)
    look = [20 * SIGN[OTHER[side]], 14]
    scene.move("gaze", t, (t + up, look), (end - 0.75, look), (end, [0, 0]))
    return end


@action("arms")
def play_drums(scene: Scene, t: float, *, count: Count = 6, speed: Speed = 1.0) -> float:
    """Drum: `count` strokes of either hand, in turn."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.44) / speed
    high, low = hand_at(0.32, 0.20, -0.08), hand_at(0.40, 0.16, -0.28)
    first: Side = "left" if scene.rng.random() < 0.5 else "right"
    end = around(scene, t, first, (high, low), count=count, up=up, beat=beat)
    around(scene, t, OTHER[first], (low, high), count=count, up=up, beat=beat)
    return end


@action("arms")
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


@action("arms")
def conduct(scene: Scene, t: float, *, count: Count = 3, speed: Speed = 1.0) -> float:
    """Conduct an orchestra with both hands: down, in, out and up, `count` bars."""
    up, beat = scene.vary(0.75) / speed, scene.vary(1.3) / speed
    bar = hand_at(0.34, 0.20, 0.10), hand_at(0.38, 0.18, -0.20), hand_at(0.36, 0.08, -0.10), hand_at(0.32, 0.38, -0.10)
    return around(scene, t, "both", bar, count=count, up=up, beat=beat)


@action("arms")
def bounce_ball(scene: Scene, t: float, *, side: Side = "right", count: Count = 4, speed: Speed = 1.0) -> float:
    """Bounce a ball beside the body: the hand pushes down from the waist."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.58) / speed
    keys = hand_at(0.32, 0.30, -0.22), hand_at(0.26, 0.30, -0.42)
    return around(scene, t, side, keys, count=count, up=up, beat=beat)


@action("arms")
def catch(scene: Scene, t: float, *, side: AnySide = "both", speed: Speed = 1.0) -> float:
    """Reach out for a ball that comes from the front, and take it to the chest."""
    up, take, keep = scene.vary(0.6) / speed, scene.vary(0.32) / speed, scene.vary(0.5)
    caught, end = t + up + 0.15, t + up + 0.15 + take + keep
    out, chest = hand_at(0.45, 0.11, -0.02, 0.1), hand_at(0.24, 0.09, -0.16, 0.1)
    for s in SIDES if side == "both" else (side,):
        scene.move(f"arm_{s}", t, (t + up, out), (caught, out), (caught + take, chest), (end, chest))
        scene.relax(s, end + 0.75 / speed)
    bend = [0, -5, 0]
    scene.move("spine", t, (t + up, [0, 5, 0]), (caught + take, bend), (end + 0.6, [0, 0, 0]))
    return end + 0.75 / speed


@action("arms")
def swim(
    scene: Scene,
    t: float,
    *,
    stroke: Literal["breast", "crawl"] = "crawl",
    count: Count = 3,
    speed: Speed = 1.0,
) -> float:
    """Strokes of a swimmer in the air, `count` in all: "breast" with both arms, "crawl" with the arms in turn."""
    if stroke == "breast":
        ring = hand_at(0.26, 0.07, -0.10), aim(1, -0.1, 0.0, 0.96), aim(0.5, 0.85, -0.1, 0.95)
        return around(scene, t, "both", ring, count=count, up=scene.vary(0.7) / speed, beat=scene.vary(1.35) / speed)
    beat, lead = scene.vary(0.75) / speed, 0.3 / speed
    first: Side = "left" if scene.rng.random() < 0.5 else "right"
    ends = [t]
    for s in SIDES:
        start = t + lead + (0.0 if s == first else beat)
        keys = []
        for i in range((count + (s == first)) // 2):
            now = start + 2 * i * beat
            for k in range(1, 8):  # up behind and over the head, down in front
                a = 2 * np.pi * k / 8
                way = aim(-np.sin(a), 0.40 - 0.15 * np.cos(a), -np.cos(a), 0.93)
                keys.append((now + 1.7 * k / 8 * beat, way))
            keys.append((now + 1.8 * beat, scene.rest[s]))
        if keys:
            scene.move(f"arm_{s}", start, *keys)
            ends.append(keys[-1][0])
    return max(ends)


@action("arms")
def guard(scene: Scene, t: float, *, hold: Hold = 1.4, speed: Speed = 1.0) -> float:
    """Raise both fists before the chin as a boxer, and lower them."""
    up = scene.vary(0.5) / speed
    front: Side = "left" if scene.rng.random() < 0.5 else "right"
    end = there_and_back(scene, t, front, hand_at(0.30, 0.09, -0.02, -0.1), up=up, hold=hold)
    there_and_back(scene, t, OTHER[front], hand_at(0.21, 0.09, -0.05, -0.1), up=up, hold=hold)
    return end


def _both_hands(scene: Scene, t: float, side: Side, *keys: tuple[float, tuple[float, float, float]]) -> None:
    """Both hands on one grip: (time, (forward, towards `side`, up)) from the middle between the shoulders."""
    for s in SIDES:
        sign = 1 if s == side else -1
        places = [(time, f, sign * a + 0.03, u) for time, (f, a, u) in keys]
        # The elbow of an arm that reaches across the chest is lifted before it.
        scene.move(f"arm_{s}", t, *[(time, hand_at(f, a, u, 0.1 + 8 * max(0.0, -a))) for time, f, a, u in places])
        scene.relax(s, keys[-1][0] + 0.9)


def _unwind(scene: Scene, t: float, turn: float, times: tuple[float, float, float, float], bend: float) -> None:
    """Trunk, hips and weight of a two-handed swing: bent forward, wound up, through, and upright again."""
    ready, back, hit, through = times
    scene.move(
        "spine", t, (ready, [0, bend, 0]), (back, [0, bend, -30 * turn]), (hit, [0, bend, 6 * turn]),
        (through, [0, 0.5 * bend, 30 * turn]), (through + 0.9, [0, 0, 0]),
    )  # fmt: skip
    hips = [(ready, [0, bend, 0]), (back, [0, bend, -16 * turn]), (hit, [0, bend, 12 * turn])]
    scene.move("pelvis", t, *hips, (through, [0, 0.4 * bend, 24 * turn]), (through + 0.9, [0, 0, 0]))
    scene.move("crouch", t, (ready, 0.05), (hit, 0.05), (through + 0.9, 0.0))
    scene.move("weight", t, (back, 0.5 - 0.15 * turn), (hit, 0.5 + 0.15 * turn), (through + 0.9, 0.5))


@action("whole")
def swing_club(
    scene: Scene,
    t: float,
    *,
    sport: Literal["golf", "baseball"] = "golf",
    side: Side = "right",
    speed: Speed = 1.0,
) -> float:
    """Swing a golf club from below or a baseball bat at the height of the chest; `side` is where it is swung from."""
    set_up, wind, whip, follow = (scene.vary(x) / speed for x in (0.85, 0.75, 0.30, 0.40))
    ready, back = t + set_up, t + set_up + wind
    hit, through = back + whip, back + whip + follow
    start, far, contact, after = {
        "golf": ((0.30, 0.0, -0.44), (0.16, 0.30, 0.08), (0.32, 0.0, -0.42), (0.16, -0.30, 0.12)),
        "baseball": ((0.24, 0.16, -0.04), (0.16, 0.24, 0.06), (0.42, 0.0, -0.16), (0.20, -0.28, 0.06)),
    }[sport]
    _both_hands(scene, t, side, (ready, start), (back, far), (hit, contact), (through, after))
    _unwind(scene, t, -SIGN[side], (ready, back, hit, through), {"golf": 16.0, "baseball": 5.0}[sport])
    down = [0, 24 if sport == "golf" else 4]
    scene.move("gaze", t, (ready, down), (hit, down), (through, [-20 * SIGN[side], 0]), (through + 0.9, [0, 0]))
    return through + 0.95


@action("whole")
def swing_racket(
    scene: Scene,
    t: float,
    *,
    stroke: Literal["forehand", "backhand", "serve"] = "forehand",
    side: Side = "right",
    speed: Speed = 1.0,
) -> float:
    """A tennis stroke with the hand of `side`: forehand, backhand, or a serve overhead."""
    turn = SIGN[side] if stroke == "backhand" else -SIGN[side]
    wind, whip, follow = (scene.vary(x) / speed for x in (0.75, 0.28, 0.42))
    back, hit = t + wind, t + wind + whip
    through = hit + follow
    far, contact, after = {
        "forehand": (aim(-0.30, 0.92, -0.25, 0.92), aim(0.85, 0.40, -0.12, 0.95), hand_at(0.30, -0.14, 0.04, 1.5)),
        "backhand": (hand_at(0.27, -0.20, -0.18, 1.2), aim(0.80, 0.40, -0.12, 0.95), aim(0.20, 0.95, 0.25, 0.94)),
        "serve": (hand_at(-0.08, 0.30, 0.20, 0.4), aim(0.40, 0.12, 0.90, 0.97, 0.4), aim(0.60, -0.25, -0.70, 0.93)),
    }[stroke]
    end = through + 0.9 / speed
    scene.move(f"arm_{side}", t, (back, far), (hit, contact), (through, after), (end, scene.rest[side]))
    free = aim(0.4, 0.15, 0.90, 0.96, 0.3) if stroke == "serve" else aim(0.6, 0.55, -0.35, 0.85)
    scene.move(
        f"arm_{OTHER[side]}", t, (back, free), (through, aim(0.2, 0.4, -0.85, 0.85)), (end, scene.rest[OTHER[side]])
    )
    scene.move(
        "spine", t, (back, [0, 0, -26 * turn]), (hit, [0, 4, 10 * turn]), (through, [0, 8, 22 * turn]), (end, [0, 0, 0])
    )
    scene.move("pelvis", t, (back, [0, 0, -14 * turn]), (hit, [0, 2, 10 * turn]), (end, [0, 0, 0]))
    scene.move("crouch", t, (back, 0.05), (through, 0.02), (end, 0.0))
    if stroke == "serve":
        scene.move("gaze", t, (back, [0, -25]), (hit, [0, -10]), (through, [0, 0]))
    return end
