"""Authored actions: each one is sound, and does what its name and parameters say, on the right side."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.signal import find_peaks

from generator.corpus.actions import ACTIONS, perform
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidOption, UnknownName
from ros_free_stack.skeleton import BONES, FPS, INDEX
from tests.generator.action_cases import CATALOGUE, OTHER, SIGN, act, at, peaks


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
