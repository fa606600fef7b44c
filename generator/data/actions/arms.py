"""Large movements of the arms; the legs stay free."""

from typing import Literal

import numpy as np

from generator.data import body
from generator.data.actions.registry import Angle, AnySide, Count, Hold, Size, Speed, action, sides
from generator.data.body import SIDES, SIGN, Floats, Side, aim, hand_at
from generator.data.scene import Scene


@action("arms")
def wave(
    scene: Scene, t: float, *, side: AnySide = "right", count: Count = 3, size: Size = 1.0, speed: Speed = 1.0
) -> float:
    """Raise a hand beside the head and wave it `count` times."""
    up, beat = scene.vary(0.65) / speed, scene.vary(0.46) / speed
    out, inside = hand_at(0.20, 0.40 + 0.10 * size, 0.22, -0.4), hand_at(0.18, 0.34 - 0.12 * size, 0.26, -0.5)
    end = t + up + count * beat
    for s in sides(side):
        swings = [
            (t + up + i / 2 * beat, (inside if i % 2 else out) + 0.03 * scene.normal()) for i in range(2 * count + 1)
        ]
        scene.move(f"arm_{s}", t, (t + 0.5 * up, hand_at(0.30, 0.32, -0.16, -0.2)), *swings)
        scene.relax(s, end + scene.vary(0.8) / speed)
    gaze = 0.0 if side == "both" else 6 * SIGN[side]
    scene.move("gaze", t, (t + 0.4, [gaze, -4]), (end, [gaze, -4]), (end + 0.6, [0, 0]))
    return end + 0.8 / speed


@action("arms")
def raise_arm(
    scene: Scene,
    t: float,
    *,
    side: AnySide = "both",
    to: Literal["up", "side", "forward"] = "up",
    hold: Hold = 0.8,
    lower: bool = True,
    speed: Speed = 1.0,
) -> float:
    """Raise the straight arm; `lower` brings it down again after `hold` seconds."""
    span = scene.vary({"up": 1.05, "side": 0.85, "forward": 0.75}[to]) / speed
    top = {
        "up": aim(0.12, 0.22, 0.97, 0.97, 0.5),
        "side": aim(0.10, 1, 0.05 + 0.04 * scene.normal(), 0.97),
        "forward": aim(1, 0.05, 0.04, 0.97),
    }[to]
    halfway = aim(0.75, 0.45, 0.05, 0.93, 0.2)
    for s in sides(side):
        start = t + (0.03 * abs(scene.normal()) if side == "both" else 0.0)
        arm = scene.tracks[f"arm_{s}"]
        scene.move(f"arm_{s}", start, *([(start + 0.52 * span, halfway)] if to == "up" else []), (start + span, top))
        arm.key(start + span + hold, top - [0, 0.05, 0, 0], 0.0)  # a held arm sinks a little
        if lower:
            if to == "up":
                arm.key(start + 1.5 * span + hold, halfway)
            scene.relax(s, start + 2 * span + hold)
    return t + (2 if lower else 1) * span + hold


@action("arms")
def lift_arms(
    scene: Scene,
    t: float,
    *,
    side: AnySide = "both",
    to: Literal["up", "side", "forward"] = "side",
    count: Count = 3,
    speed: Speed = 1.0,
) -> float:
    """Move the straight arms up and down, `count` times, overhead, sideways or in front."""
    beat = scene.vary({"up": 1.35, "side": 1.1, "forward": 1.0}[to]) / speed
    top = {
        "up": aim(0.15, 0.25, 0.95, 0.96, 0.4),
        "side": aim(0.10, 1, 0.10, 0.97),
        "forward": aim(1, 0.05, 0.10, 0.97),
    }
    low = aim(0.25, 0.25, -0.93, 0.96)
    keys: list[tuple[float, Floats]] = []
    for i in range(count):
        now = t + i * beat
        halfway = [(now + 0.25 * beat, aim(0.60, 0.65, 0.0, 0.94, 0.2))] if to == "up" else []
        again = [(now + 0.75 * beat, halfway[0][1])] if halfway else []
        keys += [*halfway, (now + 0.5 * beat, top[to]), *again, (now + beat, low)]
    for s in sides(side):
        scene.move(f"arm_{s}", t, *keys[:-1], (t + count * beat + 0.1, scene.rest[s]))
    return t + count * beat + 0.1


@action("arms")
def clap(
    scene: Scene,
    t: float,
    *,
    count: Count = 4,
    size: Size = 1.0,
    height: Literal["chest", "head"] = "chest",
    speed: Speed = 1.0,
) -> float:
    """Clap the hands in front of the chest or over the head."""
    up, beat = scene.vary(0.6) / speed, scene.vary(0.42) / speed
    forward, z = (0.33, -0.16) if height == "chest" else (0.22, 0.36)
    together, apart = hand_at(forward, 0.035, z, -0.1), hand_at(forward - 0.02, 0.12 + 0.07 * size, z, -0.1)
    keys = [(t + up, apart)]
    for i in range(count):
        keys += [(t + up + (i + 0.45) * beat, together), (t + up + (i + 1) * beat, apart)]
    for s in SIDES:
        scene.move(f"arm_{s}", t, *keys)
        scene.relax(s, keys[-1][0] + 0.8 / speed)
    return keys[-1][0] + 0.8 / speed


@action("arms")
def point(
    scene: Scene,
    t: float,
    *,
    side: Side = "right",
    azimuth: Angle = 0.0,
    elevation: Angle = 5.0,
    hold: Hold = 0.9,
    speed: Speed = 1.0,
) -> float:
    """Point and look in a direction: azimuth to the left of forward, elevation above the horizon (degrees)."""
    span = scene.vary(0.6) / speed
    a, e = np.radians([azimuth, elevation])
    direction = [np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)]
    out = np.append(body.direction_to_chart(direction, side), [0.985, 0.0])
    begin = 0.5 * (out + scene.rest[side]) - [0, 0.05, 0.18, 0]
    end = t + span + hold
    scene.move(f"arm_{side}", t, (t + 0.45 * span, begin), (t + span, out), (end, out))
    scene.relax(side, end + 0.75 / speed)
    look, turn = [np.clip(0.8 * azimuth, -70, 70), -0.5 * elevation], [0, 0, np.clip(0.25 * azimuth, -25, 25)]
    scene.move("gaze", t, (t + 0.35 * span, look), (end, look), (end + 0.7, [0, 0]))
    scene.move("spine", t, (t + span, turn), (end, turn), (end + 0.7, np.zeros(3)))
    return end + 0.75 / speed


@action("arms")
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


@action("arms")
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


@action("arms")
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


@action("arms")
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


@action("arms")
def flap_arms(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Beat the spread arms up and down like wings."""
    beat, up = scene.vary(0.62) / speed, scene.vary(0.5) / speed
    high, low = aim(0.10, 0.95, 0.40, 0.93, 0.3), aim(0.15, 0.85, -0.50, 0.95)
    keys = [(t + up + i / 2 * beat, low if i % 2 else high) for i in range(2 * count)]
    for s in SIDES:
        scene.move(f"arm_{s}", t, *keys)
        scene.relax(s, keys[-1][0] + 0.6 / speed)
    return keys[-1][0] + 0.6 / speed


@action("arms")
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
