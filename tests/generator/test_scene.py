"""A scene's solution: planted feet, balance, reproducibility."""

import numpy as np
import pytest

from generator.corpus.actions import perform
from generator.corpus.balance import centre_of_mass_path, soft_minimum
from generator.corpus.pose import centre_of_mass, joints
from generator.corpus.scene import Scene
from ros_free_stack.skeleton import INDEX


def test_length_and_start_of_the_solution():
    scene = Scene(0)
    end = perform(scene, "wave")
    assert scene.time == end
    assert len(scene.solve(0.5)["root"]) == pytest.approx(20 * (end + 0.5), abs=1.01)
    assert abs(scene.solve()["heading"][0]) < 1e-6


def test_same_seed_same_bytes_and_solve_does_not_change_the_scene():
    def make(seed: int) -> Scene:
        scene = Scene(seed)
        perform(scene, "walk", steps=4)
        return scene

    scene = make(5)
    first = joints(scene.solve())
    np.testing.assert_array_equal(first, joints(scene.solve()))
    np.testing.assert_array_equal(first, joints(make(5).solve()))
    other = joints(make(6).solve())
    assert first.shape != other.shape or not np.allclose(first, other)


@pytest.mark.parametrize("seed", range(4))
def test_standing_person_is_balanced_and_still_on_the_feet(seed):
    scene = Scene(seed)
    scene.time = 4.0
    places = joints(scene.solve())
    feet = places[:, [INDEX["left_foot"], INDEX["right_foot"]]]
    assert np.ptp(feet, axis=0).max() < 1e-3
    ankles = places[:, [INDEX["left_ankle"], INDEX["right_ankle"]]]
    middle = 0.5 * (feet.mean(axis=1) + ankles.mean(axis=1))[:, :2]
    assert np.linalg.norm(centre_of_mass(places)[:, :2] - middle, axis=-1).max() < 0.1


def test_the_body_leans_over_the_stance_foot_before_a_foot_lifts():
    scene = Scene(3)
    scene.time = 1.0
    perform(scene, "knee_lift", side="right")
    places = joints(scene.solve())
    lifted = np.argmax(places[:, INDEX["right_ankle"], 2] > places[0, INDEX["right_ankle"], 2] + 0.05)
    stance, swing = places[lifted, INDEX["left_ankle"], 1], places[0, INDEX["right_ankle"], 1]
    shifted = (centre_of_mass(places)[lifted, 1] - swing) / (stance - swing)
    assert shifted > 0.7


def test_pendulum_path_keeps_a_still_point_and_leads_a_step():
    still = np.full((200, 2), 0.3)
    np.testing.assert_allclose(centre_of_mass_path(still, 60.0), still)
    jump = np.where(np.arange(400) < 200, 0.0, 1.0)[:, None] * [1.0, 0.0]
    path = centre_of_mass_path(jump, 60.0)[:, 0]
    assert np.all(np.diff(path) >= -1e-12)
    assert 0.1 < path[190] < 0.45
    assert path[0] < 1e-3


def test_pendulum_path_solves_its_equation():
    t = np.arange(0, 10, 1 / 200)
    pressure = np.stack([0.1 * np.sin(2 * t), 0 * t], -1)
    path = centre_of_mass_path(pressure, 200.0)[:, 0]
    acceleration = np.gradient(np.gradient(path, t), t)
    inner = slice(500, -500)
    np.testing.assert_allclose((path - 0.95 / 9.81 * acceleration)[inner], pressure[inner, 0], atol=2e-3)


def test_soft_minimum_lies_just_below_the_minimum():
    values = np.array([[0.3, 1.0], [0.5, 0.2]])
    low = soft_minimum(values)
    assert np.all(low <= [0.3, 0.2])
    assert np.all(low > [0.28, 0.18])


def test_arms_layered_over_legs_leave_the_feet_alone():
    plain, layered = Scene(8), Scene(8)
    perform(plain, "march", count=4)
    perform(layered, "march", count=4, advance=False)
    perform(layered, "wave", start=0.5, side="left", advance=False)
    layered.time = plain.time
    for side in ("left", "right"):
        np.testing.assert_array_equal(plain.solve()[f"foot_{side}"], layered.solve()[f"foot_{side}"])
    wrist, shoulder = (joints(layered.solve())[:, INDEX[f"left_{n}"], 2] for n in ("wrist", "shoulder"))
    assert np.max(wrist - shoulder) > 0.1
