from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

from ros_free_stack.errors import InvalidMessage
from ros_free_stack.formats.features import CHANNELS, HUMANML3D, KIT, Skeleton, decode, encode, to_float16
from ros_free_stack.skeleton import INDEX, PARENTS

Floats = NDArray[np.float64]

AXES = {"left": (0, 1, 0), "right": (0, -1, 0), "up": (0, 0, 1), "down": (0, 0, -1), "forward": (1, 0, 0)}


def rest(skeleton: Skeleton) -> Floats:
    """A standing pose with bones of 0.1 to 0.3 m, z up, facing x."""
    points = np.zeros((len(skeleton.joints), 3))
    for joint, parent in enumerate(skeleton.parents, start=1):
        points[joint] = points[parent] + np.array(AXES[skeleton.directions[joint]]) * (0.1 + 0.01 * joint)
    return points - (0, 0, points[:, 2].min())


def turned(points: Floats, heading: Floats | float) -> Floats:
    cos, sin = np.cos(heading), np.sin(heading)
    x, y = points[..., 0], points[..., 1]
    return np.stack([(x.T * cos - y.T * sin).T, (x.T * sin + y.T * cos).T, points[..., 2]], axis=-1)


def motion(seed: int, frames: int, spin: float, skeleton: Skeleton = HUMANML3D) -> Floats:
    """A smooth random motion that turns by `spin` rad in all while it wanders."""
    rng = np.random.default_rng(seed)
    noise = gaussian_filter1d(rng.normal(size=(frames, len(skeleton.joints), 3)), 6, axis=0)
    points = turned(rest(skeleton) + 0.2 * noise, rng.uniform(-np.pi, np.pi) + np.linspace(0, spin, frames))
    return points + np.cumsum(0.05 * gaussian_filter1d(rng.normal(size=(frames, 1, 3)), 10, axis=0) * (1, 1, 0), axis=0)


def misfit(found: Floats, wanted: Floats) -> float:
    """Largest distance (m) after the best turn about z and shift along the floor."""
    a = found - found[:1, :1] * (1, 1, 0)
    b = wanted - wanted[:1, :1] * (1, 1, 0)
    angle = np.angle(np.sum((b[..., 0] + 1j * b[..., 1]) * (a[..., 0] - 1j * a[..., 1])))
    return float(np.linalg.norm(turned(a, float(angle)) - b, axis=-1).max())


@pytest.mark.parametrize(("skeleton", "width"), [(HUMANML3D, 263), (KIT, 251)])
def test_layout(skeleton: Skeleton, width: int) -> None:
    assert skeleton.width == len(skeleton.channels) == len(set(skeleton.channels)) == width
    assert encode(motion(0, 5, 0.0, skeleton), skeleton).shape == (4, width)


def test_parents_are_those_of_the_human_skeleton() -> None:
    assert tuple(HUMANML3D.parents) == PARENTS[1:]


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 2**32 - 1), st.integers(2, 120), st.floats(-20, 20))
def test_decode_inverts_encode(seed: int, frames: int, spin: float) -> None:
    joints = motion(seed, frames, spin)
    decoded = decode(encode(joints))
    assert misfit(decoded, joints[:-1]) < 1e-6
    np.testing.assert_allclose(decoded[0, 0, :2], 0, atol=1e-12)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(-20, 20))
def test_a_second_round_changes_nothing(seed: int, spin: float) -> None:
    once = decode(encode(motion(seed, 60, spin)))
    assert misfit(decode(encode(once)), once[:-1]) < 1e-6


def test_kit_round_trip() -> None:
    joints = motion(3, 80, 9.0, KIT)
    assert misfit(decode(encode(joints, KIT), KIT), joints[:-1]) < 1e-6


@given(heading=st.floats(-np.pi, np.pi), x=st.floats(-5, 5), y=st.floats(-5, 5))
@settings(deadline=None, max_examples=20)
def test_place_and_heading_do_not_matter(heading: float, x: float, y: float) -> None:
    joints = motion(1, 40, 2.0)
    np.testing.assert_allclose(encode(turned(joints, heading) + np.array([x, y, 0])), encode(joints), atol=1e-9)


def test_a_standing_pose_faces_forward() -> None:
    joints = np.repeat(turned(rest(HUMANML3D), 2.0)[None], 3, axis=0)
    decoded = decode(encode(joints))
    np.testing.assert_allclose(decoded[0], rest(HUMANML3D), atol=1e-9)
    assert decoded[0, INDEX["left_wrist"], 1] > 0 > decoded[0, INDEX["right_wrist"], 1]


def test_root_channels_have_published_signs_and_units() -> None:
    frames, step, turn = 60, 0.03, 0.02
    still = np.repeat(rest(HUMANML3D)[None], frames, axis=0)
    walk = encode(still + step * np.arange(frames)[:, None, None] * (1, 0, 0))
    np.testing.assert_allclose(walk[:, :3], np.tile([0, 0, step], (frames - 1, 1)), atol=1e-12)
    sidestep = encode(still + step * np.arange(frames)[:, None, None] * (0, 1, 0))
    np.testing.assert_allclose(sidestep[:, :3], np.tile([0, step, 0], (frames - 1, 1)), atol=1e-12)
    # Turning to the left turns the world to the right in the body's frame, by half the angle in HumanML3D.
    spin = encode(turned(still, np.linspace(0, turn * (frames - 1), frames)))
    np.testing.assert_allclose(spin[20:-20, 0], -turn / 2, atol=2e-3)
    np.testing.assert_allclose(walk[:, 3], still[0, 0, 2])


def test_rotations_rebuild_the_joints() -> None:
    """Forward kinematics as published: along each chain from the root, with the lengths of the bones."""
    joints = motion(5, 30, 0.0)
    joints = joints - joints[:, :1] * (1, 1, 0)
    joints[:, [1, 2, 16, 17]] = rest(HUMANML3D)[[1, 2, 16, 17]] + (joints[:, :1] * (0, 0, 1) - rest(HUMANML3D)[0])
    wanted = joints[:-1, :, [1, 2, 0]]
    six = encode(joints)[:, 67:193].reshape(-1, 21, 2, 3)
    third = np.cross(six[:, :, 0], six[:, :, 1])
    matrices = np.stack([six[:, :, 0], six[:, :, 1], third], axis=-1)
    rest_axes = {name: np.array(axis)[[1, 2, 0]] for name, axis in AXES.items()}
    for chain in HUMANML3D.chains:
        turn = np.broadcast_to(np.eye(3), (len(six), 3, 3))
        for parent, child in pairwise(chain):
            turn = turn @ matrices[:, child - 1]
            length = np.linalg.norm(wanted[:, child] - wanted[:, parent], axis=-1, keepdims=True)
            bone = turn @ rest_axes[HUMANML3D.directions[child]] * length
            np.testing.assert_allclose(bone, wanted[:, child] - wanted[:, parent], atol=1e-9)


def test_a_bone_opposite_to_rest_stays_a_rotation() -> None:
    joints = np.repeat(rest(HUMANML3D)[None], 3, axis=0)
    joints[:, INDEX["left_wrist"]] = joints[:, INDEX["left_elbow"]] + (0, 0, 0.3)
    six = encode(joints)[:, 67:193].reshape(-1, 21, 2, 3)
    np.testing.assert_allclose(np.linalg.norm(six, axis=-1), 1, atol=1e-9)
    np.testing.assert_allclose((six[:, :, 0] * six[:, :, 1]).sum(-1), 0, atol=1e-9)


def test_contacts_follow_the_speed_of_the_foot() -> None:
    joints = np.repeat(rest(HUMANML3D)[None], 10, axis=0)
    joints[5:, INDEX["right_foot"]] += (0.05, 0, 0)
    contacts = encode(joints)[:, -4:]
    assert CHANNELS[-1] == "right_foot_contact"
    np.testing.assert_array_equal(contacts[:, 3], [1, 1, 1, 1, 0, 1, 1, 1, 1])
    assert contacts[:, :3].all()


def test_half_precision_does_not_drift() -> None:
    frames = 197
    still = np.repeat(rest(HUMANML3D)[None], frames, axis=0)
    walk = encode(still + 0.0613 * np.arange(frames)[:, None, None] * (1, 0, 0))
    exact = decode(walk)
    stored = to_float16(walk)
    assert stored.dtype == np.float16
    assert np.abs(decode(stored) - exact).max() < 1e-3
    # Plain rounding of the same motion drifts by more.
    assert np.abs(decode(walk.astype(np.float16)) - exact)[:, 0].max() > np.abs(decode(stored) - exact)[:, 0].max()


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(-20, 20))
def test_half_precision_keeps_any_motion_within_5_mm(seed: int, spin: float) -> None:
    features = encode(motion(seed, 197, spin))
    assert np.linalg.norm(decode(to_float16(features)) - decode(features), axis=-1).max() < 5e-3


@pytest.mark.parametrize("shape", [(1, 22, 3), (5, 21, 3), (22, 3)])
def test_wrong_joints_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(InvalidMessage, match=r"motion\.joints: expected \(T, 22, 3\)"):
        encode(np.zeros(shape))


def test_wrong_features_are_refused() -> None:
    with pytest.raises(InvalidMessage, match=r"motion\.features: expected \(T, 263\)"):
        decode(np.zeros((3, 251)))
    features = np.zeros((3, 263))
    features[2, 7] = np.nan
    with pytest.raises(InvalidMessage, match="frame 2"):
        decode(features)
