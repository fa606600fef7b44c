"""Authored actions: each one is sound, and does what its name and parameters say, on the right side."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.signal import find_peaks

from generator.corpus.actions import ACTIONS, perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidOption, UnknownName
from ros_free_stack.skeleton import BONES, FPS, INDEX

Floats = NDArray[np.float64]
LEAD_S = 0.5
OTHER = {"left": "right", "right": "left"}
SIGN = {"left": 1, "right": -1}
CATALOGUE = [
    "wave",
    "raise_arm",
    "clap",
    "point",
    "salute",
    "scratch_head",
    "cross_arms",
    "hands_on_hips",
    "reach",
    "push",
    "swing_arms",
    "circle_arms",
    "flap_arms",
    "drink",
    "wipe",
    "shrug",
    "touch",
    "beckon",
    "shake_hand",
    "bow",
    "bend_forward",
    "lean",
    "twist",
    "sway",
    "look_around",
    "look",
    "nod",
    "shake_head",
    "punch",
    "alternate",
    "throw",
    "stretch",
    "pick_up",
    "sit_down",
    "stand_up",
    "sit_and_stand",
    "squat",
    "crouch",
    "kneel",
    "jump",
    "hop",
    "jumping_jacks",
    "kick",
    "knee_lift",
    "balance",
    "lunge",
    "tiptoes",
    "stand",
    "step",
    "walk",
    "walk_circle",
    "turn",
    "march",
    "jog_in_place",
    "jog",
    "sneak",
    "stomp",
    "dance",
    "lift_arms",
    "eat",
    "brush_teeth",
    "comb_hair",
    "rub_hands",
    "check_watch",
    "phone",
    "pray",
    "cover",
    "hug",
    "flex",
    "wipe_table",
    "stir",
    "chop",
    "hammer",
    "knock",
    "open_door",
    "pour",
    "pull",
    "carry",
    "lift_weights",
    "play_guitar",
    "play_violin",
    "play_drums",
    "play_piano",
    "conduct",
    "bounce_ball",
    "catch",
    "swim",
    "guard",
    "swing_club",
    "swing_racket",
    "circle_hips",
    "bounce",
    "swing_leg",
]


def act(name: str, *, seed: int = 1, tail: float = 0.6, **params: Any) -> Floats:
    """Joints (T, 22, 3) of half a second of standing, the action, and a short rest."""
    scene = Scene(seed)
    scene.time = LEAD_S
    if name == "stand_up":
        perform(scene, "sit_down")
    perform(scene, name, **params)
    return joints(scene.solve(tail))


def at(places: Floats, name: str, axis: int | slice = slice(None)) -> Floats:
    return places[:, INDEX[name]][:, axis]


def facing(places: Floats) -> Floats:
    """(T,) unwrapped heading of the hips."""
    across = at(places, "left_hip") - at(places, "right_hip")
    return np.unwrap(np.arctan2(-across[:, 0], across[:, 1]))


def rise(places: Floats, side: str) -> float:
    """How far a foot gets off the floor, in m."""
    ball = at(places, f"{side}_foot", 2)
    return float(ball.max() - ball[0])


def peaks(signal: Floats, prominence: float) -> int:
    return len(find_peaks(np.round(signal, 3), prominence=prominence, distance=4)[0])


def test_the_catalogue_is_complete():
    assert set(ACTIONS) == set(CATALOGUE)
    assert {action.part for action in ACTIONS.values()} == {"arms", "trunk", "whole", "legs"}


@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", CATALOGUE)
def test_every_action_is_sound(name, seed):
    places = act(name, seed=seed)
    assert np.isfinite(places).all()
    for parent, child in BONES:
        assert np.ptp(np.linalg.norm(places[:, child] - places[:, parent], axis=-1)) < 1e-6
    speed = np.linalg.norm(np.diff(places, axis=0), axis=-1) * FPS
    assert speed.max() < 12.0
    assert speed.max(axis=1)[-3:].max() < 0.6, "it does not end at rest"
    assert places[..., 2].min() > -0.02
    for side in ("left", "right"):
        ball, ankle = at(places, f"{side}_foot"), at(places, f"{side}_ankle")
        planted = (ball[:, 2] < ball[0, 2] + 0.005) & (ankle[:, 2] < ankle[0, 2] + 0.02)
        both = planted[1:] & planted[:-1]
        skate = np.linalg.norm(np.diff(ball[:, :2], axis=0), axis=-1)[both] * FPS
        assert skate.mean() < 0.03, "a planted foot slides"
    first, last = places[0], places[-1]
    assert 0.85 < first[0, 2] < 1.0
    if name != "sit_down":
        assert abs(last[0, 2] - first[0, 2]) < 0.05, "it does not end standing"
        feet = [last[INDEX[f"{side}_foot"], 2] for side in ("left", "right")]
        assert max(feet) < 0.05


@pytest.mark.parametrize("name", [n for n in CATALOGUE if ACTIONS[n].part == "arms"])
def test_arm_actions_leave_the_feet_alone_and_return_the_arms(name):
    places = act(name, tail=1.0)
    for side in ("left", "right"):
        assert np.ptp(at(places, f"{side}_foot"), axis=0).max() < 1e-3
        below = at(places, f"{side}_shoulder", 2) - at(places, f"{side}_wrist", 2)
        assert below[-1] > 0.35


@pytest.mark.parametrize("name", [n for n in CATALOGUE if ACTIONS[n].part == "legs"])
def test_leg_actions_write_no_arm_keys(name):
    scene = Scene(1)
    perform(scene, name)
    assert all(len(scene.tracks[f"{kind}_{side}"].keys) == 1 for kind in ("arm", "pin") for side in ("left", "right"))


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("count", [1, 2, 4])
def test_wave_raises_the_named_hand_and_moves_it_sideways(side, count):
    places = act("wave", side=side, count=count)
    wrist, shoulder = at(places, f"{side}_wrist"), at(places, f"{side}_shoulder")
    up = wrist[:, 2] > shoulder[:, 2] + 0.1
    assert up.sum() > 0.3 * count * FPS
    assert np.all(at(places, f"{OTHER[side]}_wrist", 2) < at(places, f"{OTHER[side]}_shoulder", 2) - 0.2)
    outward = np.where(up, SIGN[side] * (wrist - shoulder)[:, 1], 0.3)
    assert peaks(-outward, 0.08) == count


@pytest.mark.parametrize("name", ["salute", "scratch_head", "drink"])
@pytest.mark.parametrize("side", ["left", "right"])
def test_hands_reach_the_head(name, side):
    places = act(name, side=side)
    near = np.linalg.norm(at(places, f"{side}_wrist") - at(places, "head"), axis=-1)
    assert near.min() < 0.27
    assert np.linalg.norm(at(places, f"{OTHER[side]}_wrist") - at(places, "head"), axis=-1).min() > 0.4


@pytest.mark.parametrize("side", ["left", "right", "both"])
@pytest.mark.parametrize(("to", "axis"), [("up", 2), ("side", 1), ("forward", 0)])
def test_raise_arm_goes_where_it_says(side, to, axis):
    places = act("raise_arm", side=side, to=to)
    for s in ("left", "right"):
        reach = (at(places, f"{s}_wrist") - at(places, f"{s}_shoulder")) * [1, SIGN[s], 1]
        assert (reach[:, axis].max() > 0.4) == (side in (s, "both"))


def test_raise_arm_can_stay_up():
    places = act("raise_arm", side="left", lower=False)
    assert (at(places, "left_wrist", 2) - at(places, "left_shoulder", 2))[-1] > 0.35


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("azimuth", [-50.0, 0.0, 50.0])
def test_point_has_the_asked_azimuth(side, azimuth):
    places = act("point", side=side, azimuth=azimuth, hold=1.5)
    line = at(places, f"{side}_wrist") - at(places, f"{side}_shoulder")
    frame = int(np.argmax(np.linalg.norm(line[:, :2], axis=-1)))
    reached = np.degrees(np.arctan2(line[frame, 1], line[frame, 0]))
    assert abs(reached - azimuth) < 30  # the trunk turns along


def test_clap_brings_the_wrists_together_count_times():
    for height in ("chest", "head"):
        places = act("clap", count=5, height=height)
        apart = np.linalg.norm(at(places, "left_wrist") - at(places, "right_wrist"), axis=-1)
        assert peaks(-apart, 0.08) == 5
        together = int(np.argmin(apart))
        assert (at(places, "left_wrist", 2)[together] > at(places, "head", 2)[together]) == (height == "head")


def test_cross_arms_crosses_and_hands_on_hips_reaches_the_hips():
    places = act("cross_arms")
    assert np.min(at(places, "left_wrist", 1) - at(places, "right_wrist", 1)) < -0.1
    places = act("hands_on_hips")
    for side in ("left", "right"):
        assert np.linalg.norm(at(places, f"{side}_wrist") - at(places, f"{side}_hip"), axis=-1).min() < 0.24
        elbow_out = SIGN[side] * (at(places, f"{side}_elbow", 1) - at(places, f"{side}_wrist", 1))
        assert elbow_out.max() > 0.08


@pytest.mark.parametrize("side", ["left", "right"])
def test_punch_throw_and_push_stretch_the_named_arm_forward(side):
    for name, share in (("punch", 0.37), ("throw", 0.3), ("push", 0.4), ("reach", 0.4), ("shake_hand", 0.3)):
        places = act(name, side=side)
        reach = [np.max(at(places, f"{s}_wrist", 0) - at(places, f"{s}_shoulder", 0)) for s in (side, OTHER[side])]
        assert reach[0] > share, name
        if name != "throw":  # the other arm points ahead while winding up
            assert reach[1] < 0.35, name


def test_alternate_punches_with_both_hands_in_turn():
    places = act("alternate", count=4)
    hits = {
        s: find_peaks(at(places, f"{s}_wrist", 0) - at(places, f"{s}_shoulder", 0), height=0.4, distance=4)[0]
        for s in SIGN
    }
    assert {len(frames) for frames in hits.values()} == {2}
    order = sorted((frame, side) for side, frames in hits.items() for frame in frames)
    assert all(a[1] != b[1] for a, b in pairwise(order))


@pytest.mark.parametrize(
    ("direction", "axis", "sign"), [("left", 1, 1), ("right", 1, -1), ("forward", 0, 1), ("back", 0, -1)]
)
def test_lean_goes_where_it_says(direction, axis, sign):
    places = act("lean", direction=direction)
    lean = at(places, "neck") - at(places, "pelvis")
    assert np.max(sign * (lean - lean[0])[:, axis]) > 0.12


@pytest.mark.parametrize(("direction", "sign"), [("left", 1), ("right", -1)])
def test_look_turns_the_head(direction, sign):
    places = act("look", direction=direction)
    skull = at(places, "head") - at(places, "neck")
    assert np.max(sign * skull[:, 1]) > np.max(-sign * skull[:, 1]) + 0.008


def test_nod_lowers_the_head_count_times():
    places = act("nod", count=3, seed=2)
    drop = at(places, "head", 2) - at(places, "neck", 2)
    assert peaks(-drop, 0.01) == 3


def test_bow_and_bend_forward_lower_the_head():
    bow, bend = (np.min(at(act(name), "head", 2)) for name in ("bow", "bend_forward"))
    assert bend < bow - 0.2
    assert bow < 1.5


@pytest.mark.parametrize(
    ("direction", "axis", "sign"), [("forward", 0, 1), ("backward", 0, -1), ("left", 1, 1), ("right", 1, -1)]
)
@pytest.mark.parametrize("name", ["walk", "step"])
def test_walk_and_step_displace_in_their_direction(name, direction, axis, sign):
    places = act(name, direction=direction)
    way = places[-1, 0] - places[0, 0]
    assert sign * way[axis] > (0.6 if name == "walk" else 0.25)
    assert abs(way[1 - axis]) < 0.2
    assert abs(np.degrees(facing(places)[-1] - facing(places)[0])) < 12


@pytest.mark.parametrize("side", ["left", "right"])
def test_diagonal_step_goes_forward_and_aside(side):
    way = np.diff(act("step", direction=f"diagonal_{side}")[[0, -1], 0], axis=0)[0]
    assert way[0] > 0.2
    assert SIGN[side] * way[1] > 0.15


@pytest.mark.parametrize("angle", [90.0, -90.0, 180.0, -45.0])
def test_turn_ends_at_its_angle(angle):
    turned = np.degrees(np.diff(facing(act("turn", angle=angle))[[0, -1]]))[0]
    assert abs(turned - angle) < 10


@pytest.mark.parametrize("name", ["walk", "jog"])
@pytest.mark.parametrize("curve", [80.0, -80.0])
def test_curved_walk_turns(name, curve):
    places = act(name, steps=8, curve=curve)
    assert abs(np.degrees(np.diff(facing(places)[[0, -1]]))[0] - curve) < 10
    assert np.sign(places[-1, 0, 1] - places[0, 0, 1]) == np.sign(curve)


@pytest.mark.parametrize(("direction", "sign"), [("left", 1), ("right", -1)])
def test_walk_circle_comes_back_having_turned_once(direction, sign):
    places = act("walk_circle", direction=direction, steps=12)
    assert abs(np.degrees(np.diff(facing(places)[[0, -1]]))[0] - sign * 360) < 12
    far = np.linalg.norm(places[:, 0, :2] - places[0, 0, :2], axis=-1)
    assert far.max() > 1.5
    assert far[-1] < 0.45 * far.max()


def test_speed_is_quicker():
    for name in ("walk", "wave", "squat", "jog"):
        assert len(act(name, speed=1.35)) < len(act(name, speed=0.7))


@pytest.mark.parametrize("name", ["jump", "hop", "jumping_jacks", "jog"])
def test_flights_have_both_feet_in_the_air(name):
    places = act(name)
    lowest = np.minimum(at(places, "left_foot", 2), at(places, "right_foot", 2))
    assert lowest.max() > lowest[0] + 0.02


@pytest.mark.parametrize("distance", [0.5, 0.0, -0.3])
def test_jump_goes_its_distance_and_height(distance):
    places = act("jump", distance=distance, height=0.3)
    assert places[-1, 0, 0] - places[0, 0, 0] == pytest.approx(distance, abs=0.08)
    assert at(places, "pelvis", 2).max() > places[0, 0, 2] + 0.2


@pytest.mark.parametrize("side", ["left", "right"])
def test_one_legged_actions_lift_the_right_foot(side):
    for name, lifted in (("kick", side), ("knee_lift", side), ("stomp", side), ("balance", OTHER[side])):
        places = act(name, side=side)
        assert rise(places, lifted) > 0.15, name
        assert rise(places, OTHER[lifted]) < 0.01, name
    places = act("hop", side=side)
    assert at(places, f"{OTHER[side]}_foot", 2)[len(places) // 2] > 0.15
    assert 0.02 < rise(places, side) < 0.2


@pytest.mark.parametrize(("direction", "axis"), [("forward", 0), ("side", 1)])
def test_kick_height_and_direction(direction, axis):
    tops = []
    for height in ("low", "middle", "high"):
        places = act("kick", side="left", height=height, direction=direction)
        foot = at(places, "left_foot")
        tops.append(foot[:, 2].max())
        out = (foot - foot[0])[int(np.argmax(np.abs(foot - foot[0])[:, axis]))]
        assert out[axis] > 0.3
        assert out[axis] > 2 * abs(out[1 - axis])
    assert tops == sorted(tops)
    assert tops[2] > tops[0] + 0.3


@pytest.mark.parametrize("side", ["left", "right"])
def test_kneel_brings_the_named_knee_to_the_floor(side):
    places = act("kneel", side=side)
    assert at(places, f"{side}_knee", 2).min() < 0.12
    assert at(places, f"{OTHER[side]}_knee", 2).min() > 0.3


@pytest.mark.parametrize("side", ["left", "right"])
def test_lunge_steps_out_with_the_named_foot(side):
    places = act("lunge", side=side, count=2)
    lead = at(places, f"{side}_foot", 0) - at(places, f"{OTHER[side]}_foot", 0)
    assert lead.max() > 0.5
    assert peaks(lead, 0.3) == 2


@pytest.mark.parametrize("side", ["left", "right", "both"])
def test_pick_up_reaches_the_floor_with_the_named_hand(side):
    places = act("pick_up", side=side)
    for s in SIGN:
        assert (at(places, f"{s}_wrist", 2).min() < 0.15) == (side in (s, "both"))


def test_sitting_down_and_standing_up():
    scene = Scene(1)
    perform(scene, "sit_down", height=0.45)
    assert not scene.standing
    scene.time += 0.5
    seated = joints(scene.solve())[-1]
    assert seated[0, 2] == pytest.approx(0.45 + 0.09, abs=0.05)
    assert seated[0, 0] < -0.15
    assert abs(seated[INDEX["left_knee"], 2] - seated[INDEX["left_hip"], 2]) < 0.15
    with pytest.raises(InvalidOption, match="stand_up must come first"):
        perform(scene, "walk")
    perform(scene, "wave")
    perform(scene, "stand_up")
    assert scene.standing
    assert joints(scene.solve(0.5))[-1, 0, 2] > 0.88


def test_counts_of_whole_body_actions():
    assert peaks(-at(act("squat", count=3), "pelvis", 2), 0.15) == 3
    assert peaks(at(act("jump", count=2), "left_foot", 2), 0.15) == 2
    assert peaks(at(act("knee_lift", side="left", count=3), "left_knee", 2), 0.15) == 3
    places = act("jumping_jacks", count=3)
    assert peaks(at(places, "left_foot", 1) - at(places, "right_foot", 1), 0.2) == 3
    places = act("march", count=6)
    assert sum(peaks(at(places, f"{s}_foot", 2), 0.1) for s in SIGN) == 6


def test_bad_input_is_refused_with_the_valid_choices():
    scene = Scene(0)
    with pytest.raises(UnknownName, match=r"moonwalk.*valid: .*walk"):
        perform(scene, "moonwalk")
    with pytest.raises(UnknownName, match=r"side of wave.*both, left, right"):
        perform(scene, "wave", side="up")
    with pytest.raises(InvalidOption, match="no such parameter; valid: count, side, size, speed"):
        perform(scene, "wave", colour=3)
    bad: tuple[dict[str, Any], ...] = (
        {"count": 0},
        {"count": 2.5},
        {"count": True},
        {"speed": float("nan")},
        {"speed": "fast"},
    )
    for params in bad:
        with pytest.raises(InvalidOption, match="expected a"):
            perform(scene, "wave", **params)
    with pytest.raises(InvalidOption, match="True or False"):
        perform(scene, "raise_arm", lower=1)
    with pytest.raises(InvalidOption, match="stands already"):
        perform(scene, "stand_up")
    assert scene.time == 0.0


@pytest.mark.parametrize(("aside", "angle"), [(0.4, 0.0), (-0.3, 0.0), (0.0, 90.0), (0.0, -180.0)])
def test_a_jump_goes_aside_and_turns_as_told(aside: float, angle: float) -> None:
    scene = Scene(seed=2)
    perform(scene, "jump", aside=aside, angle=angle)
    pose = scene.solve()
    assert np.degrees(pose["heading"][-1]) == pytest.approx(angle, abs=5)
    moved = pose["root"][-1, 1] - pose["root"][0, 1]
    assert angle or moved == pytest.approx(aside, abs=0.08)
    feet = [pose[f"foot_{side}"] for side in ("left", "right")]
    assert np.linalg.norm((feet[0] - feet[1])[-1, :2]) == pytest.approx(np.linalg.norm((feet[0] - feet[1])[0, :2]))


def test_hops_forward_travel_on_one_leg() -> None:
    scene = Scene(seed=2)
    perform(scene, "hop", side="left", count=3, distance=0.3)
    left = scene.solve()["foot_left"]
    assert left[-1, 0] - left[0, 0] == pytest.approx(0.9, abs=0.05)
