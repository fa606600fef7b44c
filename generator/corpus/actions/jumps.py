"""Leaving the floor: jumps, hops, jumping jacks."""

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np

from generator.corpus.actions.record import Angle, Count, Range, Speed, action
from generator.corpus.actions.support import on_one_leg, stand_evenly
from generator.corpus.body import BALL_HEIGHT, OTHER, SIDES, SIGN, Floats, Side, aim
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Draw, Entry, Params, Slots
from generator.probes.spec import Probe, above, below, within

JumpHeight = Annotated[float, Range(0.03, 0.5)]


JumpDistance = Annotated[float, Range(-0.8, 1.2)]


HopDistance = Annotated[float, Range(-0.3, 0.6)]
_GRAVITY = 9.81


def flight_time(height: float) -> float:
    """Seconds in the air for a rise of the centre of mass in m."""
    return float(2 * np.sqrt(2 * height / _GRAVITY))


def _fly(scene: Scene, t: float, height: float, goals: dict[Side, Floats], *, tuck: float = 0.25) -> float:
    """Lift off at `t` to a height in m; each foot flies to its goal (4,), drawn up by the share `tuck`; the landing."""
    span = flight_time(height)
    starts = {side: scene.foot(side) for side in goals}
    scene.hold(t, "air", *(f"foot_{side}" for side in goals))
    for x in np.linspace(0, 1, 9)[1:-1]:
        rise, climb = 4 * height * x * (1 - x), 4 * height * (1 - 2 * x) / span
        scene.tracks["air"].key(t + x * span, rise, climb)
        drawn = tuck * height * 16 * x**2 * (1 - x) ** 2
        drawing = tuck * height * 32 * x * (1 - x) * (1 - 2 * x) / span
        for side, goal in goals.items():
            way = goal - starts[side]
            up = np.array([0, 0, 1, 0])
            scene.tracks[f"foot_{side}"].key(
                t + x * span, starts[side] + x * way + up * (rise + drawn), way / span + up * (climb + drawing)
            )
    scene.tracks["air"].key(t + span, 0.0, 0.0)
    for side, goal in goals.items():
        scene.tracks[f"foot_{side}"].key(t + span, goal, 0.0)
    return t + span


def _landing(scene: Scene, forward: float, left: float, turn: float) -> dict[Side, Floats]:
    """Where the feet (4,) land after a jump by so many m and rad, as far apart as they stand."""
    centre, c, s = scene.centre, np.cos(turn), np.sin(turn)
    middle = scene.local(forward, left)
    goals: dict[Side, Floats] = {}
    for side in SIDES:
        foot = scene.foot(side)
        place = middle + np.array([[c, -s], [s, c]]) @ (foot[:2] - centre)
        goals[side] = np.array([*place, BALL_HEIGHT, foot[3] + turn])
    return goals


def _toes(off: float, landed: float, angle: float) -> list[tuple[float, float]]:
    """Roll keys: up on the toes to take off, toes first to land."""
    return [
        (off + 0.02, np.radians(angle)),
        (0.5 * (off + landed), np.radians(0.75 * angle)),
        (landed, np.radians(0.45 * angle)),
        (landed + 0.12, 0.0),
    ]


def _turning_words(angle: float) -> tuple[str, ...]:
    """How a jump that turns by that many degrees is told."""
    side, size = "left" if angle > 0 else "right", abs(angle)
    if size > 300:
        return ("with a full turn", "360 degrees", "with a 360 degree spin")
    if size > 150:
        return ("with a half turn", "180 degrees", "around to face the other way", "with a 180 degree turn")
    return (f"with a quarter turn to the {side}", f"90 degrees to the {side}", f"with a turn to the {side}")


def _jump_words(params: Params) -> Slots:
    if angle := params.get("angle", 0.0):
        return {"way": _turning_words(angle)}
    if aside := params.get("aside", 0.0):
        side = "left" if aside > 0 else "right"
        return {"way": (f"to the {side}", f"sideways to the {side}", side)}
    if params["distance"] > 0.1:
        return {"way": ("forward", "forwards", "ahead")}
    if params["distance"] < -0.1:
        return {"way": ("backwards", "back", "backward")}
    repeated = ("up and down",) if params["count"] > 1 else ()
    high = ("high", "high in the air") if params["height"] > 0.27 else ()
    return {"way": ("", "up", "in place", "in the air", "straight up", *repeated, *high)}


def _hop_words(params: Params) -> Slots:
    return {"way": ("forward", "forwards", "ahead") if params["distance"] > 0 else ("",)}


def _draw_jump_words(draw: Draw) -> Params:
    """In place, forward, backward, to a side, or with a turn."""
    kind = draw.pick("", "forward", "backward", "aside", "turn", p=(0.40, 0.26, 0.08, 0.14, 0.12))
    sign, count = draw.pick(1, -1), draw.repeats()
    more: Params = {
        "": {},
        "forward": {"distance": draw.uniform(0.3, 0.75)},
        "backward": {"distance": -draw.uniform(0.25, 0.4)},
        "aside": {"aside": sign * draw.uniform(0.25, 0.45)},
        "turn": {"angle": float(sign * draw.pick(90, 180, 360, p=(0.5, 0.4, 0.1))), "count": 1},
    }[kind]
    height = draw.uniform(0.2, 0.34) if kind == "turn" else draw.uniform(0.12, 0.32)
    base = {"count": count, "height": height, "distance": 0.0, "speed": draw.uniform(0.9, 1.15)}
    return {**base, **more}


def _jumped_wanted(params: Mapping[str, Any]) -> str:
    if angle := params.get("angle", 0.0):
        return "turning left" if angle > 0 else "turning right"
    if aside := params.get("aside", 0.0):
        return "left" if aside > 0 else "right"
    if "distance" not in params:
        return ""
    return "forward" if params["distance"] > 0.1 else "backward" if params["distance"] < -0.1 else "up"


@action(
    "whole",
    Entry(
        _draw_jump_words,
        (
            "<jump> {way} {times}",
            "<jump> {way} with both feet {times}",
            "<do> {some:jump} {way}",
            "<take> {some:jump} {way}",
            "<leap> {way} {times}",
            "<jump> {way} {times}",
        ),
        slots=_jump_words,
        legs="<jump> {way}",
        weight=2.2,
    ),
    Probe(
        "",
        {"flights": above(1), "pelvis_low": below(0.8), "jump": above(0.07), "pelvis_high": above(1.06)},
        {
            "up": {"ahead": within(-0.25, 0.25), "aside": within(-0.2, 0.2)},
            "left": {"aside": above(0.15)},
            "right": {"aside": below(-0.15)},
            "turning left": {"turned": above(50)},
            "turning right": {"turned": below(-50)},
            "forward": {"ahead": above(0.25)},
            "backward": {"ahead": below(-0.2)},
        },
        wanted=_jumped_wanted,
        count="flights",
    ),
)
def jump(
    scene: Scene,
    t: float,
    *,
    count: Count = 1,
    height: JumpHeight = 0.25,
    distance: JumpDistance = 0.0,
    aside: JumpDistance = 0.0,
    angle: Angle = 0.0,
    speed: Speed = 1.0,
) -> float:
    """Jump in place or by `distance` m forward and `aside` m to the left, turning by `angle` degrees to the left.

    Crouch, swing the arms, fly, land softly.
    """
    for i in range(count):
        dip, push, rise = scene.vary(0.5) / speed, scene.vary(0.26), scene.vary(height, 0.06)
        depth, off = 0.20 + 0.25 * height, t + dip + push
        goals = _landing(scene, distance, aside, np.radians(angle))
        heading = scene.heading
        landed = _fly(scene, off, rise, goals)
        scene.move("heading", off - 0.1 * bool(angle), (landed, heading + np.radians(angle)))
        middle, settled = 0.5 * (off + landed), landed + 0.75
        scene.move(
            "crouch", t, (t + dip, depth), (off, 0.0), (middle, 0.05), (landed, 0.03), (landed + 0.17, 0.6 * depth),
            (settled, 0.0),
        )  # fmt: skip
        for track, lean in (("pelvis", 28), ("spine", 18)):
            bend = {
                "start": lean,
                "up": 4 if track == "pelvis" else -3,
                "land": 0.7 * lean if track == "pelvis" else 11,
            }
            scene.move(
                track, t, (t + dip, [0, bend["start"], 0]), (off, [0, bend["up"], 0]), (landed, [0, 6, 0]),
                (landed + 0.19, [0, bend["land"], 0]), (settled + 0.05, [0, 0, 0]),
            )  # fmt: skip
        for s in SIDES:
            scene.move(f"roll_{s}", t + dip + 0.35 * push, *_toes(off, landed, 48))
            scene.move(
                f"arm_{s}", t, (t + dip, aim(-0.55, 0.25, -0.75, 0.92)), (off - 0.02, aim(0.85, 0.25, -0.05, 0.86)),
                (off + 0.4 * (landed - off), aim(0.8, 0.4, 0.35, 0.85, 0.1)),
                (landed + 0.2, aim(0.6, 0.4, -0.65, 0.86)), (landed + 0.9, scene.rest[s]),
            )  # fmt: skip
        t = landed + (0.9 if i == count - 1 else 0.75)
    return t


@action(
    "whole",
    Entry(
        lambda d: {
            "side": d.side(),
            "count": d.count(2, 5),
            "distance": d.pick(0.0, 0.0, d.uniform(0.2, 0.4)),
            "speed": d.uniform(0.9, 1.15),
        },
        (
            "<hop> {way} on {leg} {times}",
            "<hop> {way} on {foot} {times}",
            "<hop> {way} on one leg {times}",
            "<hop> {way} on {leg}",
            "<do> {some:hop} {way} on {leg}",
            "<jump> {way} on {leg} {times}",
            "<jump> {way} on one leg {times}",
        ),
        slots=_hop_words,
        legs="<hop> {way} on {leg}",
        weight=1.3,
    ),
    Probe(
        "foot",
        {"other_foot.longest_up": above(1.2), "flights": above(1), "foot.longest_up": below(0.9)},
        count="flights",
    ),
)
def hop(
    scene: Scene,
    t: float,
    *,
    side: Side = "right",
    count: Count = 3,
    distance: HopDistance = 0.0,
    speed: Speed = 1.0,
) -> float:
    """Hop on one leg (`side`), each time by `distance` m (forward positive)."""
    free = OTHER[side]
    t = on_one_leg(scene, t, side)
    ground, lifted = scene.foot(free), scene.foot(free)
    lifted[:2], lifted[2] = scene.local(-0.10, -0.02 * SIGN[free], origin=lifted), BALL_HEIGHT + 0.24
    scene.move(f"foot_{free}", t, (t + 0.45, lifted))
    scene.move(f"roll_{free}", t - 0.1, (t + 0.2, 0.5), (t + 0.45, 0.8))
    t += 0.45
    for _ in range(count):
        dip, push, height = scene.vary(0.26) / speed, 0.16, scene.vary(0.07)
        off = t + dip + push
        way = np.array([*(scene.local(distance, 0, origin=np.zeros(2))), 0.0, 0.0])
        lifted, ground = lifted + way, ground + way
        landed = _fly(scene, off, height, {side: scene.foot(side) + way, free: lifted}, tuck=0.15)
        scene.move(
            "crouch", t, (t + dip, 0.085), (off, 0.0), (landed, 0.02), (landed + 0.12, 0.07), (landed + 0.3, 0.03)
        )
        scene.move("spine", t, (t + dip, [0, 9, 0]), (off, [0, 2, 0]), (landed + 0.12, [0, 7, 0]))
        scene.move(f"roll_{side}", t + dip, *_toes(off, landed, 32))
        for s in SIDES:
            low, high = aim(0.35, 0.55, -0.75, 0.85), aim(0.40, 0.75, -0.35, 0.85)
            scene.move(f"arm_{s}", t, (t + dip, low), (off + 0.1, high), (landed + 0.1, low))
        t = landed + 0.12
    end = t + 0.65
    scene.move(f"foot_{free}", t + 0.15, (end, ground))
    scene.move(f"roll_{free}", t + 0.15, (end, 0.12), (end + 0.12, 0.0))
    scene.move("crouch", t, (end, 0.0))
    scene.move("spine", t, (end, [0, 0, 0]))
    for s in SIDES:
        scene.relax(s, end + 0.3)
    return stand_evenly(scene, end)


@action(
    "whole",
    Entry(
        lambda d: {"count": d.count(2, 5), "speed": d.uniform(0.9, 1.15)},
        (
            "<do> {some:jumping jack}",
            "<do> jumping jacks",
            "<perform> {some:jumping jack}",
            "<do> jumping jacks {reps}",
            "<perform> jumping jacks",
            "<do> some jumping jacks",
            "<jump> with {poss} arms and legs spreading out and in {reps}",
        ),
        arms="<raise> both arms to the sides and above the head",
        legs="<jump> with the legs apart and together",
        weight=1.5,
    ),
    Probe(
        "hands",
        {"hand.speed": above(5), "stance_range": above(0.25), "hand.top": above(0.6), "flights": above(1)},
        count="hand.tops",
    ),
)
def jumping_jacks(scene: Scene, t: float, *, count: Count = 4, speed: Speed = 1.0) -> float:
    """Jump the legs apart with the arms overhead, and back together, `count` times."""
    for i in range(2 * count):
        wide = i % 2 == 0
        dip, push = 0.16 / speed, 0.14
        off = t + dip + push
        goals: dict[Side, Floats] = {}
        for s in SIDES:
            home = scene.foot(s)
            shift = SIGN[s] * (0.17 if wide else -0.17)
            goals[s] = np.array([*scene.local(0, shift, origin=home), BALL_HEIGHT, home[3]])
        landed = _fly(scene, off, scene.vary(0.07, 0.06), goals, tuck=0.0)
        scene.move("crouch", t, (t + dip, 0.08), (off, 0.0), (landed, 0.03), (landed + 0.12, 0.055))
        for s in SIDES:
            scene.move(f"roll_{s}", t + 0.6 * dip, *_toes(off, landed, 30))
            over, out = aim(0.05, 0.35, 0.93, 0.95, 0.4), aim(0.1, 1, 0.05, 0.93)
            begin = t + 0.25 * dip
            halfway = 0.5 * (begin + landed)
            scene.move(f"arm_{s}", begin, (halfway, out), (landed, over if wide else scene.rest[s]))
        t = landed + 0.08
    scene.move("crouch", t, (t + 0.4, 0.0))
    return t + 0.4
