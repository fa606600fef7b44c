"""Locomotion: steps, walks, turns and a dance."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np

from generator.data.actions.registry import Angle, Count, Hold, Range, Size, Speed, action
from generator.data.actions.support import on_one_leg, share, some_side
from generator.data.body import OTHER, SIGN, Floats, Side
from generator.data.scene import Scene

_NARROW = 0.07  # half the width of a walk's track, m
Curve = Annotated[float, Range(-360.0, 360.0)]


@dataclass(frozen=True)
class Footstep:
    """Where a foot goes: place (2,), its yaw, and the body's heading by then."""

    side: Side
    place: Floats
    yaw: float
    heading: float


def _footstep(scene: Scene, side: Side, centre: Floats, heading: float, *, width: float | None = None) -> Footstep:
    """A foot beside the path's `centre`, turned out a little."""
    half = scene.performer.stance if width is None else width
    place = scene.local(0.01 * scene.normal(), SIGN[side] * half, origin=centre, heading=heading)
    return Footstep(side, place, heading + SIGN[side] * np.radians(7), heading)


def _take(
    scene: Scene,
    t: float,
    plan: Sequence[Footstep],
    period: float,
    *,
    shared: float = 0.22,
    lift: float = 0.05,
    toe_off: float = 25.0,
    strike: float = -8.0,
) -> float:
    """Take the planned steps, one each `period` s, the share `shared` of it on both feet; the end time."""
    weight, heading = scene.tracks["weight"], scene.tracks["heading"]
    scene.hold(t, "heading", "weight", "foot_left", "foot_right", "roll_left", "roll_right")
    first = scene.vary(0.32)
    weight.key(t + first, share(OTHER[plan[0].side]))
    t += first
    for i, step in enumerate(plan):
        span = scene.vary(period, 0.04)
        landed = t + (1 - shared) * span
        weight.key(t, share(OTHER[step.side]))
        weight.key(landed, share(OTHER[step.side]))
        scene.swing_foot(step.side, t, landed, step.place, step.yaw, lift=lift, toe_off=toe_off, strike=strike)
        heading.key(t + 0.75 * span, step.heading)
        t += span
        if i + 1 < len(plan):
            weight.key(t, share(OTHER[plan[i + 1].side]))
    weight.key(t + 0.25, 0.5)
    heading.key(t + 0.1, plan[-1].heading, 0.0)
    return t + 0.25


@action("legs")
def stand(scene: Scene, t: float, *, hold: Hold = 1.0) -> float:
    """Stand for a while."""
    return t + hold


@action("legs")
def step(
    scene: Scene,
    t: float,
    *,
    direction: Literal["forward", "backward", "left", "right", "diagonal_left", "diagonal_right"] = "forward",
    count: Count = 1,
    size: Size = 1.0,
    speed: Speed = 1.0,
) -> float:
    """Single steps: one foot goes, the other one closes."""
    forward, left = {
        "forward": (0.42, 0), "backward": (-0.36, 0), "left": (0, 0.36), "right": (0, -0.36),
        "diagonal_left": (0.32, 0.28), "diagonal_right": (0.32, -0.28),
    }[direction]  # fmt: skip
    lead: Side = "left" if left > 0 else "right" if left < 0 else some_side(scene)
    centre, heading, plan = scene.centre, scene.heading, []
    for _ in range(count):
        centre = scene.local(forward * scene.vary(size, 0.05), left * size, origin=centre)
        plan += [_footstep(scene, side, centre, heading) for side in (lead, OTHER[lead])]
    toe_off, strike = (16, -8) if forward > 0 else (8, 0)
    return _take(scene, t, plan, scene.vary(0.62) / speed, shared=0.2, toe_off=toe_off, strike=strike)


def _path(scene: Scene, steps: int, length: float, curve: float, width: float = _NARROW) -> list[Footstep]:
    """Steps along an arc of `curve` degrees in all, the first and the last one short, closed with both feet level."""
    side, heading, centre, plan = some_side(scene), scene.heading, scene.centre, []
    turn = np.radians(curve) / steps
    for i in range(steps):
        heading += turn
        stride = scene.vary(length, 0.05) * (0.5 if i in (0, steps - 1) else 1.0)
        centre = scene.local(stride, 0, origin=centre, heading=heading - 0.5 * turn)
        plan.append(_footstep(scene, side, centre, heading, width=width if i < steps - 2 else None))
        side = OTHER[side]
    return [*plan, _footstep(scene, side, centre, heading)]


@action("legs")
def walk(
    scene: Scene,
    t: float,
    *,
    direction: Literal["forward", "backward", "left", "right"] = "forward",
    steps: Count = 6,
    curve: Curve = 0.0,
    size: Size = 1.0,
    speed: Speed = 1.0,
) -> float:
    """Walk; `curve` bends a forward walk (degrees in all, left positive); left and right are side steps."""
    period = scene.vary(0.56, 0.04) / speed**0.55
    if direction in ("left", "right"):
        lead: Side = "left" if direction == "left" else "right"
        centre, plan = scene.centre, []
        for _ in range(max(1, round(steps / 2))):
            centre = scene.local(0, SIGN[lead] * scene.vary(0.33, 0.06) * size, origin=centre)
            plan += [_footstep(scene, s, centre, scene.heading) for s in (lead, OTHER[lead])]
        return _take(scene, t, plan, period, shared=0.2, toe_off=12, strike=0)
    if direction == "backward":
        plan = _path(scene, steps, -0.38 * size * speed**0.45, 0.0, width=0.085)
        return _take(scene, t, plan, period, shared=0.2, toe_off=10, strike=10)
    plan = _path(scene, steps, 0.62 * size * speed**0.45, curve)
    return _take(scene, t, plan, period, shared=0.2, lift=0.045, toe_off=min(56 * speed**0.3 * size, 62), strike=-22)


@action("legs")
def walk_circle(
    scene: Scene,
    t: float,
    *,
    direction: Literal["left", "right"] = "left",
    steps: Count = 12,
    speed: Speed = 1.0,
) -> float:
    """Walk once around a circle: to the left (counter-clockwise) or to the right (clockwise)."""
    plan = _path(scene, steps, 0.58 * speed**0.45, 360.0 * SIGN[direction])
    return _take(scene, t, plan, scene.vary(0.57, 0.04) / speed**0.55, shared=0.2, toe_off=45, strike=-18)


@action("legs")
def turn(scene: Scene, t: float, *, angle: Angle = 90.0, speed: Speed = 1.0) -> float:
    """Turn in place with small steps; degrees, left positive."""
    lead: Side = "left" if angle > 0 else "right"
    parts = max(1, int(np.ceil(abs(angle) / 50)))
    part, heading, plan = np.radians(angle) / parts, scene.heading, []
    centre = scene.centre
    for _ in range(parts):
        heading += part
        opening, closing = (_footstep(scene, side, centre, heading) for side in (lead, OTHER[lead]))
        plan += [Footstep(lead, opening.place, opening.yaw, heading - 0.4 * part), closing]
    look = np.clip(0.5 * angle, -40, 40)
    scene.move("gaze", t, (t + 0.35, [look, 4]), (t + 0.6 + 0.35 * len(plan), [0, 0]))
    return _take(scene, t, plan, scene.vary(0.48) / speed, shared=0.18, lift=0.045, toe_off=10, strike=0)


@action("legs")
def sneak(scene: Scene, t: float, *, steps: Count = 5, speed: Speed = 1.0) -> float:
    """Sneak: slow, low, the knees bent and the toes first."""
    plan = _path(scene, steps, 0.46 * speed**0.5, 0.0, width=0.09)
    depth, lean = scene.vary(0.14), scene.vary(26)
    end = _take(scene, t, plan, scene.vary(0.95) / speed, shared=0.3, lift=0.11, toe_off=30, strike=14)
    scene.move("crouch", t, (t + 0.6, depth), (end - 0.4, depth), (end + 0.3, 0.0))
    scene.move("spine", t, (t + 0.6, [0, lean, 0]), (end - 0.4, [0, lean, 0]), (end + 0.3, [0, 0, 0]))
    scene.move("swing", t, (t + 0.6, [0, 0.22]), (end - 0.4, [0, 0.22]), (end + 0.3, [0, 0]))
    return end + 0.3


@action("legs")
def jog(scene: Scene, t: float, *, steps: Count = 8, curve: Curve = 0.0, speed: Speed = 1.0) -> float:
    """Jog with a short flight in each step, elbows bent; the last step closes."""
    plan = _path(scene, steps, scene.vary(0.86, 0.05) * speed**0.7, curve)
    period = scene.vary(0.37, 0.04) / speed**0.35
    t = on_one_leg(scene, t, OTHER[plan[0].side], 0.3) - 0.1
    weight, crouch, heading = (scene.tracks[name] for name in ("weight", "crouch", "heading"))
    scene.hold(t, "heading", "crouch")
    flying = range(1, steps)
    for i, step in enumerate(plan):
        landed = t + (i + 1) * period
        off = landed - (1.36 if i in flying else 0.8) * period
        last = i == len(plan) - 1
        weight.key(off if i in flying else landed - 0.3 * period, share(OTHER[step.side]))
        weight.key(landed, share(step.side))
        quick = {"lift": 0.10, "toe_off": 55.0, "strike": -6.0} if not last else {"lift": 0.05, "toe_off": 30.0}
        scene.swing_foot(step.side, off, landed, step.place, step.yaw, tuck=40.0 if i in flying else 6.0, **quick)
        heading.key(landed - 0.2 * period, step.heading)
        crouch.key(landed - 0.12 * period, 0.035)
        crouch.key(landed + 0.36 * period, 0.085 if i in flying else 0.05)
    end = t + (len(plan) + 1) * period + 0.25
    heading.key(end - 0.3, plan[-1].heading, 0.0)
    crouch.key(end, 0.0, 0.0)
    weight.key(end, 0.5)
    scene.move("swing", t, (t + 0.35, [0, 0.24]), (end - 0.35, [0, 0.24]), (end + 0.2, [0, 0]))
    scene.move("spine", t, (t + 0.4, [0, 8, 0]), (end - 0.5, [0, 7, 0]), (end, [0, 0, 0]))
    return end + 0.2


@action("whole")
def dance(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Two-step: `count` times to the side and a touch of the other foot, bouncing, with swinging bent arms."""
    period, lead = scene.vary(0.46) / speed, some_side(scene)
    home, centre, plan = scene.centre, scene.centre, []
    for i in range(count):
        side = lead if i % 2 == 0 else OTHER[lead]
        centre = scene.local(0, SIGN[lead] * 0.26, origin=home) if i % 2 == 0 else home
        plan += [_footstep(scene, s, centre, scene.heading) for s in (side, OTHER[side])]
    end = _take(scene, t, plan, period, shared=0.3, lift=0.05, toe_off=14, strike=6)
    beats = [t + 0.32 + i * period for i in range(2 * count)]
    bounce = [(x + share_ * period, depth) for x in beats for share_, depth in ((0.35, 0.075), (0.85, 0.02))]
    scene.move("crouch", t, *bounce, (end + 0.2, 0.0))
    arms = [(x + 0.5 * period, [0.45 * (1 - 2 * (i % 2)), 0.24]) for i, x in enumerate(beats)]
    scene.move("swing", t, *arms, (end + 0.3, [0, 0]))
    twist = [(x + 0.5 * period, [0, 4, 12 * (1 - 2 * (i % 2))]) for i, x in enumerate(beats)]
    scene.move("spine", t, *twist, (end + 0.3, [0, 0, 0]))
    return end + 0.3
