"""Other ways to step: marching, jogging, sneaking, stomping, dancing."""

import numpy as np

from generator.corpus.actions.footsteps import Curve, footstep, path, take
from generator.corpus.actions.record import Count, Speed, action
from generator.corpus.actions.support import on_one_leg, share, some_side, stand_evenly
from generator.corpus.body import BALL_HEIGHT, OTHER, SIGN, Side
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.corpus.vocabulary.ways import MAX_STRAIGHT_DEG, curved_ways
from generator.probes.spec import Probe, above, below, within


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


_FORWARD = ("forward", "forward", "forwards", "ahead")


def _jog_words(params: Params) -> Slots:
    curve = params.get("curve", 0.0)
    fast = params.get("speed", 1.0) > 1.2
    way = curved_ways(curve) if abs(curve) > MAX_STRAIGHT_DEG else _FORWARD
    return {"way": way, "verb": ("<run>",) if fast else ("<jog>", "<jog>", "<run>")}


@action(
    "legs",
    Entry(
        lambda d: {"count": d.count(4, 9), "speed": d.speed()},
        (
            "<march> in place",
            "<march> on the spot",
            "<march>",
            "<march> in place with high knees",
            "<walk> in place",
            "<march> in place lifting {poss} knees",
            "<step> in place",
        ),
        arms="<swing> naturally",
        legs="<march> in place",
        weight=1.8,
    ),
    Probe(
        "feet",
        {"foot.knee_at_top": above(80), "foot.toe": above(0.18), "ahead": within(-0.4, 0.4), "foot.lifts": above(1)},
        count="lifts",
    ),
)
def march(scene: Scene, t: float, *, count: Count = 6, speed: Speed = 1.0) -> float:
    """March in place, `count` high knees in all."""
    return _in_place(scene, t, count, scene.vary(0.56) / speed, place=(0.14, 0.26), tip=18, arms=(0.55, 0.10))


@action(
    "legs",
    Entry(
        lambda d: {"count": d.count(5, 12), "speed": d.uniform(0.9, 1.2)},
        (
            "<jog> in place",
            "<run> in place",
            "<jog> on the spot",
            "<run> on the spot",
            "<jog> in one place",
            "<jog> without moving forward",
        ),
        arms="<swing> with bent elbows",
        legs="<jog> in place",
        weight=1.5,
    ),
    Probe(
        "feet",
        {"foot.drop": above(1.0), "foot.toe": within(0.1, 0.25), "ahead": within(-0.4, 0.4), "foot.lifts": above(2)},
    ),
)
def jog_in_place(scene: Scene, t: float, *, count: Count = 10, speed: Speed = 1.0) -> float:
    """Jog in place, `count` steps in all, heels behind."""
    return _in_place(scene, t, count, scene.vary(0.36) / speed, place=(-0.12, 0.15), tip=55, arms=(0.35, 0.22))


@action(
    "legs",
    Entry(
        lambda d: {
            "steps": d.count(5, 11),
            "curve": float(d.pick(0, 60, -60, 100, -100, p=(0.6, 0.1, 0.1, 0.1, 0.1))),
            "speed": d.uniform(0.85, 1.35),
        },
        (
            "{verb} {way}",
            "{verb} {way}",
            "<jog> {way}",
            "{verb} {way}",
            "<jog> {way} lightly",
            "{verb} {way} at a steady pace",
        ),
        slots=_jog_words,
        arms="<swing> with bent elbows",
        legs="{verb} {way}",
        weight=3.0,
    ),
    Probe("feet", {"pace": above(1.2), "ahead": above(1.5), "foot.toe": above(0.1), "airborne": above(0.015)}),
)
def jog(scene: Scene, t: float, *, steps: Count = 8, curve: Curve = 0.0, speed: Speed = 1.0) -> float:
    """Jog with a short flight in each step, elbows bent; the last step closes."""
    plan = path(scene, steps, scene.vary(0.86, 0.05) * speed**0.7, curve)
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


@action(
    "legs",
    Entry(
        lambda d: {"steps": d.count(3, 6), "speed": d.uniform(0.8, 1.1)},
        (
            "<sneak> forward",
            "<sneak>",
            "<sneak> ahead quietly",
            "<tiptoe> forward",
            "<creep> forward",
            "<sneak> around",
            "<walk> forward stealthily",
        ),
        legs="<sneak> forward",
    ),
    Probe("", {"pelvis_mid": below(0.89), "ahead": above(0.8), "pitch_mid": above(1.5), "pace": below(0.8)}),
)
def sneak(scene: Scene, t: float, *, steps: Count = 5, speed: Speed = 1.0) -> float:
    """Sneak: slow, low, the knees bent and the toes first."""
    plan = path(scene, steps, 0.46 * speed**0.5, 0.0, width=0.09)
    depth, lean = scene.vary(0.14), scene.vary(26)
    end = take(scene, t, plan, scene.vary(0.95) / speed, shared=0.3, lift=0.11, toe_off=30, strike=14)
    scene.move("crouch", t, (t + 0.6, depth), (end - 0.4, depth), (end + 0.3, 0.0))
    scene.move("spine", t, (t + 0.6, [0, lean, 0]), (end - 0.4, [0, lean, 0]), (end + 0.3, [0, 0, 0]))
    scene.move("swing", t, (t + 0.6, [0, 0.22]), (end - 0.4, [0, 0.22]), (end + 0.3, [0, 0]))
    return end + 0.3


@action(
    "legs",
    Entry(
        lambda d: {"side": d.side(), "count": d.repeats(4), "speed": d.speed()},
        (
            "<stomp> {foot} {times}",
            "<stomp> with {foot} {times}",
            "<stamp> {foot} {times}",
            "<stomp> {foot} on the floor {times}",
            "<stomp> {times}",
            "<stamp> {foot} on the ground {times}",
        ),
        legs="<stomp> {foot}",
    ),
    Probe(
        "foot",
        {
            "foot.drop": above(1.6),
            "other_foot.knee_high": below(0.64),
            "foot.heel": within(0.2, 0.43),
            "foot.longest_up": below(1.2),
        },
        count="foot.kicks",
    ),
)
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


@action(
    "whole",
    Entry(
        lambda d: {"count": d.count(3, 8), "speed": d.uniform(0.85, 1.25)},
        (
            "<dance>",
            "<dance> around",
            "<dance> from side to side",
            "<do> a little dance",
            "<dance> to music",
            "<dance> happily",
            "<do> a dance",
        ),
        arms="<swing> to the rhythm",
        legs="<dance> from side to side",
        weight=1.5,
    ),
    Probe(
        "feet",
        {
            "turn_range": below(30),
            "flights": below(0),
            "side_steps": above(2),
            "bounces": above(3),
            "sway": above(0.1),
            "ahead": within(-0.3, 0.3),
        },
    ),
)
def dance(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Two-step: `count` times to the side and a touch of the other foot, bouncing, with swinging bent arms."""
    period, lead = scene.vary(0.46) / speed, some_side(scene)
    home, centre, plan = scene.centre, scene.centre, []
    for i in range(count):
        side = lead if i % 2 == 0 else OTHER[lead]
        centre = scene.local(0, SIGN[lead] * 0.26, origin=home) if i % 2 == 0 else home
        plan += [footstep(scene, s, centre, scene.heading) for s in (side, OTHER[side])]
    end = take(scene, t, plan, period, shared=0.3, lift=0.05, toe_off=14, strike=6)
    beats = [t + 0.32 + i * period for i in range(2 * count)]
    bounce = [(x + share_ * period, depth) for x in beats for share_, depth in ((0.35, 0.075), (0.85, 0.02))]
    scene.move("crouch", t, *bounce, (end + 0.2, 0.0))
    arms = [(x + 0.5 * period, [0.45 * (1 - 2 * (i % 2)), 0.24]) for i, x in enumerate(beats)]
    scene.move("swing", t, *arms, (end + 0.3, [0, 0]))
    twist = [(x + 0.5 * period, [0, 4, 12 * (1 - 2 * (i % 2))]) for i, x in enumerate(beats)]
    scene.move("spine", t, *twist, (end + 0.3, [0, 0, 0]))
    return end + 0.3
