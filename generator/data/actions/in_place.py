"""Stepping in place: marching, jogging and stomping; the arms stay free."""

import numpy as np

from generator.data.actions.registry import Count, Speed, action
from generator.data.actions.support import on_one_leg, share, some_side, stand_evenly
from generator.data.body import BALL_HEIGHT, OTHER, SIGN, Side
from generator.data.scene import Scene


def _in_place(
    scene: Scene,
    t: float,
    count: int,
    period: float,
    *,
    place: tuple[float, float],
    tip: float,
    arms: tuple[float, float],
) -> float:
    """Lift the feet in turn to `place` (forward, up), toes down by `tip` degrees, the arms swinging; the end time."""
    side = some_side(scene)
    t = on_one_leg(scene, t, OTHER[side], 0.3) - 0.08
    weight = scene.tracks["weight"]
    scene.hold(t, "swing")
    for i in range(count):
        home, down = scene.foot(side), t + 0.84 * period
        weight.key(t, share(OTHER[side]))
        weight.key(down, share(OTHER[side]))
        forward, up = place
        top = [*scene.local(forward, 0, origin=home), BALL_HEIGHT + scene.vary(up, 0.08), home[3]]
        scene.move(f"foot_{side}", t, (t + 0.42 * period, top), (down, home))
        scene.move(
            f"roll_{side}", t - 0.1, *((x, np.radians(a)) for x, a in (
                (t + 0.2 * period, max(25, tip)), (t + 0.42 * period, tip), (down, 8), (t + period, 0))),
        )  # fmt: skip
        scene.tracks["swing"].key(t + 0.45 * period, [-SIGN[side] * arms[0], arms[1]])
        t += period
        if i + 1 < count:
            weight.key(t, share(side))
        side = OTHER[side]
    scene.tracks["swing"].key(t + 0.4, [0, 0], 0.0)
    weight.key(t + 0.25, 0.5)
    return t + 0.4


@action("legs")
def march(scene: Scene, t: float, *, count: Count = 6, speed: Speed = 1.0) -> float:
    """March in place, `count` high knees in all."""
    return _in_place(scene, t, count, scene.vary(0.56) / speed, place=(0.14, 0.26), tip=18, arms=(0.55, 0.10))


@action("legs")
def jog_in_place(scene: Scene, t: float, *, count: Count = 10, speed: Speed = 1.0) -> float:
    """Jog in place, `count` steps in all, heels behind."""
    return _in_place(scene, t, count, scene.vary(0.36) / speed, place=(-0.12, 0.15), tip=55, arms=(0.35, 0.22))


@action("legs")
def stomp(scene: Scene, t: float, *, side: Side = "right", count: Count = 1, speed: Speed = 1.0) -> float:
    """Lift a foot and stamp it down hard."""
    t = on_one_leg(scene, t, OTHER[side])
    home = scene.foot(side)
    for _ in range(count):
        up, slam, rest = scene.vary(0.42) / speed, scene.vary(0.17) / speed**0.5, scene.vary(0.22) / speed
        top = [*scene.local(0.12, 0, origin=home), BALL_HEIGHT + scene.vary(0.26), home[3]]
        high, down = t + up, t + up + slam
        scene.move(f"foot_{side}", t, (high, top), (high + 0.04, top), (down, home))
        scene.move(f"roll_{side}", t - 0.08, (t + 0.1, 0.35), (high, 0.15), (down, 0.0))
        scene.move("spine", t, (high, [0, -2, 0]), (down + 0.08, [0, 8, 0]), (down + 0.5, [0, 0, 0]))
        scene.move("crouch", high, (down + 0.08, 0.035), (down + 0.4, 0.0))
        t = down + rest
    return stand_evenly(scene, t)


@action("legs")
def bounce(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Bounce in the knees, `count` times, the feet staying on the floor."""
    beat = scene.vary(0.52) / speed
    keys = [(t + (i + 1) * beat / 2, 0.012 if i % 2 else scene.vary(0.075)) for i in range(2 * count)]
    scene.move("crouch", t, *keys, (t + count * beat + 0.25, 0.0))
    return t + count * beat + 0.25


@action("legs")
def swing_leg(scene: Scene, t: float, *, side: Side = "right", count: Count = 2, speed: Speed = 1.0) -> float:
    """Swing a leg forward and back, `count` times, standing on the other one."""
    t = on_one_leg(scene, t, OTHER[side])
    home, foot, roll = scene.foot(side), f"foot_{side}", f"roll_{side}"
    beat = scene.vary(1.15) / speed

    def at(forward: float, up: float) -> list[float]:
        return [*scene.local(forward, 0.03 * SIGN[side], origin=home), BALL_HEIGHT + up, home[3]]

    front, middle, rear = at(0.42, scene.vary(0.20)), at(0.05, 0.07), at(-0.34, scene.vary(0.18))
    keys, tips = [], []
    for i in range(count):
        now = t + i * beat
        keys += [(now + 0.3 * beat, front), (now + 0.52 * beat, middle), (now + 0.75 * beat, rear)]
        keys += [(now + beat, middle)]
        tips += [(now + 0.3 * beat, -4.0), (now + 0.75 * beat, 48.0)]
    end = t + count * beat + 0.3
    scene.move(foot, t, *keys, (end, home))
    scene.move(roll, t, *[(time, np.radians(a)) for time, a in tips], (end - 0.05, 0.1), (end + 0.1, 0.0))
    return stand_evenly(scene, end)
