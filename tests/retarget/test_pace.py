"""Pace of a walk, and footholds that a robot with flat feet can use."""

import numpy as np
import pytest

from retarget.clip.human import align
from retarget.plan.footsteps import FootPath, hand_overs, prolong_double_support, spread_footholds
from retarget.plan.pace import swings, walking_pace
from ros_free_stack.messages import HumanMotion

CORNERS = np.array([[-0.04, -0.03, 0.0], [-0.04, 0.03, 0.0], [0.08, -0.03, 0.0], [0.08, 0.03, 0.0]])


def pace_of(motion: HumanMotion, *, leg_speed: float = 20.0, scale: float = 0.9):
    return walking_pace(align(motion), 0.7, leg_speed=leg_speed, scale=scale)


@pytest.mark.parametrize("name", ["stand", "wave", "squat"])
def test_feet_that_stay_down_are_not_slowed(motions, name):
    assert pace_of(motions[name]).slowdown == pytest.approx(1.0)


def test_quicker_steps_are_slowed_more_and_none_is_lost(motions):
    steps = motions["steps"]
    quick = HumanMotion(steps.joints[::2], steps.fps)
    assert pace_of(quick).slowdown > pace_of(steps).slowdown >= 1.0
    pace = pace_of(quick)
    assert (np.diff(pace.human_s) > 0).all() and (np.diff(pace.robot_s) > 0).all()
    assert pace.human_s[-1] == pytest.approx(align(quick).duration_s)


def test_slow_joints_slow_the_swings(motions):
    assert pace_of(motions["steps"], leg_speed=3.0).slowdown > 1.05 * pace_of(motions["steps"]).slowdown


def test_every_step_is_a_swing_of_its_length(motions):
    lengths = sorted(swing.step for swing in swings(align(motions["steps"])))
    assert lengths == pytest.approx([0.15, 0.15, 0.3, 0.3], abs=0.03)


def test_double_support_grows_to_what_is_wanted():
    contacts = np.ones((60, 2), dtype=bool)
    contacts[10:29, 0] = False
    contacts[31:50, 1] = False
    (change,) = hand_overs(contacts, 50.0)
    assert (change.to, change.off, change.landed, change.lifted) == (0, 1, 29, 31)
    longer = prolong_double_support(contacts, 50.0, wanted_s=0.12)
    assert longer[27:33].all() and not longer[26].all() and not longer[33].all()
    capped = prolong_double_support(contacts, 50.0, wanted_s=1.0)
    assert (~capped).sum() > 0.6 * (~contacts).sum()


def test_a_foot_that_would_land_on_the_other_lands_beside_it():
    frames = 40
    contact = np.ones((frames, 2), dtype=bool)
    contact[10:20, 0] = False
    ankles = [np.tile([0.0, 0.1, 0.05], (frames, 1)), np.tile([0.0, -0.1, 0.05], (frames, 1))]
    ankles[0][20:, 1] = -0.05
    paths = [FootPath(ankles[i], np.zeros(frames), np.zeros(frames), contact[:, i]) for i in range(2)]
    left, right = spread_footholds(paths, [CORNERS, CORNERS], gap=0.02)
    assert left.ankle[20:, 1] == pytest.approx(-0.1 + 0.06 + 0.02)
    assert (left.ankle[:10] == ankles[0][:10]).all() and (right.ankle == ankles[1]).all()
    # The swing comes to the foothold that was moved, without a leap at its end.
    assert np.abs(np.diff((left.ankle - ankles[0])[9:22, 1])).max() < 0.03
