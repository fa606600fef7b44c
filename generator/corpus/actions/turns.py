"""Walking and stepping round."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from generator.corpus.actions.footsteps import Footstep, footstep, path, take
from generator.corpus.actions.record import Angle, Count, Speed, action
from generator.corpus.body import OTHER, SIGN, Side
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry, Params, Slots
from generator.probes.spec import Extent, Probe, above, below, parameter


def _circle_words(params: Params) -> Slots:
    side, other = params["direction"], {"left": "counterclockwise", "right": "clockwise"}[params["direction"]]
    return {
        "circle": (
            f"in a {other} circle",
            "in a circle",
            f"around in a circle to the {side}",
            f"{other} in a circle",
            "around in a circle",
            f"in a circle to the {side}",
        )
    }


def _turn_words(params: Params) -> Slots:
    angle = params["angle"]
    side, clock = ("left", "counterclockwise") if angle > 0 else ("right", "clockwise")
    size = abs(angle)
    if size > 300:
        return {
            "round": (
                "in a full circle",
                "360 degrees",
                f"in a full circle to the {side}",
                f"all the way around {clock}",
            ),
            "turn": ("<turn>", "<spin>", "<turn> around"),
        }
    if size > 150:
        around = ("around", "around", "around", f"around to the {side}", "180 degrees", f"around {clock}")
        return {"round": around, "turn": ("<turn>", "<turn>", "<rotate>")}
    ways = [f"to the {side}", f"to the {side}", side, f"to {{poss}} {side}"]
    ways += [f"90 degrees to the {side}", f"a quarter turn to the {side}"] if 80 < size < 100 else []
    ways += [f"slightly to the {side}", f"a little to the {side}"] if size < 55 else []
    return {"round": tuple(ways), "turn": ("<turn>", "<turn>", "<rotate>", "<pivot>")}


def _turned_wanted(params: Mapping[str, Any]) -> str:
    return "" if "angle" not in params else "left" if params["angle"] > 0 else "right"


@action(
    "legs",
    Entry(
        lambda d: {"direction": d.side(), "steps": d.count(7, 12), "speed": d.speed()},
        (
            "<walk> {circle}",
            "<walk> {circle}",
            "<move> {circle}",
            "<go> {circle}",
            "<pace> {circle}",
            "<travel> {circle}",
        ),
        slots=_circle_words,
        arms="<swing> naturally",
        legs="<walk> {circle}",
        weight=2.5,
    ),
    Probe(
        "",
        {"path": above(1.5)},
        {"left": {"turned": above(240)}, "right": {"turned": below(-240)}},
        wanted=parameter("direction"),
    ),
)
def walk_circle(
    scene: Scene,
    t: float,
    *,
    direction: Literal["left", "right"] = "left",
    steps: Count = 12,
    speed: Speed = 1.0,
) -> float:
    """Walk once around a circle: to the left (counter-clockwise) or to the right (clockwise)."""
    plan = path(scene, steps, 0.58 * speed**0.45, 360.0 * SIGN[direction])
    return take(scene, t, plan, scene.vary(0.57, 0.04) / speed**0.55, shared=0.2, toe_off=45, strike=-18)


@action(
    "legs",
    Entry(
        lambda d: {
            "angle": float(d.pick(45, 90, 135, 180, 360, p=(0.12, 0.43, 0.1, 0.27, 0.08)) * d.pick(1, -1)),
            "speed": d.speed(),
        },
        (
            "{turn} {round}",
            "{turn} {round}",
            "<turn> {round}",
            "<turn> {round}",
            "{turn} {round} on the spot",
            "<turn> {poss} body {round}",
        ),
        slots=_turn_words,
        legs="<turn> {round}",
        weight=5.0,
    ),
    Probe(
        "",
        {"turn_range": above(25), "path": below(1.2), "pelvis_low": above(0.93), "lifts": above(1)},
        {"left": {"turned": above(25)}, "right": {"turned": below(-25)}},
        wanted=_turned_wanted,
        extent=Extent("turned", "angle", 0.25, 15.0),
    ),
)
def turn(scene: Scene, t: float, *, angle: Angle = 90.0, speed: Speed = 1.0) -> float:
    """Turn in place with small steps; degrees, left positive."""
    lead: Side = "left" if angle > 0 else "right"
    parts = max(1, int(np.ceil(abs(angle) / 50)))
    part, heading, plan = np.radians(angle) / parts, scene.heading, []
    centre = scene.centre
    for _ in range(parts):
        heading += part
        opening, closing = (footstep(scene, side, centre, heading) for side in (lead, OTHER[lead]))
        plan += [Footstep(lead, opening.place, opening.yaw, heading - 0.4 * part), closing]
    look = np.clip(0.5 * angle, -40, 40)
    scene.move("gaze", t, (t + 0.35, [look, 4]), (t + 0.6 + 0.35 * len(plan), [0, 0]))
    return take(scene, t, plan, scene.vary(0.48) / speed, shared=0.18, lift=0.045, toe_off=10, strike=0)
