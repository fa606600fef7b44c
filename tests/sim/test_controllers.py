"""Controllers, actuators and the state estimate, on motions whose answer is known."""

import dataclasses

import mujoco
import numpy as np
import pytest

from ros_free_stack.errors import UnknownName
from ros_free_stack.robot_model import add_floor, joint_addresses
from ros_free_stack.robots import load_robot
from sim.judge.zmp import zero_moment_point
from sim.model import TIMESTEP_S, judging_model
from sim.playback.actuation import read_servos
from sim.playback.controllers import corner_loads, make_controller
from sim.playback.estimation import EncodersAndImu, SensorNoise, TrueState
from sim.playback.physics import Disturbance, FallLimits, play, set_stage
from sim.reference import make_reference

LIMITS = FallLimits(0.1, 0.8)


@pytest.fixture(scope="module")
def sway(op3, standing):
    """A slow squat of OP3: knees and hips bend together, soles stay flat."""
    depth = 0.25 * (1 - np.cos(2 * np.pi * np.arange(100) / 100))
    start = op3.standing
    signs = {"l_hip_pitch": -1, "l_knee": 2, "l_ank_pitch": 1, "r_hip_pitch": 1, "r_knee": -2, "r_ank_pitch": -1}
    joints = {name: start[name] + sign * depth for name, sign in signs.items()}
    height = np.zeros((100, 3))
    height[:, 2] = 0.22 * (np.cos(0.35 + depth) - np.cos(0.35))
    return set_stage(
        make_reference(standing(op3, frames=100, joints=joints, root_offset=height), op3, judging_model(op3))
    )


@pytest.mark.parametrize("controller", ["pd", "default", "wbc"])
@pytest.mark.parametrize("state", ["true", "estimated"])
def test_every_controller_squats(sway, controller, state):
    playback = play(sway, LIMITS, controller=controller, state=state)
    assert playback.fell_at_s is None and playback.controller == controller
    assert np.abs(playback.joint_pos - sway.reference.trajectory.joint_pos).max() < 0.2


def test_feedforward_tracks_better_than_plain_servos(sway):
    planned = sway.reference.trajectory.joint_pos
    plain, fed = (play(sway, LIMITS, controller=name).joint_pos - planned for name in ("pd", "default"))
    assert np.abs(fed).mean() < 0.5 * np.abs(plain).mean()


def test_unknown_controller(sway):
    with pytest.raises(UnknownName, match="default, pd, wbc"):
        make_controller("magic", sway.model, sway.reference.robot, sway.servos, sway.plan)  # pyright: ignore[reportArgumentType]


def test_the_zmp_is_where_the_floor_pushes(sway):
    """MuJoCo's own contact forces, against inverse dynamics of the poses that it simulated."""
    playback = play(sway, LIMITS)
    zmp = zero_moment_point(sway.model, playback.qpos, sway.reference.trajectory.fps)
    middle = slice(10, 90)
    assert zmp[middle] == pytest.approx(playback.pressure[middle], abs=0.004)


def test_a_block_slides_as_far_as_friction_lets_it():
    """v^2 / (2 mu g) on the judge's floor and time step."""
    spec = mujoco.MjSpec()
    spec.option.timestep, spec.option.integrator = TIMESTEP_S, mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    add_floor(spec)
    body = spec.worldbody.add_body(pos=[0, 0, 0.05])
    body.add_freejoint()
    body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.2, 0.2, 0.05], mass=1.0)
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 200)
    start = data.qpos[0]
    data.qvel[0] = 1.0
    mujoco.mj_step(model, data, 500)
    friction = model.geom_friction[0, 0]
    assert data.qpos[0] - start == pytest.approx(1.0 / (2 * friction * 9.81), rel=0.1)


def test_bare_motors_get_a_position_loop():
    """H1's model has torque motors; a trajectory of angles needs servos."""
    robot = load_robot("h1")
    servos = read_servos(judging_model(robot), robot)
    assert (servos.kp > 100).all() and (servos.kd > 1).all()
    angles, speeds, torques = np.full(19, 0.1), np.full(19, 0.2), np.full(19, 5.0)
    goals = servos.goals(angles, speeds, torques)
    assert servos.kp * (goals - angles) - servos.kd * speeds == pytest.approx(torques)


CORNERS = np.array([[x, y, 0.0] for y in (0.12, 0.08, -0.08, -0.12) for x in (-0.05, 0.05)])
"""Of two soles beside each other, the left one first."""


@pytest.mark.parametrize("pressure", [(0.0, 0.0), (0.02, 0.05), (-0.04, -0.11), (0.05, 0.12)])
def test_loads_put_the_pressure_where_it_is_wanted(pressure):
    loads = corner_loads(CORNERS, np.array(pressure))
    assert (loads >= 0).all() and loads.sum() == pytest.approx(1.0, abs=1e-3)
    assert loads @ CORNERS[:, :2] == pytest.approx(pressure, abs=5e-4)


def test_loads_reach_no_further_than_the_soles():
    loads = corner_loads(CORNERS, np.array([0.0, 0.3]))
    assert loads[:2] == pytest.approx([0.5, 0.5], abs=0.02) and loads[2:] == pytest.approx(np.zeros(6), abs=0.02)


def test_even_loads_under_the_middle():
    assert corner_loads(CORNERS, np.zeros(2)) == pytest.approx(np.full(8, 1 / 8), abs=1e-3)


@pytest.mark.parametrize("name", ["op3", "g1", "t1", "h1"])
def test_a_robot_that_drifts_to_its_left_presses_with_its_left_leg(standing, name):
    """What the servos give beyond the plan is -J' f of floor forces that move to the left foot: virtual work."""
    robot = load_robot(name)
    model = judging_model(robot)
    stage = set_stage(make_reference(standing(robot), robot, model))
    controller = make_controller("default", model, robot, stage.servos, stage.plan)
    data = mujoco.MjData(model)
    data.qpos[:] = stage.plan.qpos[0]
    truth = TrueState(model)
    rest = controller.goals(0, 0, truth.believe(0, data))
    data.qvel[1] = 0.02
    torque = np.zeros(model.nv)
    torque[joint_addresses(model, robot)[1]] = stage.servos.kp * (controller.goals(0, 0, truth.believe(0, data)) - rest)
    left, right = (_leg_stretch(model, data, robot, foot) for foot in ("left", "right"))
    assert torque @ left > 0 > torque @ right


def _leg_stretch(model, data, robot, foot):
    """(nv,) joint speeds that push one sole down, with the root held."""
    mujoco.mj_forward(model, data)
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(
        model, data, jacobian, None, data.body(robot.soles[foot].body).xpos, model.body(robot.soles[foot].body).id
    )
    jacobian[:, :6] = 0.0
    return np.linalg.pinv(jacobian) @ np.array([0.0, 0.0, -1.0])


def test_servos_act_on_whole_steps(op3):
    servos = read_servos(judging_model(op3), op3)
    angles = np.linspace(-1, 1, 77)
    rounded = servos.rounded(angles)
    assert servos.resolution == pytest.approx(2 * np.pi / 4096)
    assert np.abs(rounded - angles).max() <= servos.resolution / 2 + 1e-12
    assert rounded / servos.resolution == pytest.approx(np.round(rounded / servos.resolution), abs=1e-9)
    assert servos.cycle_steps == 4


def test_the_estimate_is_near_the_truth(sway):
    """A robot that stands where it should: the estimate misses by noise, encoder steps and filter lag only."""
    model, robot = sway.model, sway.reference.robot
    estimator = EncodersAndImu(model, robot, sway.servos, sway.plan, SensorNoise(), np.random.default_rng(0))
    truth = TrueState(model)
    data = mujoco.MjData(model)
    for cycle in range(60, 110):
        data.qpos[:], data.qvel[:] = sway.plan.qpos[cycle], sway.plan.qvel[cycle]
        believed, actual = estimator.believe(cycle, data), truth.believe(cycle, data)
    assert believed.qpos[:3] == pytest.approx(actual.qpos[:3], abs=0.004)
    assert believed.subtree_com[0] == pytest.approx(actual.subtree_com[0], abs=0.004)
    _, dofs = joint_addresses(model, robot)
    assert believed.qvel[dofs] == pytest.approx(actual.qvel[dofs], abs=0.25)
    assert not np.array_equal(believed.qpos, actual.qpos)


def test_the_accelerometer_tells_a_slide_at_once_and_the_legs_overrule_it(sway):
    """The robot slides off as it stands: legs that do not move say that it rests."""
    quiet = SensorNoise(tilt=0.0, rate=0.0, acceleration=0.0)
    robot = sway.reference.robot
    estimator = EncodersAndImu(sway.model, robot, sway.servos, sway.plan, quiet, np.random.default_rng(0))
    data = mujoco.MjData(sway.model)
    data.qpos[:] = sway.plan.qpos[0]
    estimator.believe(0, data)
    data.qvel[0] = 0.1
    speeds = [estimator.believe(cycle, data).qvel[0] for cycle in range(1, 60)]
    assert speeds[0] == pytest.approx(0.1, abs=0.01)
    assert abs(speeds[-1]) < 0.005


def test_a_late_bus_is_worse_than_a_prompt_one(sway):
    late = Disturbance(np.ones(sway.model.nbody), 1.0, 6, np.zeros(3), 0.5, SensorNoise(), 0)
    planned = sway.reference.trajectory.joint_pos
    prompt, slow = (play(sway, LIMITS, disturbance=d).joint_pos - planned for d in (None, late))
    assert np.abs(slow).mean() > 1.5 * np.abs(prompt).mean()


def test_a_push_moves_the_robot(sway):
    pushed = Disturbance(np.ones(sway.model.nbody), 1.0, 0, np.array([0.0, 2.0, 0.0]), 0.4, SensorNoise(), 0)
    assert play(sway, LIMITS, disturbance=pushed).fell_at_s is not None
    held = dataclasses.replace(pushed, push=np.zeros(3))
    assert play(sway, LIMITS, disturbance=held).fell_at_s is None
