"""The number of each kinematic check is what an independent calculation gives, in either direction."""

import dataclasses
import math

import numpy as np
import pytest

from ros_free_stack.messages import Check, Floats
from ros_free_stack.robots import RobotDescription
from ros_free_stack.thresholds import load_thresholds
from sim.judge.checks import contact, joints
from sim.model import judging_model
from sim.reference import Reference, make_reference

LIMITS = load_thresholds("default", scale=1.0)
KNEE_BENT = {"l_hip_pitch": -0.6, "l_knee": 1.2, "l_ank_pitch": 0.6}


@pytest.fixture
def reference_of(op3: RobotDescription, standing):
    def make(**changes) -> Reference:
        return make_reference(standing(op3, **changes), op3, judging_model(op3))

    return make


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("bound", ["lower", "upper"])
def test_joint_range_measures_beyond_either_bound(reference_of, op3, bound, sign):
    at = getattr(op3.joints["head_pan"], bound) + sign * 0.125
    check = joints.joint_range(reference_of(joints={"head_pan": np.full(50, at)}), LIMITS["joint_range"])
    others = [
        max(limits.lower - angle, angle - limits.upper)
        for (name, limits), angle in zip(op3.joints.items(), op3.standing_pos, strict=True)
        if name != "head_pan"
    ]
    outside = 0.125 if (sign > 0) == (bound == "upper") else -0.125
    assert check.value == pytest.approx(max(outside, *others), abs=1e-9)
    assert check.passed is (outside < 0)


def pan(steps: Floats) -> dict[str, Floats]:
    return {"head_pan": np.cumsum(steps)}


@pytest.mark.parametrize("sign", [1, -1])
def test_joint_velocity_is_the_fastest_step_in_either_direction(reference_of, op3, sign):
    steps = np.full(50, 0.001 * -sign)
    steps[20] = sign * 0.03
    check = joints.joint_velocity(reference_of(joints=pan(steps)), LIMITS["joint_velocity"])
    assert check.value == pytest.approx(0.03 * 50 / op3.joints["head_pan"].velocity)
    assert (check.worst_item, check.worst_frame) == ("head_pan", 19)


@pytest.mark.parametrize("sign", [1, -1])
def test_joint_acceleration_is_the_largest_change_in_either_direction(reference_of, op3, sign):
    steps = np.cumsum([0.0] * 10 + [sign * 0.004] + [-sign * 0.0001] * 39)
    check = joints.joint_acceleration(reference_of(joints=pan(steps)), LIMITS["joint_acceleration"])
    assert check.value == pytest.approx(0.004 * 50**2 / op3.joints["head_pan"].acceleration)
    assert check.worst_item == "head_pan"


@pytest.mark.parametrize("hertz", [2.5, 5.0])
def test_jerk_of_a_sine_is_what_its_formula_gives(reference_of, hertz):
    """ln(W^3 / v^2 times the integral of the squared jerk over W) of A cos(w t), where v = A w: ln((w W)^4 / 2).

    For windows of whole periods.
    """
    omega = 2 * math.pi * hertz
    wave = 1.0 / omega * np.cos(omega * np.arange(800) / 400.0)
    check = joints.jerk(reference_of(frames=800, fps=400.0, joints={"head_pan": wave}), LIMITS["jerk"])
    assert check.value == pytest.approx(4 * math.log(omega * joints.JERK_WINDOW_S) - math.log(2), abs=0.05)


def test_self_collision_is_the_deepest_of_all_pairs_and_frames(reference_of):
    crossing = np.linspace(0.15, 0.35, 50)
    reference = reference_of(joints={"l_hip_roll": crossing, "r_hip_roll": -crossing}, root_offset=[0, 0, 0.002])
    depths = [value for pairs in reference.pair_depth for value in pairs.values()]
    assert len(set(depths)) > 10
    assert contact.self_collision(reference, LIMITS["self_collision"]).value == max(depths)


def test_ground_penetration_counts_the_lowest_corner_of_a_sole(reference_of):
    reference = lifted(reference_of, root_offset=[0, 0, -0.03])
    reference = dataclasses.replace(reference, floor_depth=np.zeros_like(reference.floor_depth))
    check = contact.ground_penetration(reference, LIMITS["ground_penetration"])
    assert check.value == pytest.approx(-reference.soles["right"][0, :, 2].min(), abs=1e-9)
    tilted = reference_of(joints={"r_ank_pitch": np.full(50, 0.0)})
    tilted = dataclasses.replace(tilted, floor_depth=np.zeros_like(tilted.floor_depth))
    corners = tilted.soles["right"][0, :, 2]
    assert contact.ground_penetration(tilted, LIMITS["ground_penetration"]).value == pytest.approx(-corners.min())
    assert -corners.min() > 0.01 > -corners.max()


def lifted(reference_of, **changes) -> Reference:
    joint_pos = {name: np.full(50, angle) for name, angle in KNEE_BENT.items()}
    return reference_of(joints=joint_pos, **changes)


def test_floating_is_the_height_of_the_foot_that_should_stand(reference_of):
    reference = lifted(reference_of)
    check = contact.floating(reference, LIMITS["floating"])
    assert check.worst_item == "left"
    assert check.value == pytest.approx(reference.soles["left"][0, :, 2].min()) and check.value > 0.02


def slide(*, metres_per_s: float, during: slice) -> Floats:
    speed = np.zeros((100, 3))
    speed[during, 1] = metres_per_s
    return np.cumsum(speed, axis=0) / 50.0


def planted(reference: Reference, frames: slice) -> Reference:
    contacts = np.zeros_like(reference.trajectory.contacts)
    contacts[frames] = True
    return dataclasses.replace(reference, trajectory=dataclasses.replace(reference.trajectory, contacts=contacts))


def skates(reference: Reference) -> tuple[Check, Check]:
    return (
        contact.foot_skate(reference, LIMITS["foot_skate"]),
        contact.foot_skate_peak(reference, LIMITS["foot_skate_peak"], scale=1.0),
    )


def test_skate_is_that_of_planted_feet_alone(reference_of):
    moving = reference_of(frames=100, root_offset=slide(metres_per_s=0.05, during=slice(0, 50)))
    mean, peak = skates(planted(moving, slice(0, 50)))
    assert (mean.value, peak.value) == (pytest.approx(0.05), pytest.approx(0.05))
    mean, peak = skates(planted(moving, slice(50, 100)))
    assert (mean.value, peak.value) == (0.0, 0.0)
    assert [check.value for check in skates(planted(moving, slice(0, 0)))] == [0.0, 0.0]


@pytest.mark.parametrize(("height", "speed"), [(0.04, 0.05), (0.06, 0.0)])
def test_peak_skate_is_that_of_soles_near_the_floor(reference_of, height, speed):
    offset = np.add(slide(metres_per_s=0.05, during=slice(0, 100)), [0.0, 0.0, height])
    _, peak = skates(reference_of(frames=100, root_offset=offset))
    assert peak.value == pytest.approx(speed)
