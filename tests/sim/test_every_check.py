"""What breaks one rule fails that rule alone, for every check there is."""

import dataclasses
from collections.abc import Callable

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robot_model import size_scale
from ros_free_stack.robots import RobotDescription, load_robot
from ros_free_stack.thresholds import LEVELS, Level, Threshold, load_thresholds
from sim.judge.checks.tracking import motor
from sim.judge.robustness import Robustness
from sim.judge.verdict import judge, kinematic_checks, playback_checks, robustness_check
from sim.model import judging_model
from sim.playback.physics import FallLimits, Playback, play, set_stage
from sim.reference import Reference, make_reference

LIMITS = FallLimits(0.1, 0.8)


def sine(amplitude: float, omega: float, frames: int, fps: float) -> np.ndarray:
    return amplitude * np.sin(omega * np.arange(frames) / fps)


def out_of_range(op3, make):
    return make(op3, frames=200, joints={"head_pan": np.linspace(0, op3.joints["head_pan"].upper + 0.1, 200)})


def too_fast(op3, make):
    omega = 6.0
    pan = sine(1.2 * op3.joints["head_pan"].velocity / omega, omega, 200, 200.0)
    return make(op3, frames=200, fps=200.0, joints={"head_pan": pan})


def too_much_acceleration(op3, make):
    omega = 25.0
    pan = sine(1.3 * op3.joints["head_pan"].acceleration / omega**2, omega, 200, 200.0)
    return make(op3, frames=200, fps=200.0, joints={"head_pan": pan})


def shaky(op3, make):
    omega = 2 * np.pi * 20.0
    pan = sine(0.7 * op3.joints["head_pan"].acceleration / omega**2, omega, 400, 400.0)
    return make(op3, frames=400, fps=400.0, joints={"head_pan": pan})


def crossed_legs(op3, make):
    crossed = {"l_hip_roll": np.full(50, 0.35), "r_hip_roll": np.full(50, -0.35)}
    return make(op3, root_offset=[0, 0, 0.002], joints=crossed, contacts=False)


def sunk(op3, make):
    return make(op3, root_offset=[0, 0, -0.02])


def hovering(op3, make):
    return make(op3, root_offset=[0, 0, 0.02])


def in_the_air_without_a_flag(op3, make):
    """Up by 15 mm and down again within 1 s: a jump of that height takes 0.11 s."""
    rise = np.zeros((100, 3))
    rise[25:75, 2] = 0.015 * np.sin(np.pi * np.arange(50) / 50) ** 2
    return make(op3, frames=100, root_offset=rise, contacts=False)


def skating(op3, make):
    slide = np.zeros((100, 3))
    slide[:, 1] = 0.05 * np.arange(100) / 50.0
    return make(op3, frames=100, root_offset=slide)


def one_slip(op3, make):
    slide = np.zeros((200, 3))
    slide[100:, 0] = 0.2 / 50.0
    return make(op3, frames=200, root_offset=slide)


def on_one_leg_with_the_weight_on_both(op3, make):
    trajectory = make(op3)
    return dataclasses.replace(trajectory, contacts=trajectory.contacts & [True, False])


def limbs_out_of_step(op3, make):
    """Both arms and the head sway slowly, each in its own irregular rhythm."""
    rng, time = np.random.default_rng(1), np.arange(200) / 50.0
    joints = {
        name: 0.15 * sum(np.sin(2 * np.pi * f * time + rng.uniform(0, 6)) for f in rng.uniform(0.5, 1.5, 2))
        for name in ("l_sho_pitch", "r_sho_pitch", "head_pan")
    }
    return make(op3, frames=200, joints=joints)


def contorted(op3, make):
    """Legs lifted to the sides of the trunk, which rests on the floor, arms folded behind it."""
    left = {"l_sho_pitch": 2.15, "l_sho_roll": 0.36, "l_el": 1.1, "l_hip_roll": 0.07, "l_hip_pitch": 1.51}
    right = {"r" + name[1:]: -value for name, value in left.items()}
    joints = {name: np.full(50, value) for name, value in (left | right).items()}
    return make(op3, root_offset=[0, 0, -0.202], joints=joints, contacts=False)


Maker = Callable[[RobotDescription, Callable[..., RobotTrajectory]], RobotTrajectory]
KINEMATIC: dict[str, tuple[Maker, Level]] = {
    "joint_range": (out_of_range, "default"),
    "joint_velocity": (too_fast, "default"),
    "joint_acceleration": (too_much_acceleration, "default"),
    "jerk": (shaky, "strict"),
    "self_collision": (crossed_legs, "default"),
    "ground_penetration": (sunk, "default"),
    "floating": (hovering, "default"),
    "foot_skate": (skating, "default"),
    "foot_skate_peak": (one_slip, "default"),
    "zmp_outside": (on_one_leg_with_the_weight_on_both, "strict"),
    "temporal_coherence": (limbs_out_of_step, "default"),
    "spatial_coherence": (contorted, "default"),
}


@pytest.mark.parametrize("maker", [in_the_air_without_a_flag, lambda *to: without_flags(hovering(*to))])
def test_floating_asks_no_flags(maker, op3, standing):
    judgement = judge(maker(op3, standing), op3, physics=False)
    (check,) = judgement.verdict.failures
    assert check.name == "floating" and check.worst_item == op3.root_body and 0.014 < check.value < 0.021


def without_flags(trajectory):
    return dataclasses.replace(trajectory, contacts=np.zeros_like(trajectory.contacts))


@pytest.mark.parametrize("name", ["op3", "g1"])
def test_a_jump_that_gravity_allows_does_not_float(name, standing):
    """Take-off at 1 m/s: 51 mm high, 0.2 s long."""
    robot = load_robot(name)
    time = np.arange(200) / 200.0 - 0.4
    jump = np.zeros((200, 3))
    jump[:, 2] = np.maximum(time - 9.81 / 2 * time**2, 0.0) * (time > 0)
    judgement = judge(standing(robot, frames=200, fps=200.0, root_offset=jump, contacts=False), robot, physics=False)
    assert "floating" not in {check.name for check in judgement.verdict.failures}


@pytest.mark.parametrize("name", KINEMATIC)
def test_a_trajectory_that_breaks_one_rule(name, op3, standing):
    maker, level = KINEMATIC[name]
    judgement = judge(maker(op3, standing), op3, physics=False, level=level)
    assert {check.name for check in judgement.verdict.failures} == {name}, judgement.verdict.checks
    (check,) = judgement.verdict.failures
    assert check.meaning and check.unit


@pytest.fixture(scope="module")
def played(op3, standing) -> tuple[Reference, Playback]:
    """A standing robot, played."""
    reference = make_reference(standing(op3), op3, judging_model(op3))
    return reference, play(set_stage(reference), LIMITS)


def moved(playback: Playback, body: int | slice, by: float) -> np.ndarray:
    positions = playback.body_pos.copy()
    positions[:, body, 0] += by
    return positions


PLAYED: dict[str, Callable[[Reference, Playback], dict[str, object]]] = {
    "fall_height": lambda r, p: {"height_error": p.height_error + 0.2},
    "fall_orientation": lambda r, p: {"orientation_error": p.orientation_error + 0.9},
    "mpjpe_global": lambda r, p: {"body_pos": moved(p, slice(None), 0.2)},
    "mpjpe_relative": lambda r, p: {"body_pos": moved(p, r.model.body("l_el_link").id, 0.25)},
    "joint_velocity_error": lambda r, p: {"joint_vel": p.joint_vel + 1.5},
    "torque_peak": lambda r, p: {"needed": p.needed + 1.8 * r.robot.effort},
    "torque_saturation": lambda r, p: {"saturated": np.maximum(p.saturated, 0.5)},
    "power_peak": lambda r, p: {"power": p.power + 1.01 * motor(r).supply_power},
    "servo_heat": lambda r, p: {"heating": p.heating + 46.0},
}


@pytest.mark.parametrize("name", PLAYED)
def test_a_playback_that_breaks_one_rule(name, played):
    reference, playback = played
    limits = load_thresholds("default", scale=size_scale(reference.robot, reference.model))
    checks = playback_checks(reference, playback, limits, "free")
    assert all(check.passed for check in checks)
    broken = dataclasses.replace(playback, **PLAYED[name](reference, playback))
    checks = playback_checks(reference, broken, limits, "free")
    assert {check.name for check in checks if not check.passed} == {name}


def spread(playback: Playback, name: str, *, frame: int, joint: int, value: float) -> Playback:
    """The playback with one value of one array changed."""
    values = np.array(getattr(playback, name))
    values[frame, joint] = value
    return dataclasses.replace(playback, **{name: values})


def test_heat_is_that_of_the_hottest_moment(played):
    reference, playback = played
    hot = spread(playback, "heating", frame=20, joint=3, value=46.0)
    limits = load_thresholds("default", scale=size_scale(reference.robot, reference.model))
    (check,) = (c for c in playback_checks(reference, hot, limits, "free") if c.name == "servo_heat")
    assert not check.passed and check.worst_frame == 20 and check.worst_item == reference.robot.joint_names[3]


def test_saturation_is_that_of_the_busiest_servo(played):
    reference, playback = played
    saturated = np.zeros_like(playback.saturated)
    saturated[::2, 5] = 1.0
    busy = dataclasses.replace(playback, saturated=saturated)
    limits = load_thresholds("default", scale=size_scale(reference.robot, reference.model))
    (check,) = (c for c in playback_checks(reference, busy, limits, "free") if c.name == "torque_saturation")
    assert check.value == pytest.approx(0.5) and check.worst_item == reference.robot.joint_names[5]


def test_a_motion_that_seldom_succeeds():
    limit = load_thresholds("default", scale=1.0)["robustness"]
    assert not robustness_check(Robustness(runs=20, stood=10), limit).passed
    assert robustness_check(Robustness(runs=20, stood=20), limit).passed


def test_no_check_is_left_out(op3, played):
    """Every threshold belongs to a check, every check is broken above."""
    reference, playback = played
    limits = load_thresholds("default", scale=1.0)
    checks = kinematic_checks(reference, limits, "free", 1.0) + playback_checks(reference, playback, limits, "free")
    assert {check.name for check in checks} | {"robustness"} == set(limits)
    assert KINEMATIC.keys() | PLAYED.keys() | {"robustness"} == set(limits)


@pytest.mark.parametrize("name", load_thresholds("default", scale=1.0))
def test_levels_are_ordered(name):
    limits: list[Threshold] = [load_thresholds(level, scale=1.0)[name] for level in LEVELS]
    values = [limit.limit * (-1 if limit.minimum else 1) for limit in limits]
    assert values == sorted(values)
    assert limits[0].source and limits[0].unit


def test_a_somersault_fails_in_physics(op3, standing):
    """The reference turns over backwards in the air as if nothing weighed anything."""
    frames = 150
    turn = np.clip((np.arange(frames) - 30) / 90, 0, 1) * -2 * np.pi
    rise = np.zeros((frames, 3))
    rise[:, 2] = 0.25 * (1 - np.cos(turn)) / 2
    trajectory = standing(op3, frames=frames, root_offset=rise)
    flying = (turn != 0) & (turn != turn[-1])
    trajectory = dataclasses.replace(
        trajectory,
        root_quat=Rotation.from_rotvec(turn[:, None] * [0, 1, 0]).as_quat(scalar_first=True),
        contacts=np.repeat(~flying[:, None], 2, axis=1),
    )
    judgement = judge(trajectory, op3)
    assert {"fall_height", "fall_orientation"} & {check.name for check in judgement.verdict.failures}
