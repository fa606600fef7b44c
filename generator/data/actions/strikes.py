"""Punches, throws and kicks: quick movements with the whole body behind them."""

from collections.abc import Sequence
from typing import Literal

import numpy as np

from generator.data.actions.registry import Count, Speed, action
from generator.data.actions.support import on_one_leg, stand_evenly
from generator.data.body import BALL_HEIGHT, OTHER, SIDES, SIGN, Side, aim, hand_at
from generator.data.scene import Scene


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


@action("whole")
def punch(scene: Scene, t: float, *, side: Side = "right", count: Count = 1, speed: Speed = 1.0) -> float:
    """Punch straight ahead with one hand."""
    order: list[Side] = [side] * count
    return _punches(scene, t, order, speed)


@action("whole")
def alternate(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Box: `count` straight punches, left and right in turn."""
    first: Side = "left" if scene.rng.random() < 0.5 else "right"
    order: list[Side] = [first if i % 2 == 0 else OTHER[first] for i in range(count)]
    return _punches(scene, t, order, speed)


@action("whole")
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


@action("whole")
def kick(
    scene: Scene,
    t: float,
    *,
    side: Side = "right",
    height: Literal["low", "middle", "high"] = "middle",
    direction: Literal["forward", "side"] = "forward",
    count: Count = 1,
    speed: Speed = 1.0,
) -> float:
    """Kick forward or to the side and bring the foot back."""
    for _ in range(count):
        t = (
            _kick_forward(scene, t, side, height, speed)
            if direction == "forward"
            else _kick_aside(scene, t, side, height, speed)
        )
    return t


def _kick_forward(scene: Scene, t: float, side: Side, height: str, speed: float) -> float:
    other, foot, roll, sign = OTHER[side], f"foot_{side}", f"roll_{side}", SIGN[side]
    far, z = {"low": (0.58, 0.22), "middle": (0.66, 0.50), "high": (0.66, 0.84)}[height]
    z = scene.vary(z, 0.05)
    t = on_one_leg(scene, t, other)
    home = scene.foot(side)

    def at(forward: float, up: float) -> list[float]:
        return [*scene.local(forward, 0, origin=home), BALL_HEIGHT + up, home[3]]

    cock, strike, back = (scene.vary(x) / speed**0.5 for x in (0.35, 0.29, 0.42))
    up, hit = t + cock, t + cock + strike
    end = hit + back + 0.15
    scene.move(
        foot, t, (up, at(-0.30, 0.16)), (t + cock + 0.55 * strike, at(0.22, 0.08 + 0.3 * z)), (hit, at(far, z)),
        (hit + 0.04, at(far, z)), (hit + 0.6 * back, at(0.22, 0.10 + 0.3 * z)), (end, home),
    )  # fmt: skip
    scene.move(
        roll, t - 0.1, *((x, np.radians(a)) for x, a in (
            (t, 25), (up, 75), (t + cock + 0.55 * strike, 20), (hit, -5), (hit + 0.5 * back, 30), (end, 6),
            (end + 0.15, 0))),
    )  # fmt: skip
    tilt = -10 - 12 * z
    scene.move("spine", t, (up, [0, 8, 6 * sign]), (hit, [0, -6, -8 * sign]), (end, [0, 0, 0]))
    scene.move("pelvis", t, (up, [0, 6, -8 * sign]), (hit, [0, tilt, 10 * sign]), (end, [0, 0, 0]))
    scene.move("crouch", t, (up, 0.03), (end, 0.0))
    scene.move(
        f"arm_{other}", t, (up, aim(-0.2, 0.5, -0.8, 0.9)), (hit, aim(0.7, 0.35, -0.5, 0.85)),
        (end + 0.3, scene.rest[other]),
    )  # fmt: skip
    scene.move(
        f"arm_{side}", t, (up, aim(0.45, 0.4, -0.7, 0.85)), (hit, aim(-0.35, 0.55, -0.75, 0.9)),
        (end + 0.3, scene.rest[side]),
    )  # fmt: skip
    return stand_evenly(scene, end)


def _kick_aside(scene: Scene, t: float, side: Side, height: str, speed: float) -> float:
    other, foot, roll, sign = OTHER[side], f"foot_{side}", f"roll_{side}", SIGN[side]
    far, z = {"low": (0.45, 0.20), "middle": (0.58, 0.46), "high": (0.62, 0.72)}[height]
    z = scene.vary(z, 0.05)
    t = on_one_leg(scene, t, other)
    home = scene.foot(side)

    def at(forward: float, outward: float, up: float) -> list[float]:
        return [*scene.local(forward, outward * sign, origin=home), BALL_HEIGHT + up, home[3]]

    chamber, strike, back = (scene.vary(x) / speed**0.5 for x in (0.45, 0.30, 0.45))
    up, hit = t + chamber, t + chamber + strike
    end = hit + back + 0.25
    out = at(0.02, far, z)
    scene.move(
        foot, t, (up, at(0.08, 0.06, 0.35)), (hit, out), (hit + 0.06, out), (hit + 0.6 * back, at(0.05, 0.12, 0.25)),
        (end, home),
    )  # fmt: skip
    scene.move(
        roll, t - 0.1, *((x, np.radians(a)) for x, a in (
            (t + 0.1, 25), (up, 20), (hit, -5), (hit + 0.5 * back, 20), (end, 6), (end + 0.15, 0))),
    )  # fmt: skip
    scene.move("spine", t, (up, [0, 4, 0]), (hit, [10 * sign, 0, 0]), (end, [0, 0, 0]))
    scene.move("pelvis", t, (up, [2 * sign, 0, 0]), (hit, [(8 + 20 * z) * sign, 0, 0]), (end, [0, 0, 0]))
    for s in SIDES:
        spread = aim(0.35, 0.75, -0.55, 0.85) if s == other else aim(0.45, 0.35, -0.6, 0.75)
        scene.move(f"arm_{s}", t, (up, hand_at(0.26, 0.20, -0.14)), (hit, spread), (end + 0.3, scene.rest[s]))
    return stand_evenly(scene, end)


@action("whole")
def knee_lift(scene: Scene, t: float, *, side: Side = "right", count: Count = 1, speed: Speed = 1.0) -> float:
    """Lift a bent knee to the height of the hip."""
    other, foot, roll = OTHER[side], f"foot_{side}", f"roll_{side}"
    t = on_one_leg(scene, t, other)
    home = scene.foot(side)
    for _ in range(count):
        up, keep, down = (scene.vary(x) / speed for x in (0.5, 0.15, 0.5))
        top = [*scene.local(0.30, 0, origin=home), BALL_HEIGHT + scene.vary(0.42, 0.05), home[3]]
        high, end = t + up, t + up + keep + down
        scene.move(foot, t, (high, top), (high + keep, top), (end, home))
        scene.move(
            roll, t - 0.1, *((x, np.radians(a)) for x, a in (
                (t + 0.08, 25), (high, 25), (high + keep, 22), (end, 6), (end + 0.12, 0))),
        )  # fmt: skip
        scene.move("swing", t, (high, [0.45 * SIGN[other], 0.12]), (end, [0, 0]))
        scene.move("spine", t, (high, [0, 4, 0]), (end, [0, 0, 0]))
        t = end + 0.12
    return stand_evenly(scene, t)
