import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from retarget.limits import JointBounds
from ros_free_stack.robots import load_robot


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    change=st.floats(1e-3, 0.3),
    step=st.floats(1e-2, 0.5),
    greedy=st.booleans(),
)
def test_bounds_never_contradict_each_other(seed: int, change: float, step: float, greedy: bool):
    """Whatever is chosen inside the bounds, the next bounds are not empty and all three limits hold."""
    rng = np.random.default_rng(seed)
    joints = 8
    lower, upper = -rng.uniform(0.01, 2, joints), rng.uniform(0.01, 2, joints)
    bounds = JointBounds(lower, upper, np.full(joints, step), np.full(joints, change))
    position, last = rng.uniform(lower, upper), np.zeros(joints)
    for _ in range(80):
        low, high = bounds.reach(position, last)
        assert (low <= high + 1e-12).all()
        share = rng.choice([0.0, 1.0], joints) if greedy else rng.uniform(size=joints)
        following = low + share * (high - low)
        assert (following >= lower - 1e-12).all() and (following <= upper + 1e-12).all()
        assert (np.abs(following - position) <= step + 1e-12).all()
        assert (np.abs(following - position - last) <= change + 1e-9).all()
        position, last = following, following - position


def test_a_joint_far_from_its_range_may_use_its_full_speed():
    robot = load_robot("op3")
    bounds = JointBounds.of(robot, 50.0)
    _, high = bounds.reach((robot.lower + robot.upper) / 2, bounds.step)
    np.testing.assert_allclose(high - (robot.lower + robot.upper) / 2, robot.velocity / 50, rtol=1e-6)
