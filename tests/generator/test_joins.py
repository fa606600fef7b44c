"""Joins are smooth, keep feet from sliding, and place motion where the one before ended."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.corpus import pose as poses
from generator.corpus.actions import perform
from generator.corpus.joins import concatenate, cut, join, layer, length, place, warp
from generator.corpus.pose import ARM_CHANNELS, Pose
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidOption
from ros_free_stack.skeleton import FPS


def performed(name: str, seed: int = 0, **params: Any) -> Pose:
    scene = Scene(seed=seed)
    perform(scene, name, **params)
    return scene.solve(tail=0.1)


@pytest.fixture(scope="module")
def walk() -> Pose:
    return performed("walk", steps=6)


@pytest.fixture(scope="module")
def wave() -> Pose:
    return performed("wave", seed=1, side="left")


def speeds(pose: Pose) -> np.ndarray:
    return np.linalg.norm(np.diff(poses.joints(pose), axis=0), axis=-1).max(1) * FPS


@settings(deadline=None, max_examples=20)
@given(x=st.floats(-5, 5), y=st.floats(-5, 5), heading=st.floats(-3, 3))
def test_placing_moves_without_deforming(x: float, y: float, heading: float) -> None:
    pose = performed("wave", seed=1, side="left")
    placed = place(pose, np.array([x, y]), heading)
    assert np.allclose(placed["root"][0, :2], [x, y])
    assert np.isclose(placed["heading"][0], heading)
    before, after = poses.joints(pose), poses.joints(placed)
    assert np.allclose(before[..., 2], after[..., 2], atol=1e-9)
    assert np.allclose(np.linalg.norm(before[:, :1] - before, axis=-1), np.linalg.norm(after[:, :1] - after, axis=-1))


def test_warp_changes_the_duration_and_keeps_the_ends(walk: Pose) -> None:
    slow = warp(walk, 1.15)
    assert length(slow) == round(length(walk) * 1.15)
    assert np.allclose(slow["root"][[0, -1]], walk["root"][[0, -1]])
    with pytest.raises(InvalidOption, match="factor"):
        warp(walk, 0.0)


def test_a_join_out_of_the_middle_of_a_walk_has_no_jump(walk: Pose, wave: Pose) -> None:
    moving = cut(walk, 0, 40)
    for before, after in ((moving, wave), (wave, cut(walk, 30, length(walk))), (moving, cut(walk, 25, 60))):
        joined, start, stop = join(before, after)
        assert length(joined) == length(before) + length(after) + stop - start
        hard = concatenate(before, place(after, np.zeros(2), 0.0))
        fastest = max(speeds(before).max(), speeds(after).max())
        assert speeds(joined)[start - 1 : stop + 1].max() < 1.6 * fastest + 1.0
        assert speeds(hard).max() > speeds(joined).max()


def test_feet_step_one_after_the_other(wave: Pose) -> None:
    before = performed("squat", seed=5)
    joined, start, stop = join(before, wave)
    moving = {
        side: np.linalg.norm(np.diff(joined[f"foot_{side}"][start - 1 : stop + 1, :2], axis=0), axis=-1) > 2e-3
        for side in ("left", "right")
    }
    both = (moving["left"] & moving["right"]).sum()
    assert both <= 0.4 * len(moving["left"])


def test_layering_takes_the_arms_alone(walk: Pose, wave: Pose) -> None:
    layered = layer(walk, wave, 4, ARM_CHANNELS)
    frame = min(length(wave), length(walk) - 4) // 2 + 4
    assert np.allclose(layered["arm_left"][frame], wave["arm_left"][frame - 4])
    for name in ("root", "foot_left", "foot_right", "spine"):
        assert np.array_equal(layered[name], walk[name])


@settings(deadline=None, max_examples=6)
@given(heading=st.floats(-20, 20), foot=st.integers(-3, 3), elbow=st.integers(-3, 3))
def test_whole_turns_do_not_show_at_a_join(heading: float, foot: int, elbow: int) -> None:
    before, after = performed("wave", seed=1, side="left"), place(performed("nod"), np.zeros(2), heading)
    plain, *_ = join(before, after)
    for side in ("left", "right"):
        after[f"foot_{side}"][:, 3] += 2 * np.pi * foot
        after[f"arm_{side}"][:, 3] += 2 * np.pi * elbow
    wound, *_ = join(before, after)
    assert np.allclose(poses.joints(wound), poses.joints(plain), atol=1e-6)


def test_whole_turns_do_not_show_where_arms_are_layered(walk: Pose, wave: Pose) -> None:
    wound = {**wave, "arm_left": wave["arm_left"] + [0, 0, 0, 6 * np.pi]}
    layered, again = (layer(walk, over, 4, ARM_CHANNELS) for over in (wave, wound))
    assert np.allclose(poses.joints(layered), poses.joints(again), atol=1e-9)


def test_clips_that_head_more_than_half_a_turn_apart_join_without_a_spin() -> None:
    before = performed("turn", angle=270.0)
    for after in (performed("turn", angle=-200.0), place(performed("walk", steps=4), np.zeros(2), -3.0)):
        joined, start, stop = join(before, after)
        bridge = slice(start - 1, stop + 1)
        for name in ("heading", "foot_left", "foot_right"):
            yaw = joined[name][bridge] if name == "heading" else joined[name][bridge, 3]
            assert np.ptp(yaw) < 1.5, name
        assert speeds(joined)[bridge].max() < 8.0
