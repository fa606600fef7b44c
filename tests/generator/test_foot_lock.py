"""Foot-skate clean-up: clean motion passes through, glides go, jumps stay, bones keep their lengths."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.corpus.actions import perform
from generator.corpus.pose import joints
from generator.corpus.scene import Scene
from generator.postprocess.foot_lock import BALLS, Floats, find_stances, lock_feet
from ros_free_stack.formats.features import decode, encode
from ros_free_stack.skeleton import FPS, INDEX, PARENTS

LEG = [INDEX[f"{side}_{name}"] for side in ("left", "right") for name in ("knee", "ankle", "foot")]


def clip(action: str, seed: int = 0, **values: Any) -> tuple[Floats, Floats]:
    """Joints and contacts of an authored action, by way of the features."""
    scene = Scene(seed)
    perform(scene, action, **values)
    features = encode(joints(scene.solve(0.5)))
    return decode(features), features[:, -4:]


def glided(motion: Floats, share: float) -> Floats:
    """The motion with the pelvis' way over the floor, and everything with it, longer by that share."""
    out = motion.copy()
    out[..., :2] += share * (motion[:, :1, :2] - motion[:1, :1, :2])
    return out


def slip(motion: Floats, contacts: Floats) -> float:
    """Mean speed over the floor of the feet that stand in the motion before, m/s."""
    stances = find_stances(motion, contacts, 0.02)
    speed = np.linalg.norm(np.diff(motion[:, BALLS, :2], axis=0), axis=-1) * FPS
    return float(speed[stances[1:] & stances[:-1]].mean())


@pytest.mark.parametrize(
    ("action", "values"),
    [("walk", {"steps": 5}), ("turn", {"angle": 90.0}), ("step", {"direction": "left"}), ("squat", {}), ("march", {})],
)
def test_clean_motion_hardly_changes(action: str, values: dict[str, Any]) -> None:
    motion, contacts = clip(action, **values)
    change = lock_feet(motion, contacts) - motion
    posed = np.linalg.norm(change - change[:, :1], axis=-1)
    assert posed.mean() < 0.002
    assert np.quantile(posed, 0.99) < 0.012
    assert np.linalg.norm(change[:, 0], axis=-1).max() < 0.01


@settings(max_examples=15, deadline=None)
@given(st.floats(-0.4, 0.4).filter(lambda share: abs(share) > 0.1), st.integers(0, 3))
def test_a_gliding_walk_stands_on_its_feet(share: float, seed: int) -> None:
    motion, contacts = clip("walk", seed, steps=5)
    wrong = glided(motion, share)
    cleaned = lock_feet(wrong, contacts)
    assert slip(wrong, contacts) > 0.05
    assert slip(cleaned, contacts) < 0.3 * slip(wrong, contacts)
    way = np.linalg.norm(motion[-1, 0, :2] - motion[0, 0, :2])
    assert np.linalg.norm(cleaned[-1, 0, :2] - cleaned[0, 0, :2]) == pytest.approx(way, rel=0.08)
    assert np.linalg.norm(np.diff(cleaned, axis=0), axis=-1).max() < 0.35  # no jump from frame to frame


def test_trunk_and_arms_keep_their_poses_and_bones_their_lengths() -> None:
    motion, contacts = clip("walk", steps=5)
    cleaned = lock_feet(glided(motion, 0.3), contacts)
    others = [i for i in range(22) if i not in LEG]
    np.testing.assert_allclose((cleaned - cleaned[:, :1])[:, others], (motion - motion[:, :1])[:, others], atol=1e-9)
    for joint in LEG:
        lengths = np.linalg.norm(cleaned[:, joint] - cleaned[:, PARENTS[joint]], axis=1)
        assert np.ptp(lengths) < 1e-9


def test_feet_do_not_sink_and_noise_is_flattened() -> None:
    motion, contacts = clip("squat")
    noise = np.random.default_rng(0).normal(0, 0.004, motion.shape)
    cleaned = lock_feet(motion + noise, contacts)
    rest = np.percentile((motion + noise)[:, BALLS, 2].min(axis=1), 5)
    assert cleaned[:, BALLS, 2].min() > rest - 1e-6
    assert np.ptp(cleaned[:, BALLS], axis=0).max() < 1e-6


def test_flight_is_left_alone() -> None:
    motion, contacts = clip("jump")
    flying = (motion[:, BALLS, 2] > 0.06).all(axis=1)
    assert flying.any()
    change = lock_feet(motion, contacts) - motion
    assert np.abs(change[flying]).max() < 0.02
    np.testing.assert_array_equal(lock_feet(motion, np.zeros_like(contacts)), motion)


def test_a_floating_body_comes_down() -> None:
    motion, contacts = clip("wave")
    floating = motion.copy()
    half = len(motion) // 2
    floating[half:, :, 2] += 0.03
    cleaned = lock_feet(floating, contacts)
    assert np.abs(cleaned[:, BALLS, 2] - 0.02).max() < 1e-3
    assert cleaned[-1, 0, 2] == pytest.approx(motion[-1, 0, 2], abs=0.01)


@pytest.mark.parametrize("frames", [1, 2, 3, 5])
def test_the_shortest_motions(frames: int) -> None:
    motion, contacts = clip("walk", steps=5)
    assert lock_feet(motion[:frames], contacts[:frames]).shape == (frames, 22, 3)


def test_same_bytes_twice_and_the_input_stays() -> None:
    motion, contacts = clip("walk", steps=5)
    before = motion.copy()
    assert lock_feet(motion, contacts).tobytes() == lock_feet(motion, contacts).tobytes()
    np.testing.assert_array_equal(motion, before)


@pytest.mark.parametrize(("height", "starts"), [(0.01, True), (0.022, False)])
def test_a_stance_starts_with_a_foot_that_is_low_and_not_by_contact_alone(height: float, starts: bool) -> None:
    """One foot stands; the other is said to be in contact all the time, and comes down to a height over its rest."""
    motion = np.zeros((20, 22, 3))
    motion[:, BALLS[1], 2] = height
    stances = find_stances(motion, np.ones((20, 4)), 0.0)
    assert stances[:, 0].all()
    assert stances[:, 1].all() if starts else not stances[:, 1].any()


@pytest.mark.parametrize(("height", "stays"), [(0.022, True), (0.04, False)])
def test_a_stance_goes_on_until_the_foot_has_left(height: float, stays: bool) -> None:
    motion = np.zeros((20, 22, 3))
    motion[10:, BALLS[1], 2] = height
    stances = find_stances(motion, np.ones((20, 4)), 0.0)[:, 1]
    assert stances[:10].all()
    assert stances[10:].all() if stays else not stances[10:].any()
