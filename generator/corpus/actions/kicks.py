"""Kicks and lifted knees."""

from typing import Literal

import numpy as np

from generator.corpus.actions.record import Count, Speed, action
from generator.corpus.actions.support import on_one_leg, stand_evenly
from generator.corpus.body import BALL_HEIGHT, OTHER, SIDES, SIGN, Side, aim, hand_at
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Probe, above, below, parameter


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


def _kick_words(params: Params) -> Slots:
    return {
        "high": {"low": ("low", ""), "middle": ("",), "high": ("high", "high", "")}[params["height"]],
        "way": {
            "forward": ("", "forward", "in front", "out in front"),
            "side": ("to the side", "sideways", "out to the side"),
        }[params["direction"]],
        "kick_name": {"forward": ("kick", "front kick"), "side": ("side kick", "sideways kick")}[params["direction"]],
    }


@action(
    "whole",
    Entry(
        lambda d: {
            "side": d.side(),
            "height": d.pick("low", "middle", "high"),
            "direction": d.pick("forward", "side", p=(0.75, 0.25)),
            "count": d.repeats(),
            "speed": d.speed(),
        },
        (
            "<kick> {way} {high} with {leg} {times}",
            "<kick> with {leg} {way} {times}",
            "<kick> {leg} {way} {high} {times}",
            "<kick> with {foot} {way} {times}",
            "<do> {some:{high} {kick_name}} with {leg}",
            "<kick> {way} {times}",
            "<give> {some:{high} {kick_name}} with {foot}",
            "<kick> {way} {high} using {leg} {times}",
            "<kick> something {way} with {foot} {times}",
            "<kick> {foot} up {way} {times}",
            "<kick> out {way} with {leg} {times}",
            "<make> {some:kick} {way} with {leg}",
        ),
        slots=_kick_words,
        legs="<kick> {way} with {leg}",
        weight=2.2,
    ),
    Probe(
        "foot",
        {"foot.toe": above(0.2), "pelvis_mid": above(0.9), "foot.speed": above(2.4), "foot.straightest": below(116)},
        {
            "forward": {"foot.front": above(0.42)},
            "side": {"foot.aside_at_top": above(0.28), "foot.front": below(0.42)},
        },
        wanted=parameter("direction"),
        count="foot.reaches",
    ),
)
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


@action(
    "whole",
    Entry(
        lambda d: {"side": d.side(), "count": d.repeats(), "speed": d.speed()},
        (
            "<lift> {knee} {times}",
            "<raise> {knee} {times}",
            "<raise> {leg} {times}",
            "<bring> {knee} up {times}",
            "<lift> {leg} up {times}",
            "<do> {some:knee lift} with {leg}",
            "<lift> {knee} high {times}",
            "<lift> {leg} off the ground {times}",
            "<bring> {knee} up to {poss} chest {times}",
            "<raise> {foot} {times}",
        ),
        legs="<lift> {knee}",
        weight=1.2,
    ),
    Probe(
        "foot",
        {"foot.knee_high": above(1.02), "foot.knee_at_top": above(70), "foot.front": below(0.62)},
        count="foot.kicks",
    ),
)
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
