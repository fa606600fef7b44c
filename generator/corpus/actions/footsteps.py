"""Steps that are planned, and taken one after the other."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from generator.corpus.actions.record import Range
from generator.corpus.actions.support import share, some_side
from generator.corpus.body import OTHER, SIGN, Floats, Side
from generator.corpus.scene import Scene

NARROW = 0.07  # half the width of a walk's track, m


Curve = Annotated[float, Range(-360.0, 360.0)]


@dataclass(frozen=True)
class Footstep:
    """Where a foot goes: place (2,), its yaw, and the body's heading by then."""

    side: Side
    place: Floats
    yaw: float
    heading: float


def footstep(scene: Scene, side: Side, centre: Floats, heading: float, *, width: float | None = None) -> Footstep:
    """A foot beside the path's `centre`, turned out a little."""
    half = scene.performer.stance if width is None else width
    place = scene.local(0.01 * scene.normal(), SIGN[side] * half, origin=centre, heading=heading)
    return Footstep(side, place, heading + SIGN[side] * np.radians(7), heading)


def take(
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


def path(scene: Scene, steps: int, length: float, curve: float, width: float = NARROW) -> list[Footstep]:
    """Steps along an arc of `curve` degrees in all, the first and the last one short, closed with both feet level."""
    side, heading, centre, plan = some_side(scene), scene.heading, scene.centre, []
    turn = np.radians(curve) / steps
    for i in range(steps):
        heading += turn
        stride = scene.vary(length, 0.05) * (0.5 if i in (0, steps - 1) else 1.0)
        centre = scene.local(stride, 0, origin=centre, heading=heading - 0.5 * turn)
        plan.append(footstep(scene, side, centre, heading, width=width if i < steps - 2 else None))
        side = OTHER[side]
    return [*plan, footstep(scene, side, centre, heading)]
