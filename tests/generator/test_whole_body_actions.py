"""What actions of the whole body do: walks, turns, jumps, kicks, lunges, sitting."""

import numpy as np
import pytest

from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidOption
from ros_free_stack.skeleton import INDEX
from tests.generator.action_cases import OTHER, SIGN, act, at, facing, peaks, rise


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
