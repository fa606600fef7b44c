"""Coherence against values worked out by hand."""

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_free_stack import coherence
from ros_free_stack.skeleton import INDEX, JOINT_COUNT, MIRRORED, PARTS


def skeleton() -> np.ndarray:
    """A standing body of 22 joints with legs of 0.8 m."""
    rng = np.random.default_rng(0)
    pose = rng.uniform(-0.1, 0.1, (JOINT_COUNT, 3)) + np.array([0, 0, 1.0])
    for side, y in (("left", 0.1), ("right", -0.1)):
        pose[INDEX[f"{side}_hip"]] = 0, y, 0.9
        pose[INDEX[f"{side}_knee"]] = 0, y, 0.5
        pose[INDEX[f"{side}_ankle"]] = 0, y, 0.1
    return pose


def moving(speeds: np.ndarray) -> np.ndarray:
    """(T+1, 22, 3) motion in which part p moves along x by speeds[t, p] at each step."""
    joints = np.tile(skeleton(), (len(speeds) + 1, 1, 1))
    for place, part in enumerate(PARTS.values()):
        joints[1:, list(part), 0] += np.cumsum(speeds[:, place])[:, None]
    return joints


def test_part_speeds_are_root_mean_squares():
    joints = np.zeros((2, JOINT_COUNT, 3))
    shoulder, wrist = INDEX["left_shoulder"], INDEX["left_wrist"]
    joints[1, shoulder] = [3, 0, 0]
    joints[1, wrist] = [0, 4, 0]
    assert coherence.part_speeds(joints) == pytest.approx(np.array([[np.sqrt(25 / 4), 0, 0, 0, 0]]))


def test_one_window_by_hand():
    rng = np.random.default_rng(1)
    speeds = rng.uniform(0.01, 0.05, (20, 5))
    expected = []
    for g, h in combinations(range(5), 2):
        a, b = ((speeds[:, i] - speeds[:, i].mean()) / speeds[:, i].std() for i in (g, h))
        r = {lag: sum(a[t] * b[t + lag] for t in range(20) if 0 <= t + lag < 20) / 20 for lag in range(-15, 16)}
        weights = {lag: np.exp(value / 0.1) for lag, value in r.items()}
        total = sum(weights.values())
        mean = sum(weights[lag] * r[lag] for lag in r) / total
        mean_lag = sum(weights[lag] * abs(lag) for lag in r) / total
        expected.append(max(0.0, mean) * np.exp(-mean_lag / 5))
    assert coherence.temporal_coherence(moving(speeds)) == pytest.approx(np.mean(expected), rel=1e-4)


def test_unison_beats_chance():
    rng = np.random.default_rng(2)
    alone = rng.uniform(0.01, 0.05, (100, 5))
    together = np.repeat(alone[:, :1], 5, axis=1)
    unison, chance = (coherence.temporal_coherence(moving(s)) for s in (together, alone))
    assert unison > 0.7 and chance < 0.4


def test_still_parts_are_left_out():
    speeds = np.zeros((40, 5))
    assert coherence.temporal_coherence(moving(speeds), still=0.1) == 1.0
    speeds[:, :2] = np.random.default_rng(3).uniform(0.0, 0.05, (40, 1))
    with_mask = coherence.temporal_coherence(moving(speeds), still=0.1)
    assert with_mask > 0.7 > coherence.temporal_coherence(moving(speeds))


def test_too_short_for_rhythm():
    assert coherence.temporal_coherence(skeleton()[None]) == 1.0


def test_geometry_by_hand():
    joints = skeleton()[None]
    geometry = coherence.part_geometry(joints)[0]
    left, right = (joints[0, list(PARTS[name])].mean(axis=0) for name in ("left_arm", "right_arm"))
    assert coherence.leg_length(joints) == pytest.approx(0.8)
    assert geometry[0] == pytest.approx(np.linalg.norm(left - right) / 0.8)
    trunk = joints[0, INDEX["neck"]] - joints[0, INDEX["pelvis"]]
    arm = joints[0, INDEX["left_wrist"]] - left
    cosine = arm @ trunk / np.linalg.norm(arm) / np.linalg.norm(trunk)
    assert geometry[10] == pytest.approx(np.arccos(cosine), rel=1e-5)


def test_spatial_score_of_known_deviation():
    joints = np.repeat(skeleton()[None], 3, axis=0)
    geometry = coherence.part_geometry(joints)[0]
    std = np.full(15, 0.2)
    for deviations, expected in ((0.0, 1.0), (1.5, np.exp(-1.0)), (3.0, np.exp(-4.0))):
        reference = coherence.SpatialReference(tuple(geometry + deviations * std), tuple(std))
        assert coherence.spatial_coherence(joints, reference) == pytest.approx(expected, rel=1e-5)


def test_fitted_reference_is_the_mean_and_deviation():
    motions = [np.repeat(skeleton()[None] * size, 4, axis=0) for size in (1.0, 1.3)]
    motions[1][:, INDEX["left_wrist"], 2] += 0.3
    reference = coherence.fit_reference(motions)
    geometry = np.concatenate([coherence.part_geometry(m) for m in motions])
    assert reference.mean == pytest.approx(geometry.mean(axis=0))
    assert reference.std == pytest.approx(geometry.std(axis=0))


def test_captured_reference_is_symmetric():
    joints = skeleton()[None] + np.random.default_rng(4).normal(0, 0.05, (5, JOINT_COUNT, 3))
    mirrored = joints[:, MIRRORED] * [1, -1, 1]
    assert coherence.spatial_coherence(joints) == pytest.approx(coherence.spatial_coherence(mirrored))


@settings(max_examples=25, deadline=None)
@given(scale=st.floats(0.2, 3.0), yaw=st.floats(-3.0, 3.0), seed=st.integers(0, 99))
def test_size_place_and_heading_do_not_matter(scale, yaw, seed):
    rng = np.random.default_rng(seed)
    joints = moving(rng.uniform(0.01, 0.05, (30, 5)))
    turn = np.array([[np.cos(yaw), -np.sin(yaw), 0], [np.sin(yaw), np.cos(yaw), 0], [0, 0, 1]])
    moved = scale * joints @ turn.T + [1.0, -2.0, 0.0]
    assert coherence.spatial_coherence(moved) == pytest.approx(coherence.spatial_coherence(joints), rel=1e-4)
    assert coherence.temporal_coherence(moved) == pytest.approx(
        coherence.temporal_coherence(joints), rel=1e-2, abs=1e-3
    )
    assert 0 <= coherence.temporal_coherence(joints) <= 1
