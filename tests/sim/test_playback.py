"""Playback against closed forms: weight on the soles, gravity torques, a pendulum, free fall."""

import dataclasses

import mujoco
import numpy as np
import pytest

from ros_free_stack.messages import Mount
from ros_free_stack.robot_model import joint_addresses, standing_qpos
from sim.model import TIMESTEP_S, judging_model
from sim.playback.estimation import SensorNoise
from sim.playback.inverse_dynamics import inverse_dynamics
from sim.playback.physics import Disturbance, FallLimits, play, set_stage
from sim.reference import make_reference


def simulate(robot, trajectory, mount: Mount = "free", **options):
    reference = make_reference(trajectory, robot, judging_model(robot))
    return play(set_stage(reference, mount=mount), FallLimits(0.1, 0.8), **options)


@pytest.mark.parametrize("name", ["op3", "g1"])
def test_soles_carry_the_weight(name, request, standing):
    robot = request.getfixturevalue(name)
    playback = simulate(robot, standing(robot))
    weight = judging_model(robot).body_subtreemass[0] * 9.81
    assert playback.contact_force.sum(axis=1) == pytest.approx(weight, rel=0.02)
    assert playback.torque.max() < 0.5 * robot.effort.max()


@pytest.mark.parametrize("name", ["op3", "g1"])
def test_static_torque_is_the_moment_of_gravity(name, request):
    """On a held robot at rest each joint carries the moment of everything beyond it."""
    robot = request.getfixturevalue(name)
    model = judging_model(robot, mount="fixed")
    data = mujoco.MjData(model)
    addresses, _ = joint_addresses(model, robot)
    rng = np.random.default_rng(0)
    data.qpos[addresses] = robot.lower + rng.uniform(0.3, 0.7, len(robot.lower)) * (robot.upper - robot.lower)
    mujoco.mj_forward(model, data)
    qpos = np.tile(data.qpos, (5, 1))
    torque = inverse_dynamics(model, robot, qpos, np.zeros((5, 2), bool), 0.02).torque
    for place, joint_name in enumerate(robot.joint_names):
        joint = model.joint(joint_name).id
        body = model.jnt_bodyid[joint]
        lever = data.subtree_com[body] - data.xanchor[joint]
        gravity = model.body_subtreemass[body] * np.array([0, 0, -9.81])
        moment = np.cross(lever, gravity) @ data.xaxis[joint]
        assert torque[:, place] == pytest.approx(-moment, abs=1e-6)


def test_feedforward_of_a_standing_robot_balances_it(op3):
    model = judging_model(op3)
    qpos = np.tile(standing_qpos(model, op3), (5, 1))
    standing_torque = inverse_dynamics(model, op3, qpos, np.ones((5, 2), bool), 0.02).torque
    flying_torque = inverse_dynamics(model, op3, qpos, np.zeros((5, 2), bool), 0.02).torque
    knee = op3.joint_names.index("l_knee")
    assert abs(standing_torque[0, knee]) > 3 * abs(flying_torque[0, knee])
    arm = op3.joint_names.index("l_el")
    assert standing_torque[0, arm] == pytest.approx(flying_torque[0, arm], abs=1e-6)


def test_free_fall(op3, standing):
    """Dropped from high up the root follows g t^2 / 2 until it is judged to have fallen."""
    trajectory = standing(op3, frames=40, root_offset=[0, 0, 3.0], contacts=False)
    playback = simulate(op3, trajectory)
    assert playback.fell_at_s is not None
    time_of_fall = playback.fell_at_s + 0.5
    assert 0.5 * 9.81 * time_of_fall**2 == pytest.approx(0.1, rel=0.05)


def test_a_servo_swings_like_a_driven_pendulum(op3, standing):
    """The feedforward of a slow swing in the air tracks it to a fraction of a degree."""
    swing = 0.5 * np.sin(2 * np.pi * 0.5 * np.arange(100) / 50.0)
    playback = simulate(op3, standing(op3, frames=100, joints={"l_sho_pitch": swing}), mount="fixed")
    joint = op3.joint_names.index("l_sho_pitch")
    assert playback.joint_pos[10:90, joint] == pytest.approx(swing[10:90], abs=0.01)
    assert playback.fell_at_s is None and playback.contact_force.max() == 0


def test_a_servo_cannot_outrun_its_speed_torque_line(op3, standing):
    """Asked for twice its no-load speed, a servo stays below it and gives all its torque."""
    ramp = np.clip((np.arange(60) - 10) / 50.0 * 2 * op3.servos.motor.no_load_speed, 0, 1.5)
    playback = simulate(op3, standing(op3, frames=60, joints={"head_pan": ramp}), mount="fixed")
    joint = op3.joint_names.index("head_pan")
    assert 0.5 < playback.joint_vel[:, joint].max() / op3.servos.motor.no_load_speed <= 1.0
    assert playback.saturated[:, joint].max() > 0.5
    assert playback.torque[:, joint].max() == pytest.approx(op3.joints["head_pan"].effort)


def test_collision_shapes_agree_with_the_full_model(op3):
    """Hull vertices alone give the contacts that the original meshes give."""
    from ros_free_stack.robot_model import add_floor, robot_spec
    from sim.model import drop_meshes

    spec = robot_spec(op3)
    drop_meshes(spec, keep=lambda geom: bool(geom.contype or geom.conaffinity))
    add_floor(spec)
    full, light = spec.compile(), judging_model(op3)
    rng = np.random.default_rng(1)
    found = 0
    for _ in range(20):
        pose = rng.uniform(op3.lower, op3.upper)
        expected, depths = (deepest(model, op3, pose) for model in (full, light))
        assert expected.keys() == depths.keys()
        assert depths == pytest.approx(expected, abs=1e-3)
        found += len(expected)
    assert found > 10


def deepest(model, robot, pose):
    """Depth of every pair of bodies that overlaps by more than 1 mm."""
    data = mujoco.MjData(model)
    data.qpos[2] = 1.0
    data.qpos[joint_addresses(model, robot)[0]] = pose
    mujoco.mj_fwdPosition(model, data)
    depths: dict[tuple[int, ...], float] = {}
    for geoms, distance in zip(data.contact.geom, data.contact.dist, strict=True):
        pair = tuple(sorted(int(body) for body in model.geom_bodyid[geoms]))
        if distance < -1e-3:
            depths[pair] = max(depths.get(pair, 0.0), -float(distance))
    return depths


def test_timestep_is_500_hz(op3):
    assert judging_model(op3).opt.timestep == TIMESTEP_S == 0.002


def test_broken_cache_is_rebuilt(op3, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.chdir(tmp_path)  # where MuJoCo logs its complaint
    first = judging_model(op3)
    (file,) = (tmp_path / "ros-free-stack").iterdir()
    file.write_bytes(file.read_bytes()[:1000])
    assert judging_model(op3).nbody == first.nbody
    assert file.stat().st_size > 1000


def test_unwritable_cache_only_costs_time(op3, tmp_path, monkeypatch):
    (tmp_path / "ros-free-stack").write_text("a file where the folder should be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert judging_model(op3).nu == 20


def test_robot_without_actuators(op3, standing, monkeypatch):
    from ros_free_stack.errors import InvalidFile

    reference = make_reference(standing(op3), op3, judging_model(op3))
    model = judging_model(op3)
    model.actuator_gainprm[:, 0] = 0
    with pytest.raises(InvalidFile, match="no position actuator"):
        set_stage(dataclasses.replace(reference, model=model))


@pytest.mark.parametrize("limits", [FallLimits(height=9.0, orientation=0.5), FallLimits(height=0.1, orientation=9.0)])
def test_a_robot_that_topples_has_fallen_by_height_and_by_orientation(op3, standing, limits):
    lean = np.linspace(0, 0.6, 100)
    trajectory = standing(op3, frames=100, joints={"l_ank_pitch": lean, "r_ank_pitch": -lean})
    reference = make_reference(trajectory, op3, judging_model(op3))
    assert play(set_stage(reference), limits, controller="pd").fell_at_s is not None
    assert play(set_stage(reference), FallLimits(9.0, 9.0), controller="pd").fell_at_s is None


@pytest.mark.parametrize("late", [0, 1, 3])
def test_goals_arrive_when_the_plan_says_and_later_by_what_the_bus_is_late(op3, standing, late):
    """The controller sends its goals as much earlier as they are on their way on a bus that is in time."""
    start = 50
    jump = np.where(np.arange(125) < start, 0.0, 0.3)
    trajectory = standing(op3, frames=125, fps=125.0, joints={"head_pan": jump})
    bodies = judging_model(op3, mount="fixed").nbody
    lateness = Disturbance(np.ones(bodies), 1.0, late, np.zeros(3), 0.5, SensorNoise(), 0)
    playback = simulate(op3, trajectory, mount="fixed", controller="pd", disturbance=lateness)
    joint = op3.joint_names.index("head_pan")
    (moving,) = np.nonzero(np.abs(playback.torque[:, joint]) > 0.5 * op3.joints["head_pan"].effort)
    # What is recorded at a frame is how things stood when its goal came, so that the goal shows one frame later.
    assert moving[0] == start + late + 1
