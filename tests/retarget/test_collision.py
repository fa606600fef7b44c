"""Limbs are kept apart: capsules cover the robot, distances and their derivatives are right, motions obey them."""

import casadi as ca
import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize

from retarget.body.collision import APPROACH_RATE, Collision, capsule_limbs, nearest_points
from retarget.body.geometry import measure
from retarget.describe.capsules import distance_outside, fit_capsules, hull_surface
from retarget.pipeline import retarget
from ros_free_stack.messages import HumanMotion
from ros_free_stack.robot_model import joint_addresses, robot_spec
from ros_free_stack.robots import load_robot
from ros_free_stack.skeleton import FPS, INDEX

A, B, C, D = (ca.SX.sym(name, 3) for name in "abcd")
NEAREST_POINTS = ca.Function("nearest", [A, B, C, D], list(nearest_points(A, B, C, D)))

segments = arrays(np.float64, (4, 3), elements=st.floats(-1, 1, width=32))


@pytest.fixture(scope="module", params=["op3", "g1"])
def robot(request: pytest.FixtureRequest):
    return load_robot(request.param)


@pytest.fixture(scope="module")
def full_model(robot):
    return robot_spec(robot).compile()


@pytest.fixture(scope="module")
def surfaces(robot, full_model):
    """Points on the hulls of every body that has capsules."""
    return {body: hull_surface(full_model, full_model.body(body).id, spacing=0.006) for body in robot.capsules}


@pytest.fixture(scope="module")
def collision(robot):
    return Collision(measure(robot))


def test_capsules_cover_the_collision_shapes(robot, surfaces):
    for body, capsules in robot.capsules.items():
        assert distance_outside(surfaces[body], capsules).max() < 1e-3, body


def test_capsules_are_no_wider_than_the_collision_shapes(robot, surfaces):
    for body, capsules in robot.capsules.items():
        widest = np.linalg.norm(np.ptp(surfaces[body], axis=0)) / 2
        assert all(capsule.radius < 1.05 * widest for capsule in capsules), body


def test_fit_finds_the_capsule_it_was_given():
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(3000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    start, end = np.array([0.01, 0.02, -0.1]), np.array([0.03, -0.01, 0.12])
    points = start + rng.uniform(size=(3000, 1)) * (end - start) + 0.04 * directions
    (found,) = fit_capsules(points)
    assert found.radius == pytest.approx(0.04, abs=1e-3)
    ends = sorted([found.start, found.end], key=lambda point: point[2])
    np.testing.assert_allclose(ends, [start, end], atol=4e-3)
    assert distance_outside(points, (found,)).max() < 2e-4


def test_more_cells_follow_a_box_more_closely():
    grid = np.stack(np.meshgrid(*[np.linspace(-1, 1, 9)] * 3), axis=-1).reshape(-1, 3)
    box = grid[np.abs(grid).max(axis=1) == 1] * [0.05, 0.06, 0.08]
    one, four = fit_capsules(box), fit_capsules(box, (2, 2, 1))
    assert len(four) == 4
    assert max(capsule.radius for capsule in four) < 0.8 * one[0].radius
    assert distance_outside(box, four).max() < 2e-4


@settings(deadline=None, max_examples=60)
@given(segments)
def test_nearest_points_are_no_farther_than_any_others(ends):
    a, b, c, d = ends
    p, q = (np.array(point)[:, 0] for point in NEAREST_POINTS(*ends))

    def squared(shares):
        s, t = shares
        return float(np.sum((a + s * (b - a) - c - t * (d - c)) ** 2))

    best = min(minimize(squared, start, bounds=[(0, 1)] * 2).fun for start in ([0, 0], [1, 1], [0, 1], [0.5, 0.5]))
    assert np.linalg.norm(p - q) <= np.sqrt(best) + 1e-4
    for point, start, end in ((p, a, b), (q, c, d)):
        length = np.linalg.norm(end - start)
        assert np.linalg.norm(point - start) + np.linalg.norm(end - point) == pytest.approx(length, abs=1e-9)


def nearest(geometry, left: np.ndarray) -> np.ndarray:
    """The pair of capsules that is nearest of each two limbs."""
    limbs = capsule_limbs(geometry)
    return np.array([min(np.flatnonzero(limbs == limb), key=lambda pair: left[pair]) for limb in range(limbs[-1] + 1)])


def test_jacobian_is_the_derivative_of_the_distances(robot, collision):
    geometry = measure(robot)
    model, rng = geometry.model, np.random.default_rng(0)
    qpos = geometry.standing.copy()
    qpos[geometry.qpos_index] = rng.uniform(robot.lower, robot.upper) / 2
    before, still = collision.distances(qpos), np.zeros(model.nv)
    near = nearest(geometry, before - collision.margins)
    approach = collision.approach(qpos, np.inf, len(near), still)
    assert len(near) >= 5
    for dof in range(model.nv):
        velocity = np.zeros(model.nv)
        velocity[dof] = 1e-6
        moved = qpos.copy()
        mujoco.mj_integratePos(model, moved, velocity, 1.0)
        change = (collision.distances(moved) - before)[near] / 1e-6
        np.testing.assert_allclose(approach.jacobian[:, dof], change, atol=1e-4)


def test_standing_pose_keeps_its_margins(robot, collision):
    assert np.all(collision.distances(measure(robot).standing) >= collision.margins - 1e-12)
    assert collision.margins.max() > 0


def test_limbs_approach_by_a_share_of_the_distance_left(robot, collision):
    geometry = measure(robot)
    standing, still = geometry.standing, np.zeros(geometry.model.nv)
    left = collision.distances(standing) - collision.margins
    left = left[nearest(geometry, left)]
    np.testing.assert_allclose(collision.approach(standing, np.inf, len(left), still).least, -left)
    least = collision.approach(standing, 0.02, len(left), still).least
    assert np.all(least <= 0)
    np.testing.assert_allclose(least, -(1 - np.exp(-APPROACH_RATE * 0.02)) * left)


def test_takes_the_nearest_pair_of_each_two_limbs(robot, collision):
    geometry = measure(robot)
    left = collision.distances(geometry.standing) - collision.margins
    approach = collision.approach(geometry.standing, np.inf, 5, np.zeros(geometry.model.nv))
    np.testing.assert_allclose(np.sort(-approach.least), np.sort(left[nearest(geometry, left)])[:5])


def test_limbs_that_are_about_to_meet_come_first(robot, collision):
    geometry = measure(robot)
    standing = geometry.standing
    left = collision.distances(standing) - collision.margins
    left, still = left[nearest(geometry, left)], np.zeros(geometry.model.nv)
    every = collision.approach(standing, 0.02, len(left), still)
    pair = int(np.argmax(np.where(left < 0.08, left, 0.0)))
    step = -every.jacobian[pair] / (every.jacobian[pair] @ every.jacobian[pair]) * left[pair] / 5
    chosen = (collision.approach(standing, 0.02, 1, still), collision.approach(standing, 0.02, 1, step))
    assert chosen[0].least.item() == pytest.approx(every.least.max())
    assert chosen[1].jacobian[0] @ step < 0.5 * chosen[0].jacobian[0] @ step - 1e-6


def crossed_arms(motion: HumanMotion) -> HumanMotion:
    """The same motion with both hands driven through each other and through the trunk."""
    joints = motion.joints.copy()
    share = np.sin(np.linspace(0, np.pi, len(joints)))[:, None] ** 2
    for side, across in (("left", -0.12), ("right", 0.12)):
        for name, height, depth in (("elbow", 0.15, 0.0), ("wrist", 0.2, 0.08)):
            goal = joints[:, INDEX["pelvis"]] + [depth, across, height]
            place = joints[:, INDEX[f"{side}_{name}"]]
            joints[:, INDEX[f"{side}_{name}"]] = place + share * (goal - place)
    return HumanMotion(joints, FPS, prompt="crossed", source="test")


@pytest.mark.parametrize("balance", [False, True])
def test_arms_that_cross_stay_apart_on_the_real_shapes(robot, full_model, collision, motions, balance):
    trajectory = retarget(crossed_arms(motions["stand"]), robot, balance=balance).trajectory
    data = mujoco.MjData(full_model)
    positions, _ = joint_addresses(full_model, robot)
    pairs = {frozenset(full_model.body(name).id for name in pair) for pair in robot.collision_pairs}
    least, deepest = np.inf, 0.0
    for k in range(len(trajectory.joint_pos)):
        data.qpos[:7] = [*trajectory.root_pos[k], *trajectory.root_quat[k]]
        data.qpos[positions] = trajectory.joint_pos[k]
        mujoco.mj_kinematics(full_model, data)
        mujoco.mj_collision(full_model, data)
        for geoms, distance in zip(data.contact.geom, data.contact.dist, strict=True):
            if frozenset(full_model.geom_bodyid[geoms].tolist()) in pairs:
                deepest = max(deepest, -float(distance))
        least = min(least, float(collision.distances(data.qpos).min()))
    assert deepest < 1e-3
    assert least < 0.02, "the arms never came near each other: the motion tests nothing"
