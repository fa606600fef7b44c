"""The pose space: joints, fit and mirror agree with one another."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from generator.corpus import body
from generator.corpus.actions import perform
from generator.corpus.pose import ARM_CHANNELS, CHANNELS, Pose, centre_of_mass, fit, joints, mirror
from generator.corpus.scene import Scene
from ros_free_stack.errors import InvalidMessage
from ros_free_stack.skeleton import BONES, INDEX, MIRRORED


def walking_and_waving(seed: int = 1) -> Pose:
    scene = Scene(seed)
    perform(scene, "wave", side="right", advance=False)
    perform(scene, "walk", steps=5, curve=40.0)
    return scene.solve()


def test_channels_have_one_row_a_frame():
    pose = walking_and_waving()
    assert set(pose) == set(CHANNELS)
    assert {len(channel) for channel in pose.values()} == {len(pose["root"])}


def test_bones_keep_their_lengths():
    places = joints(walking_and_waving())
    for parent, child in BONES:
        lengths = np.linalg.norm(places[:, child] - places[:, parent], axis=-1)
        assert np.ptp(lengths) < 1e-9, (parent, child)


def test_mirrored_pose_gives_reflected_joints():
    pose = walking_and_waving()
    np.testing.assert_allclose(joints(mirror(pose)), joints(pose)[:, MIRRORED] * [1, -1, 1], atol=1e-9)


def test_mirror_twice_is_the_identity():
    pose = walking_and_waving()
    again = mirror(mirror(pose))
    for name in CHANNELS:
        np.testing.assert_allclose(again[name], pose[name], atol=1e-12)


def test_fit_recovers_joints():
    places = joints(walking_and_waving())
    error = np.linalg.norm(joints(fit(places)) - places, axis=-1)
    assert error.mean() < 0.03
    assert error.max() < 0.12  # collars are not fitted: the shoulders differ while an arm is raised


def test_fit_scales_to_the_reference_body():
    places = joints(walking_and_waving())
    np.testing.assert_allclose(joints(fit(1.2 * places)), joints(fit(places)), atol=1e-6)


@pytest.mark.parametrize("shape", [(5, 21, 3), (22, 3), (0, 22, 3)])
def test_fit_rejects_other_shapes(shape):
    with pytest.raises(InvalidMessage, match="expected shape"):
        fit(np.zeros(shape))


def test_fit_rejects_nan():
    places = joints(walking_and_waving())
    places[3, 4, 1] = np.nan
    with pytest.raises(InvalidMessage, match="finite"):
        fit(places)


def test_arm_channels_move_only_the_arms():
    pose, other = walking_and_waving(1), walking_and_waving(1)
    for name in ARM_CHANNELS:
        other[name] = other[name][::-1]
    moved = np.linalg.norm(joints(pose) - joints(other), axis=-1).max(axis=0) > 1e-9
    names = {name for name, i in INDEX.items() if moved[i]}
    assert names == {f"{s}_{n}" for s in ("left", "right") for n in ("shoulder", "elbow", "wrist")}


def test_centre_of_mass_lies_inside_the_trunk_of_a_standing_person():
    places = joints(Scene(2).solve(1.0))
    centre = centre_of_mass(places)
    assert np.linalg.norm((centre - places[:, 0])[:, :2], axis=-1).max() < 0.1
    assert np.all(centre[:, 2] > 0.85)
    assert np.all(centre[:, 2] < 1.1)


def fastest(places: np.ndarray, joint: str) -> float:
    """Largest step of a joint against the pelvis from one frame to the next, in m."""
    return float(np.linalg.norm(np.diff(places[:, INDEX[joint]] - places[:, 0], axis=0), axis=-1).max())


def swinging_leg(*, offside: float, bend: float) -> np.ndarray:
    """Standing joints (T, 22, 3) whose right leg, after 2.5 s, swings up to the front above the level and back.

    The knee lies `bend` m off the line from hip to ankle, `offside` rad out of the plane of the swing.
    """
    places = np.repeat(joints(Scene(0).solve(1.5))[:1], 80, axis=0)
    hip, knee, ankle = (places[:, INDEX[f"right_{n}"]].copy() for n in ("hip", "knee", "ankle"))
    angle = np.radians(110) * np.sin(np.pi * np.clip(np.arange(80) - 50, 0, None) / 29) ** 2
    none = np.zeros_like(angle)
    along = np.stack([np.sin(angle), none, -np.cos(angle)], -1)
    ahead = np.stack([np.cos(angle), none, np.sin(angle)], -1)
    off = np.cos(offside) * ahead + np.sin(offside) * np.array([0.0, -1.0, 0.0])
    thigh, shank = (np.linalg.norm(b - a, axis=-1, keepdims=True) for a, b in ((hip, knee), (knee, ankle)))
    places[:, INDEX["right_knee"]] = knee = hip + along * np.sqrt(thigh**2 - bend**2) + bend * off
    places[:, INDEX["right_ankle"]] = ankle = knee + along * np.sqrt(shank**2 - bend**2) - bend * off
    places[:, INDEX["right_foot"]] = ankle + 0.13 * ahead + 0.05 * along
    return places


@pytest.mark.parametrize("offside", [0.0, 0.8, -0.8, np.pi, 3.0, -3.0])
@pytest.mark.parametrize("bend", [0.001, 0.02, 0.08])
def test_the_fitted_knee_of_a_high_kick_never_flips(offside, bend):
    places = swinging_leg(offside=offside, bend=bend)
    fitted = joints(fit(places))
    assert fastest(fitted, "right_knee") < 1.3 * fastest(places, "right_knee") + 0.02
    if abs(offside) < 1:  # a knee that bends backward is not one
        assert np.linalg.norm(fitted - places, axis=-1)[:, INDEX["right_knee"]].max() < 0.06


def test_noise_about_a_straight_leg_does_not_turn_the_knee():
    places = joints(walking_and_waving())[:1].repeat(60, axis=0)
    hip, ankle = places[:, INDEX["left_hip"]], places[:, INDEX["left_ankle"]]
    noise = np.random.default_rng(0).normal(0, 0.004, hip.shape)
    places[:, INDEX["left_knee"]] = 0.49 * hip + 0.51 * ankle + noise
    assert fastest(joints(fit(places)), "left_knee") < 0.06


@pytest.mark.parametrize("height", ["low", "middle", "high"])
@pytest.mark.parametrize("direction", ["forward", "side"])
def test_an_authored_kick_moves_its_knee_smoothly(height, direction):
    scene = Scene(3)
    perform(scene, "kick", side="right", height=height, direction=direction)
    places = joints(scene.solve())
    assert fastest(places, "right_knee") < 0.26
    assert fastest(places, "left_knee") < 0.08


def test_a_foot_past_the_vertical_keeps_its_yaw():
    """A runner's foot behind the body, its sole up to 35 deg past upright."""
    pose = {name: channel[:1].repeat(41, axis=0) for name, channel in walking_and_waving().items()}
    swing = np.sin(np.linspace(0, np.pi, 41)) ** 2
    pose["foot_left"][:, 0] -= 0.35 * swing  # the person faces x
    pose["foot_left"][:, 2] += 0.5 * swing
    pose["roll_left"] = np.radians(100) * swing
    fitted = fit(joints(pose))
    turned = np.angle(np.exp(1j * (fitted["foot_left"][:, 3] - pose["foot_left"][:, 3])))
    assert np.abs(turned).max() < 0.5
    assert np.abs(np.diff(fitted["roll_left"])).max() < 1.3 * np.abs(np.diff(pose["roll_left"])).max()


def test_turning_in_place_through_whole_turns_is_fitted_without_jumps():
    scene = Scene(1)
    perform(scene, "turn", angle=360.0)
    perform(scene, "turn", angle=200.0)
    places = joints(scene.solve())
    fitted = joints(fit(places))
    for joint in ("left_knee", "right_knee", "left_elbow", "right_elbow"):
        assert fastest(fitted, joint) < fastest(places, joint) + 0.03, joint


UNIT = st.floats(-1, 1)


@given(UNIT, UNIT, UNIT, st.sampled_from(["left", "right"]))
@settings(max_examples=200, deadline=None)
def test_arm_chart_inverts(x, y, z, side):
    direction = np.array([[x, y, z]])
    far_from_antipode = body.direction_to_chart(direction, side)
    if np.linalg.norm(direction) < 1e-2 or np.linalg.norm(far_from_antipode) > np.pi - 1e-2:
        return
    np.testing.assert_allclose(body.chart_to_direction(far_from_antipode, side), body.unit(direction), atol=1e-6)


@given(st.floats(0.05, 0.75), st.floats(-3, 3), st.floats(-3.0, 3.0))
@settings(max_examples=100, deadline=None)
def test_two_bone_chain_reaches_its_target_with_the_given_swivel(length, angle, swivel):
    start, pole = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    target = length * np.array([[np.cos(angle), np.sin(angle), 0.0]])
    middle, end = body.two_bone(start, target, body.THIGH, body.SHANK, pole, np.array([swivel]))
    np.testing.assert_allclose(end, target, atol=1e-9)
    assert np.linalg.norm(middle) == pytest.approx(body.THIGH)
    assert np.linalg.norm(end - middle) == pytest.approx(body.SHANK)
    towards, aside = body.bend(start, middle, end, pole)
    assert np.arctan2(aside, towards)[0] == pytest.approx(swivel, abs=1e-6)


def test_chain_out_of_reach_ends_short():
    far = np.array([[0.0, 0.0, -3.0]])
    _, end = body.two_bone(np.zeros((1, 3)), far, body.THIGH, body.SHANK, np.array([[1.0, 0, 0]]), np.zeros(1))
    assert body.LEG * 0.999 < np.linalg.norm(end) < body.LEG
