"""Movements of the trunk and the head over standing feet."""

from typing import Literal

import numpy as np

from generator.data.actions.registry import Count, Hold, Size, Speed, action
from generator.data.body import OTHER, aim
from generator.data.scene import Scene

_ZERO = (0.0, 0.0, 0.0)


def _bend(scene: Scene, t: float, *, spine: float, pelvis: float, span: float, hold: float) -> float:
    """Bend forward by degrees at spine and hips, stay, straighten up; the end time."""
    down, end = t + span, t + span + hold
    scene.move("spine", t, (down, [0, spine, 0]), (end, [0, 1.03 * spine, 0]), (end + 1.1 * span, _ZERO))
    scene.move("pelvis", t, (t + 0.92 * span, [0, pelvis, 0]), (end, [0, pelvis, 0]), (end + 0.9 * span, _ZERO))
    scene.move("crouch", t, (down, 0.012), (end, 0.012), (end + span, 0.0))
    scene.move("gaze", t, (t + 0.7 * span, [0, 35]), (end + 0.2, [0, 35]), (end + 1.25 * span, [0, 0]))
    return end + 1.15 * span


@action("trunk")
def bow(scene: Scene, t: float, *, depth: Size = 1.0, hold: Hold = 0.5, speed: Speed = 1.0) -> float:
    """Bow and rise again."""
    return _bend(scene, t, spine=24 * depth, pelvis=30 * depth, span=scene.vary(0.95) / speed, hold=hold)


@action("trunk")
def bend_forward(scene: Scene, t: float, *, depth: Size = 1.0, hold: Hold = 0.6, speed: Speed = 1.0) -> float:
    """Bend down towards the toes, the arms hanging."""
    spine, pelvis = min(56 * depth, 75), min(58 * depth, 75)
    return _bend(scene, t, spine=spine, pelvis=pelvis, span=scene.vary(1.35) / speed, hold=hold)


@action("trunk")
def lean(
    scene: Scene,
    t: float,
    *,
    direction: Literal["left", "right", "forward", "back"] = "left",
    hold: Hold = 0.6,
    speed: Speed = 1.0,
) -> float:
    """Lean the trunk over to one side, forward or back, and come upright."""
    span = scene.vary(0.9) / speed
    spine, pelvis = {
        "left": ([-26, 0, 3], [-6, 0, 0]),
        "right": ([26, 0, -3], [6, 0, 0]),
        "forward": ([0, 22, 0], [0, 16, 0]),
        "back": ([0, -24, 0], [0, -8, 0]),
    }[direction]
    end = t + span + hold
    scene.move("spine", t, (t + span, spine), (end, spine), (end + span, _ZERO))
    scene.move("pelvis", t, (t + span, pelvis), (end, pelvis), (end + span, _ZERO))
    if direction in ("left", "right"):
        upper, along = f"arm_{OTHER[direction]}", aim(0.08, 0.55, -0.83, 0.96)  # lies on the trunk, not in it
        rest = scene.tracks[upper].last
        scene.move(upper, t, (t + span, along), (end, along), (end + span, rest))
    return end + span


@action("trunk")
def twist(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Turn the trunk to the left and to the right `count` times over still feet."""
    beat, spine, pelvis = scene.vary(1.5) / speed, [], []
    first = 1 if scene.rng.random() < 0.5 else -1
    for i in range(2 * count):
        side, now = first * (1 - 2 * (i % 2)), t + (i + 0.6) * beat / 2
        spine.append((now, [0, 2, scene.vary(42, 0.06) * side]))
        pelvis.append((now, [0, 0, 16 * side]))
    end = t + (count + 0.3) * beat
    scene.move("spine", t, *spine, (end, _ZERO))
    scene.move("pelvis", t, *pelvis, (end, _ZERO))
    return end


@action("trunk")
def sway(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Shift the weight from side to side `count` times."""
    beat = scene.vary(1.9) / speed
    first = 1 if scene.rng.random() < 0.5 else -1
    offset, spine = [], []
    for i in range(2 * count):
        side, now = first * (1 - 2 * (i % 2)), t + (i + 0.7) * beat / 2
        offset.append((now, [0, scene.vary(0.13, 0.06) * side]))
        spine.append((now, [-9 * side, 0, 0]))
    end = t + (count + 0.4) * beat
    scene.move("offset", t, *offset, (end, [0, 0]))
    scene.move("spine", t, *spine, (end, _ZERO))
    return end


@action("trunk")
def circle_hips(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Move the hips in level circles over still feet."""
    beat = scene.vary(1.7) / speed
    first = 1 if scene.rng.random() < 0.5 else -1
    offset, spine = [], []
    for i in range(8 * count):
        a, now = 2 * np.pi * i / 8, t + 0.4 + i / 8 * beat
        offset.append((now, [0.045 * np.cos(a), 0.10 * first * np.sin(a)]))
        spine.append((now, [10 * first * np.sin(a), 8 * np.cos(a), 0]))
    end = t + 0.8 + count * beat
    scene.move("offset", t, *offset, (end, [0, 0]))
    scene.move("spine", t, *spine, (end, _ZERO))
    return end


@action("trunk")
def look_around(scene: Scene, t: float, *, count: Count = 2, speed: Speed = 1.0) -> float:
    """Look to one side and the other, `count` looks in all."""
    side = 1 if scene.rng.random() < 0.5 else -1
    gaze, spine, pelvis = [], [], []
    for _ in range(count):
        angle, span, stay = scene.vary(62) * side, scene.vary(0.65) / speed, scene.vary(0.55)
        gaze += [(t + span, [angle, -3 + 4 * scene.normal()]), (t + span + stay, [1.04 * angle, 2])]
        spine += [(t + span + 0.12, [0, 0, 0.38 * angle]), (t + span + stay, [0, 0, 0.40 * angle])]
        pelvis.append((t + span + 0.15, [0, 0, 0.10 * angle]))
        t, side = t + span + stay, -side
    start = gaze[0][0] - 0.65 / speed
    scene.move("gaze", start, *gaze, (t + 0.7, [0, 0]))
    scene.move("spine", start, *spine, (t + 0.8, _ZERO))
    scene.move("pelvis", start, *pelvis, (t + 0.8, _ZERO))
    return t + 0.8


@action("trunk")
def look(
    scene: Scene,
    t: float,
    *,
    direction: Literal["left", "right", "up", "down"] = "left",
    hold: Hold = 0.8,
    speed: Speed = 1.0,
) -> float:
    """Turn the head in a direction and back."""
    span = scene.vary(0.6) / speed
    left, down = {"left": (68, 0), "right": (-68, 0), "up": (0, -48), "down": (0, 46)}[direction]
    end = t + span + hold
    scene.move("gaze", t, (t + span, [left, down]), (end, [left, down]), (end + span, [0, 0]))
    bend = [0, 0.15 * down, 0.35 * left]
    scene.move("spine", t, (t + span + 0.1, bend), (end, bend), (end + span, _ZERO))
    return end + span


@action("trunk")
def nod(scene: Scene, t: float, *, count: Count = 3, speed: Speed = 1.0) -> float:
    """Nod the head."""
    beat = scene.vary(0.55) / speed
    keys = [(t + (i + 0.5) * beat / 2 + 0.1, [0, -6 if i % 2 else scene.vary(30)]) for i in range(2 * count)]
    scene.move("gaze", t, *keys, (t + count * beat + 0.3, [0, 0]))
    return t + count * beat + 0.3


@action("trunk")
def shake_head(scene: Scene, t: float, *, count: Count = 3, speed: Speed = 1.0) -> float:
    """Shake the head."""
    beat = scene.vary(0.62) / speed
    first = 1 if scene.rng.random() < 0.5 else -1
    angles = [scene.vary(40) * first * (1 - 2 * (i % 2)) for i in range(2 * count)]
    keys = [(t + (i + 0.5) * beat / 2 + 0.1, np.array([angle, 3.0])) for i, angle in enumerate(angles)]
    scene.move("gaze", t, *keys, (t + count * beat + 0.35, [0, 0]))
    turns = [(time + 0.03, [0, 0, 0.15 * angle]) for (time, _), angle in zip(keys, angles, strict=True)]
    scene.move("spine", t, *turns, (t + count * beat + 0.35, _ZERO))
    return t + count * beat + 0.35
