"""The stream: limits hold whatever comes, nothing looks ahead, feet stay where they land, bad input is named."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.solve.online import Configuration, OnlineRetargeter
from ros_free_stack.errors import InvalidMessage, InvalidOption
from ros_free_stack.messages import HumanMotion
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import INDEX

RETARGETERS = {name: OnlineRetargeter(load_robot(name)) for name in ("op3", "g1")}


@pytest.fixture(params=RETARGETERS)
def retargeter(request) -> OnlineRetargeter:
    return RETARGETERS[request.param]


def follow(retargeter: OnlineRetargeter, joints: np.ndarray, times: np.ndarray) -> list[Configuration]:
    retargeter.reset()
    return [retargeter.step(frame, float(time)) for frame, time in zip(joints, times, strict=True)]


def stream(retargeter: OnlineRetargeter, motion: HumanMotion) -> list[Configuration]:
    return follow(retargeter, motion.joints, np.arange(len(motion.joints)) / motion.fps)


def excess(retargeter: OnlineRetargeter, frames: list[Configuration]) -> tuple[float, float, float]:
    """Largest excess over range (rad), speed (rad/s) and acceleration (rad/s^2), by finite differences."""
    robot = retargeter.geometry.robot
    joints, times = np.array([frame.joint_pos for frame in frames]), np.array([frame.time_s for frame in frames])
    pause = np.diff(times)[:, None]
    speed = np.diff(joints, axis=0) / pause
    acceleration = np.diff(np.vstack([np.zeros_like(speed[:1]), speed]), axis=0) / pause
    return (
        float(np.maximum(robot.lower - joints, joints - robot.upper).max()),
        float((np.abs(speed) - robot.velocity).max()),
        float((np.abs(acceleration) - robot.acceleration).max()),
    )


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), jump=st.floats(0.0, 1.0))
@pytest.mark.parametrize("name", RETARGETERS)
def test_no_limit_is_ever_exceeded(name: str, seed: int, jump: float, motions: dict[str, HumanMotion]):
    """Limbs that leap about, at frame rates that change: at most 1e-6 over any limit."""
    rng = np.random.default_rng(seed)
    joints = motions["steps"].joints[:40] + jump * rng.normal(size=(40, 22, 3)) * (rng.random((40, 1, 1)) < 0.5)
    frames = follow(RETARGETERS[name], joints, np.cumsum(rng.uniform(0.005, 0.06, 40)))
    assert max(excess(RETARGETERS[name], frames)) <= 1e-6


def test_gentle_motion_is_followed(retargeter, motions):
    for name in ("wave", "squat"):
        frames = stream(retargeter, replace(motions[name], fps=15.0))
        assert not any(frame.tracking_errors.keys() & {"pelvis", "left_sole", "right_sole"} for frame in frames[5:]), (
            name
        )
        assert max(excess(retargeter, frames)) <= 1e-6
        assert all(frame.contacts.all() for frame in frames[10:])


def test_feet_alternate_and_travel(retargeter, motions):
    frames = stream(retargeter, motions["steps"])
    contacts = np.array([frame.contacts for frame in frames])
    assert contacts[:14].all(axis=1).sum() > 8
    assert (~contacts).sum(axis=0).min() > 8
    assert frames[-1].root_pos[0] > 0.3 * retargeter.geometry.hip_height


def test_same_stream_gives_the_same_bytes_and_nothing_looks_ahead(retargeter, motions):
    whole, part = (stream(retargeter, HumanMotion(motions["steps"].joints[:count], 20.0)) for count in (60, 35))
    for first, second in zip(whole, part, strict=False):
        assert first.joint_pos.tobytes() == second.joint_pos.tobytes()
        assert first.root_pos.tobytes() == second.root_pos.tobytes()


def test_the_virtual_machine_gives_the_same(motions):
    here, there = (
        stream(retargeter, HumanMotion(motions["wave"].joints[:15], 20.0))
        for retargeter in (RETARGETERS["op3"], OnlineRetargeter(load_robot("op3"), machine_code=False))
    )
    for compiled, interpreted in zip(here, there, strict=True):
        np.testing.assert_allclose(compiled.joint_pos, interpreted.joint_pos, atol=1e-6)


def test_feet_that_are_too_near_each_other_do_not_shake_the_body(motions):
    """Footholds that the shins have no room above: limbs and footholds must not pull against each other."""
    retargeter, joints = RETARGETERS["op3"], np.array(motions["stand"].joints)
    for side, sign in (("left", -1), ("right", 1)):
        joints[:, INDEX[f"{side}_foot"], 1] += sign * 0.03
    frames = stream(retargeter, HumanMotion(joints, 20.0))
    moved = np.abs(np.diff([frame.joint_pos for frame in frames], axis=0)).max()
    assert moved < 0.02
    assert all(frame.contacts.all() for frame in frames)


def test_heading_and_place_of_the_person_do_not_matter(retargeter, motions):
    turned = np.array(motions["steps"].joints[:40]) @ np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])
    moved = HumanMotion(turned + np.array([3.0, -2.0, 0.4]), 20.0)
    here, there = (stream(retargeter, motion) for motion in (HumanMotion(motions["steps"].joints[:40], 20.0), moved))
    np.testing.assert_allclose(here[-1].joint_pos, there[-1].joint_pos, atol=1e-4)
    np.testing.assert_allclose(here[-1].root_pos, there[-1].root_pos, atol=1e-4)


def test_wherever_it_starts_it_comes_to_the_same_pose(motions):
    """OP3's arms of three joints have several poses that are equally near; G1's lead to one."""
    retargeter, joints = RETARGETERS["g1"], motions["wave"].joints
    late = stream(retargeter, HumanMotion(joints[50:], 20.0))
    early = stream(retargeter, motions["wave"])[50:]
    apart = np.abs(np.array([frame.joint_pos for frame in late]) - [frame.joint_pos for frame in early]).max(axis=1)
    assert apart[20:].max() < 0.02


def test_what_is_out_of_reach_is_reported(retargeter, motions):
    joints = np.array(motions["stand"].joints)
    joints[:, INDEX["left_knee"]] += [-0.6, 0, 0.2]
    frames = stream(retargeter, HumanMotion(joints, 20.0))
    assert any("left_knee" in frame.tracking_errors for frame in frames)
    assert all(error > 0 for frame in frames for error in frame.tracking_errors.values())


def test_a_head_bows(motions):
    retargeter = RETARGETERS["op3"]
    joints = np.array(motions["stand"].joints)
    joints[10:, INDEX["head"]] += [0.08, 0, -0.04]
    frames = stream(retargeter, HumanMotion(joints, 20.0))
    tilt = retargeter.geometry.robot.joint_names.index("head_tilt")
    assert abs(frames[-1].joint_pos[tilt] - frames[5].joint_pos[tilt]) > 0.2


@pytest.mark.parametrize("bad", [np.zeros((21, 3)), np.full((22, 3), np.nan), np.zeros((0, 3)), np.zeros((2, 22, 3))])
def test_refuses_bad_frames(retargeter, bad):
    retargeter.reset()
    with pytest.raises(InvalidMessage, match="joints"):
        retargeter.step(bad, 0.0)


@pytest.mark.parametrize("time", [0.0, -1.0, np.nan, np.inf])
def test_refuses_time_that_does_not_go_on(retargeter, motions, time):
    retargeter.reset()
    retargeter.step(motions["stand"].joints[0], 0.0)
    with pytest.raises(InvalidOption, match="time_s"):
        retargeter.step(motions["stand"].joints[1], time)


def test_refuses_a_stride_of_nothing():
    with pytest.raises(InvalidOption, match="stride"):
        OnlineRetargeter(load_robot("op3"), stride=0.0)
