import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.body.geometry import measure
from retarget.solve.limits import JointBounds, reach
from ros_free_stack.robots import load_robot


def allowed(bounds: JointBounds, position: np.ndarray, step: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least and largest next positions."""
    low, high = (np.array(value)[:, 0] for value in reach(ca.DM(position), ca.DM(step), ca.DM(bounds.table)))
    return position + low, position + high


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    acceleration=st.floats(0.5, 200),
    speed=st.floats(0.5, 40),
    greedy=st.booleans(),
)
def test_bounds_never_contradict_each_other(seed: int, acceleration: float, speed: float, greedy: bool):
    """Whatever is chosen inside the bounds, at whatever rates, the next bounds are not empty and all limits hold."""
    rng = np.random.default_rng(seed)
    joints = 8
    lower, upper = -rng.uniform(0.01, 2, joints), rng.uniform(0.01, 2, joints)
    position, velocity = rng.uniform(lower, upper), np.zeros(joints)
    for _ in range(80):
        dt = rng.uniform(0.004, 0.05)
        full = np.full(joints, 1.0)
        bounds = JointBounds(lower, upper, speed * dt * full, acceleration * dt**2 * full)
        low, high = allowed(bounds, position, velocity * dt)
        assert (low <= high + 1e-12).all()
        share = rng.choice([0.0, 1.0], joints) if greedy else rng.uniform(size=joints)
        following = low + share * (high - low)
        assert (following >= lower - 1e-12).all() and (following <= upper + 1e-12).all()
        assert (np.abs(following - position) <= speed * dt + 1e-12).all()
        change = (following - position) / dt - velocity
        assert (np.abs(change) / dt <= acceleration * (1 + 1e-9) + 1e-9).all()
        position, velocity = following, (following - position) / dt


def test_a_joint_far_from_its_range_may_use_its_full_speed():
    robot = load_robot("op3")
    bounds, middle = JointBounds.of(robot, 50.0), (robot.lower + robot.upper) / 2
    _, high = allowed(bounds, middle, bounds.step)
    np.testing.assert_allclose(high - middle, robot.velocity / 50, rtol=1e-6)


@pytest.mark.parametrize("fps", [20.0, 50.0, 125.0])
def test_bounds_stay_a_little_inside_the_limits_at_any_rate(fps: float):
    robot = load_robot("op3")
    bounds = JointBounds.of(robot, fps)
    for step, limit in ((bounds.step * fps, robot.velocity), (bounds.change * fps**2, robot.acceleration)):
        assert (step < limit).all() and (step > 0.99 * limit).all()


def test_a_joint_comes_to_the_end_of_its_range():
    robot = load_robot("op3")
    bounds, position, step = JointBounds.of(robot, 50.0), robot.standing_pos, np.zeros(len(robot.joints))
    for _ in range(200):
        _, high = allowed(bounds, position, step)
        position, step = high, high - position
    np.testing.assert_allclose(position, robot.upper, atol=1e-3)


def test_only_a_free_root_moves():
    for name in ("op3", "g1"):
        geometry = measure(load_robot(name))
        bounds = JointBounds.tangent(geometry, 50.0)
        low, high = allowed(bounds, np.zeros(geometry.model.nv), np.zeros(geometry.model.nv))
        assert (low[:6] < 0).all() and (high[:6] > 0).all() and np.isfinite(high).all()
