"""Going down and coming up: squats, sitting, kneeling, picking up, and stances on one leg or on the toes."""

from typing import Annotated, Literal

import numpy as np

from generator.data.actions.registry import AnySide, Count, Hold, Range, Size, Speed, action, sides
from generator.data.actions.support import on_one_leg, share, stand_evenly
from generator.data.body import BALL_HEIGHT, OTHER, SIDES, SIGN, STANDING_HEIGHT, Side, aim, hand_at
from generator.data.scene import Scene

SeatHeight = Annotated[float, Range(0.3, 0.7)]
_ZERO = (0.0, 0.0, 0.0)
_LAP = hand_at(0.36, 0.12, -0.40, 0.1)


def _lower(scene: Scene, t: float, depth: float, lean: float, span: float) -> None:
    """Bring the pelvis to `depth` metres below standing, the trunk leaning forward by degrees."""
    scene.move("crouch", t, (t + span, depth))
    scene.move("pelvis", t, (t + 0.9 * span, [0, 0.6 * lean, 0]))
    scene.move("spine", t, (t + span, [0, 0.4 * lean, 0]))


@action("whole")
def squat(scene: Scene, t: float, *, count: Count = 1, depth: Size = 1.0, speed: Speed = 1.0) -> float:
    """Knee bends with the arms stretched forward."""
    front = aim(1, 0.12, -0.05, 0.94)
    for i in range(count):
        span, stay, pause = scene.vary(0.85) / speed, scene.vary(0.14), scene.vary(0.1)
        bottom, end = t + span, t + 2 * span + stay
        _lower(scene, t, scene.vary(min(0.34 * depth, 0.48), 0.05), 44 * depth**0.7, span)
        _lower(scene, bottom + stay, 0.0, 0.0, span)
        scene.move("offset", t, (bottom, [0.015, 0]), (end, [0, 0]))
        for s in SIDES:
            rest = scene.rest[s] if i == count - 1 else 0.7 * scene.rest[s] + 0.3 * front
            scene.move(f"arm_{s}", t, (bottom - 0.05 * span, front), (bottom + stay, front), (end, rest))
        t = end + pause
    return t


@action("whole")
def crouch(scene: Scene, t: float, *, hold: Hold = 1.0, depth: Size = 1.0, speed: Speed = 1.0) -> float:
    """Go down low, stay there with the hands on the knees, and rise."""
    span = scene.vary(1.0) / speed
    bottom = t + span + hold
    _lower(scene, t, min(0.36 * depth, 0.46), 58 * depth**0.5, span)
    _lower(scene, bottom, 0.0, 0.0, span)
    for s in SIDES:
        low = aim(0.80, 0.02, -0.60, 0.78)
        scene.move(f"arm_{s}", t, (t + span, low), (bottom, low), (bottom + span, scene.rest[s]))
    return bottom + 1.05 * span


@action("whole")
def pick_up(
    scene: Scene, t: float, *, side: AnySide = "right", place: Literal["up", "none"] = "up", speed: Speed = 1.0
) -> float:
    """Take something from the floor in front and lift it to the chest ("up"), or only touch the floor ("none")."""
    span = scene.vary(1.15) / speed
    bottom, top = t + span + 0.28, t + 2 * span + 0.28
    end = top + 1.4 if place == "up" else top + 0.1 * span
    _lower(scene, t, 0.37, 88, span)
    twist = 0.0 if side == "both" else -12 * SIGN[side]
    scene.tracks["spine"].key(t + span, [0, 44, -twist], 0.0)
    _lower(scene, bottom, 0.0, 0.0, span)
    scene.move("gaze", t, (t + 0.4 * span, [0, 40]), (bottom + 0.9 * span, [0, 10]), (end, [0, 0]))
    if side != "both":
        knee = aim(0.60, 0.05, -0.80, 0.66)
        scene.move(f"arm_{OTHER[side]}", t, (t + span, knee), (bottom, knee), (top, scene.rest[OTHER[side]]))
    for s in sides(side):
        floor = scene.local(0.25, 0.10 * SIGN[s])
        scene.move(
            f"pin_{s}", t + 0.4 * span, (t + 0.45 * span, [*floor, 0.10, 0]), (t + span, [*floor, 0.09, 1]),
            (bottom, [*floor, 0.09, 1]), (bottom + 0.5 * span, [*floor, 0.10, 0]),
        )  # fmt: skip
        low, chest = aim(0.5, 0, -0.87, 0.97), hand_at(0.32, 0.06, -0.22)
        lifted = [(top, chest), (top + 0.6, chest)] if place == "up" else []
        scene.move(f"arm_{s}", t, (t + span, low), (bottom, low), *lifted, (end, scene.rest[s]))
        scene.move(f"roll_{s}", t, (t + span, 0.35), (bottom, 0.35), (bottom + 0.7 * span, 0.0))
    return end


@action("whole")
def sit_down(scene: Scene, t: float, *, height: SeatHeight = 0.46, speed: Speed = 1.0) -> float:
    """Sit down on a seat behind, hands on the thighs, and stay seated."""
    span = scene.vary(1.3) / speed
    drop = STANDING_HEIGHT - height - 0.16  # the hips go back, which lowers the legs' reach
    scene.move("crouch", t, (t + 0.5 * span, 0.45 * drop), (t + span, drop))
    scene.move("offset", t, (t + 0.35 * span, [0, 0]), (t + span, [-0.27, 0]))
    scene.move("pelvis", t, (t + 0.5 * span, [0, 26, 0]), (t + span, [0, 8, 0]), (t + 1.35 * span, [0, -8, 0]))
    scene.move("spine", t, (t + 0.5 * span, [0, 22, 0]), (t + span, [0, 20, 0]), (t + 1.4 * span, [0, 12, 0]))
    for s in SIDES:
        scene.move(f"arm_{s}", t, (t + 0.6 * span, aim(0.6, 0.15, -0.8, 0.85)), (t + 1.25 * span, _LAP))
    scene.rest = dict.fromkeys(SIDES, _LAP)
    scene.standing = False
    return t + 1.4 * span


@action("whole")
def stand_up(scene: Scene, t: float, *, speed: Speed = 1.0) -> float:
    """Rise from a seat: lean forward, over the feet, and up."""
    span = scene.vary(1.35) / speed
    low = scene.tracks["crouch"].last[0]
    scene.rest = scene.hanging
    scene.move("spine", t, (t + 0.38 * span, [0, 26, 0]), (t + 1.08 * span, _ZERO))
    scene.move("pelvis", t, (t + 0.42 * span, [0, 30, 0]), (t + span, _ZERO))
    scene.move("crouch", t, (t + 0.30 * span, low), (t + span, 0.0))
    scene.move("offset", t, (t + 0.25 * span, [-0.24, 0]), (t + 0.62 * span, [0.01, 0]), (t + span, [0, 0]))
    for s in SIDES:
        scene.move(f"arm_{s}", t, (t + 0.5 * span, hand_at(0.42, 0.10, -0.36, 0.1)), (t + 1.15 * span, scene.rest[s]))
    scene.standing = True
    return t + 1.15 * span


@action("whole")
def sit_and_stand(scene: Scene, t: float, *, height: SeatHeight = 0.46, hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Sit down, stay for a while and stand up again."""
    seated = sit_down(scene, t, height=height, speed=speed)
    return stand_up(scene, seated + hold, speed=speed)


@action("whole")
def kneel(scene: Scene, t: float, *, side: Side = "right", hold: Hold = 1.0, speed: Speed = 1.0) -> float:
    """Step back with one foot, go down on that knee, stay, and come up again."""
    other, home = OTHER[side], scene.foot(side)
    span, drop = scene.vary(1.15) / speed, 0.44
    t = on_one_leg(scene, t, other)
    landed = t + 0.55 / speed
    scene.swing_foot(side, t, landed, scene.local(-0.62, 0, origin=home), home[3], toe_off=20, strike=32)
    scene.tracks[f"roll_{side}"].key(landed + 0.12, np.radians(40))
    stand_evenly(scene, landed, 0.6 * span)
    down, leave = landed + span, landed + span + hold
    up = leave + span
    _lower(scene, landed, drop, 10, span)
    scene.move(f"roll_{side}", landed + 0.12, (down, np.radians(72)), (leave, np.radians(72)), (up, np.radians(35)))
    _lower(scene, leave, 0.0, 0.0, span)
    for s in SIDES:
        thigh = hand_at(0.34, 0.14, -0.42) if s == other else aim(0.35, 0.12, -0.85, 0.9)
        scene.move(f"arm_{s}", landed, (down, thigh), (leave, thigh), (up, scene.rest[s]))
    scene.tracks["weight"].hold(leave + 0.3 * span)
    scene.tracks["weight"].key(up, share(other))
    scene.swing_foot(side, up, up + 0.6 / speed, home[:2], home[3], toe_off=35, strike=-4)
    return stand_evenly(scene, up + 0.6 / speed)


@action("whole")
def lunge(scene: Scene, t: float, *, side: Side = "right", count: Count = 1, speed: Speed = 1.0) -> float:
    """Step far out in front with one foot, dip, and push back."""
    other = OTHER[side]
    for _ in range(count):
        t = on_one_leg(scene, t, other)
        home, out, down = scene.foot(side), scene.vary(0.6) / speed, scene.vary(0.6) / speed
        landed, bottom = t + out, t + out + down
        up = bottom + 0.2 + down
        scene.swing_foot(side, t, landed, scene.local(scene.vary(0.70, 0.05), 0, origin=home), home[3], strike=-15)
        stand_evenly(scene, landed - 0.1, 0.4)
        scene.move(f"roll_{other}", t, (landed, 0.4), (bottom, 0.95), (bottom + 0.2, 0.95), (up + 0.5 * out, 0.0))
        _lower(scene, landed, 0.26, 8, down)
        _lower(scene, bottom + 0.2, 0.0, 0.0, down)
        scene.tracks["weight"].hold(bottom + 0.2)
        scene.tracks["weight"].key(up, share(other))
        scene.swing_foot(side, up, up + out, home[:2], home[3], toe_off=5, strike=4)
        t = stand_evenly(scene, up + out)
    return t


@action("whole")
def balance(scene: Scene, t: float, *, side: Side = "left", hold: Hold = 2.5, speed: Speed = 1.0) -> float:
    """Stand on one leg (`side`), the other one lifted and the arms spread."""
    free = OTHER[side]
    home, lift = scene.foot(free), on_one_leg(scene, t, side, 0.55)
    high = lift + 0.9 / speed
    end = high + hold
    raised = np.array([*scene.local(0.12, 0.02 * SIGN[side], origin=home), BALL_HEIGHT + scene.vary(0.22), home[3]])
    spread = aim(0.15, 1, -0.12, 0.95)
    beats = [high + i * 0.45 for i in range(1, int(hold / 0.45))]
    unrest = np.array([0.018, 0.018, 0.012, 0.04])
    wobble = [(x, raised + unrest * [scene.normal() for _ in range(4)]) for x in beats]
    scene.move(f"foot_{free}", lift, (high, raised), *wobble, (end, raised), (end + 0.8, home))
    scene.move(
        f"roll_{free}", lift - 0.1, *((x, np.radians(a)) for x, a in (
            (lift + 0.25, 24), (high, 22), (end, 22), (end + 0.7, 10), (end + 0.95, 0))),
    )  # fmt: skip
    hip = [-3 * SIGN[side], 0, 0]
    scene.move("pelvis", t, (high, hip), (end, hip), (end + 1, _ZERO))
    for s in SIDES:
        sway = [(x, spread + np.array([0, 0.06 * scene.normal(), 0, 0])) for x in beats]
        scene.move(f"arm_{s}", t, (lift + 0.7, spread), *sway, (end, spread), (end + 1, scene.rest[s]))
    return stand_evenly(scene, end + 0.8, 0.6)


@action("whole")
def tiptoes(scene: Scene, t: float, *, hold: Hold = 1.0, count: Count = 1, speed: Speed = 1.0) -> float:
    """Rise on the toes, stay, and sink back, `count` times."""
    for _ in range(count):
        shift, up = scene.vary(0.5) / speed, scene.vary(0.6) / speed
        high, end = t + shift + up + hold, t + shift + 2 * up + hold
        scene.move("offset", t, (t + shift + 0.2 * up, [0.062, 0]), (high, [0.062, 0]), (end + 0.15, [0, 0]))
        for s in SIDES:
            angle = np.radians(scene.vary(36, 0.04))
            scene.move(f"roll_{s}", t + shift, (t + shift + up, angle), (high, angle), (end, 0.0))
        t = end + 0.15
    return t


@action("whole")
def stretch(scene: Scene, t: float, *, speed: Speed = 1.0) -> float:
    """Stretch both arms overhead and lean to one side and to the other."""
    span = scene.vary(1.5) / speed
    top = t + span + 0.5
    first = 1 if scene.rng.random() < 0.5 else -1
    spine, pelvis, now = [(t + span, [0, -10, 0]), (top, [0, -10, 0])], [(top, _ZERO)], top
    for side in (first, -first):
        spine += [(now + 0.9, [-24 * side, -4, 5 * side]), (now + 1.5, [-20 * side, -4, 4 * side])]
        pelvis += [(now + 0.9, [-5 * side, 0, 0])]
        now += 1.5
    end = now + 0.95 * span
    scene.move("spine", t, *spine, (now + 0.8, _ZERO))
    scene.move("pelvis", t, *pelvis, (now + 0.8, _ZERO))
    scene.move("gaze", t, (t + span, [0, -25]), (now, [0, -15]), (now + 0.8, [0, 0]))
    for s in SIDES:
        scene.move(
            f"arm_{s}", t, (t + 0.5 * span, aim(0.8, 0.35, 0.1, 0.8, 0.3)), (t + span, aim(0, 0.12, 0.99, 0.985, 0.6)),
            (top, aim(-0.05, 0.10, 0.99, 0.99, 0.6)), (now, aim(-0.05, 0.10, 0.99, 0.99, 0.6)),
            (now + 0.5 * span, aim(0.4, 0.9, 0, 0.93, 0.1)), (end, scene.rest[s]),
        )  # fmt: skip
    return end
