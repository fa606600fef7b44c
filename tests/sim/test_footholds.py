"""Legs that stand on feet which have landed beside their footholds."""

import dataclasses

import mujoco
import numpy as np
import pytest

from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import load_robot
from sim.model import judging_model
from sim.playback.estimation import posed
from sim.playback.footholds import Footholds
from sim.playback.physics import set_stage
from sim.reference import make_reference

LIFTED_S, LANDED_S = 0.4, 0.6
"""Times of the motion between which the left foot does not stand."""


@pytest.fixture(scope="module", params=["op3", "g1", "t1"])
def step(request, standing):
    """A robot that stands, whose left foot is said to be off the floor for a while."""
    robot = load_robot(request.param)
    trajectory = standing(robot, frames=60)
    contacts = trajectory.contacts.copy()
    contacts[int(LIFTED_S * 50) : int(LANDED_S * 50), robot.foot_names.index("left")] = False
    model = judging_model(robot)
    return set_stage(make_reference(dataclasses.replace(trajectory, contacts=contacts), robot, model))


def soles(stage, qpos):
    """(2, 2) m, the middles of the soles over the floor."""
    data = mujoco.MjData(stage.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(stage.model, data)
    middles = [
        data.body(sole.body).xpos + data.body(sole.body).xmat.reshape(3, 3) @ np.mean(sole.corners, axis=0)
        for sole in stage.reference.robot.soles.values()
    ]
    return np.array(middles)[:, :2]


def cycle_at(stage, seconds):
    return int((stage.plan.hold_s + seconds) / stage.plan.cycle_s)


def followed(stage, believed, until_s):
    """What is added to the joints at the end, when the robot is believed to be in a pose all the time."""
    footholds = Footholds(stage.model, stage.reference.robot, stage.plan)
    return [footholds.follow(cycle, believed)[1] for cycle in range(cycle_at(stage, until_s))][-1]


def test_nothing_is_added_on_the_planned_footholds(step):
    data = mujoco.MjData(step.model)
    data.qpos[:] = step.plan.qpos[0]
    assert followed(step, posed(step.model, data), 1.0) == pytest.approx(0.0, abs=1e-4)


def test_legs_reach_where_a_foot_has_landed(step):
    robot, model, plan = step.reference.robot, step.model, step.plan
    addresses, _ = joint_addresses(model, robot)
    name = next(name for name in robot.joint_names if "l" in name.lower()[:4] and "hip_roll" in name.lower())
    place = robot.joint_names.index(name)
    wide = plan.qpos[0].copy()
    wide[addresses[place]] += 0.08
    data = mujoco.MjData(model)
    data.qpos[:] = wide
    believed = posed(model, data)
    before, after = followed(step, believed, LIFTED_S), followed(step, believed, 1.0)
    assert before == pytest.approx(0.0, abs=1e-3), "a foot that has not stepped keeps its planned place"
    reached = plan.qpos[0].copy()
    reached[addresses] += after
    apart, wanted, planned = (np.subtract(*soles(step, qpos)) for qpos in (reached, wide, plan.qpos[0]))
    assert np.linalg.norm(wanted - planned) > 0.015
    assert apart == pytest.approx(wanted, abs=0.15 * float(np.linalg.norm(wanted - planned)))


def test_the_body_goes_over_with_the_weight(step):
    """On one foot the plan is where that foot is, on two where the weight is between them."""
    data = mujoco.MjData(step.model)
    data.qpos[:] = step.plan.qpos[0]
    data.qpos[0] += 0.03
    footholds = Footholds(step.model, step.reference.robot, step.plan)
    believed = posed(step.model, data)
    for seconds in (0.2, 0.5, 0.9):
        assert footholds.follow(cycle_at(step, seconds), believed)[0] == pytest.approx([0.03, 0.0], abs=1e-4)
