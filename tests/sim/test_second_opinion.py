"""A second opinion on verdicts: a plain MuJoCo loop with other parts, and other formulas for the same figures.

The loop reads the robot's own MJCF and drops its meshes, so that only the primitive shapes of the feet meet the floor.
It interpolates goals linearly, computes the servos' torques itself and steps at 0.5 ms with explicit damping. Nothing
of the judge's model, plan or actuation is used.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
import pytest

from ros_free_stack.messages import RobotTrajectory
from ros_free_stack.robots import RobotDescription, load_robot
from ros_free_stack.servo_path import servo_path
from sim.judge.verdict import judge

STEP_S, HOLD_S = 0.0005, 0.5
UNITREE_CYCLE_S = 0.002


@dataclass(frozen=True)
class Opinion:
    """What the plain loop finds: lengths in m, speeds in rad/s, `fell_at` in s from the motion's start or None."""

    height: float
    tilt: float
    fell_at: float | None
    global_error: float
    relative_error: float
    speed_error: float


def plain_model(robot: RobotDescription) -> mujoco.MjModel:
    """The robot's MJCF without meshes on a plane that only its primitive shapes meet."""
    spec = mujoco.MjSpec.from_file(str(robot.model_path))
    for geom in list(spec.geoms):
        if geom.type == mujoco.mjtGeom.mjGEOM_MESH:
            spec.delete(geom)
        else:
            geom.conaffinity = 0
    for mesh in list(spec.meshes):
        spec.delete(mesh)
    spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[0, 0, 1], contype=0, conaffinity=1)
    spec.option.timestep = STEP_S
    spec.option.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
    return spec.compile()


def configuration(model: mujoco.MjModel, trajectory: RobotTrajectory, at_s: float) -> np.ndarray:
    """`qpos` at a time, held before the first frame and after the last."""
    times = np.arange(len(trajectory.joint_pos)) / trajectory.fps
    qpos = model.qpos0.copy()
    qpos[:3] = [np.interp(at_s, times, column) for column in trajectory.root_pos.T]
    qpos[3:7] = trajectory.root_quat[0]
    for name, column in zip(trajectory.joint_names, trajectory.joint_pos.T, strict=True):
        qpos[model.joint(name).qposadr[0]] = np.interp(at_s, times, column)
    return qpos


def second_opinion(robot: RobotDescription, trajectory: RobotTrajectory) -> Opinion:
    """Play a trajectory on plain servos; the trajectory's root never turns."""
    model = plain_model(robot)
    data, ideal = mujoco.MjData(model), mujoco.MjData(model)
    joints = [model.joint(name) for name in trajectory.joint_names]
    places, dofs = [j.qposadr[0] for j in joints], [j.dofadr[0] for j in joints]
    servos = [int(np.flatnonzero(model.actuator_trnid[:, 0] == j.id)[0]) for j in joints]
    kp, kd = model.actuator_gainprm[servos, 0], -model.actuator_biasprm[servos, 2]
    stall = np.array([robot.joints[name].effort for name in trajectory.joint_names])
    if robot.servos is not None:  # a Dynamixel's torque falls with its speed; the model's own damping gives way to that
        model.dof_damping[dofs] = 0.0
        assert robot.servos.motor is not None
        slope = stall / robot.servos.motor.no_load_speed
    else:
        slope = np.zeros(len(stall))
    cycle = robot.servos.cycle_s if robot.servos else UNITREE_CYCLE_S
    torso, root = model.body(robot.torso_body).id, model.body(robot.root_body).id
    limit = 0.25 * min(1.0, trajectory.root_pos[0, 2] / 0.787)
    frame_s = 1 / trajectory.fps
    planned_speed = np.gradient(trajectory.joint_pos, frame_s, axis=0)
    data.qpos[:] = configuration(model, trajectory, 0.0)
    height = tilt = 0.0
    fell_at, goals, due, frame = None, np.zeros(len(stall)), 0.0, 0
    world, own, speeds = [], [], []
    for step in range(round((2 * HOLD_S + trajectory.duration_s) / STEP_S)):
        now = step * STEP_S - HOLD_S
        if now + 1e-9 >= due - HOLD_S:
            goals, due = configuration(model, trajectory, now)[places], due + cycle
        pull = np.clip(kp * (goals - data.qpos[places]) - kd * data.qvel[dofs], -stall, stall)
        data.qfrc_applied[dofs] = pull - slope * data.qvel[dofs]
        mujoco.mj_step(model, data)
        if now + STEP_S + 1e-9 < frame * frame_s or frame >= len(trajectory.joint_pos):
            continue
        ideal.qpos[:] = configuration(model, trajectory, frame * frame_s)
        mujoco.mj_kinematics(model, ideal)
        mujoco.mj_kinematics(model, data)
        height = max(height, abs(data.xpos[torso, 2] - ideal.xpos[torso, 2]))
        tilt = max(tilt, abs(data.xmat[torso, 8] - ideal.xmat[torso, 8]))
        if height > limit or tilt > 0.8:
            fell_at = now
            break
        where = [points(model, at, robot) for at in (data, ideal)]
        world.append(np.linalg.norm(where[0] - where[1], axis=1).mean())
        bare = [(p - at.xpos[root]) @ at.xmat[root].reshape(3, 3) for p, at in zip(where, (data, ideal), strict=True)]
        own.append(np.linalg.norm(bare[0] - bare[1], axis=1).mean())
        speeds.append(np.square(data.qvel[dofs] - planned_speed[frame]))
        frame += 1
    rms = float(np.sqrt(np.mean(speeds)))
    return Opinion(height, tilt, fell_at, float(np.mean(world)), float(np.mean(own)), rms)


def points(model: mujoco.MjModel, data: mujoco.MjData, robot: RobotDescription) -> np.ndarray:
    """(P, 3) m, the robot's points that play human joints."""
    places = []
    for item in robot.attachments.values():
        place, body = np.zeros(3), model.body(item.body).id
        mujoco.mju_rotVecQuat(place, np.array(item.offset, dtype=float), data.xquat[body])
        places.append(data.xpos[body] + place)
    return np.array(places)


def wave(op3, standing):
    swing = 0.8 * np.sin(np.linspace(0, 4 * np.pi, 100))
    return op3, standing(op3, frames=100, joints={"l_sho_roll": 0.4 + swing / 2, "r_el": swing})


def squat(op3, standing):
    depth = 0.25 * (1 - np.cos(2 * np.pi * np.arange(100) / 100))
    signs = {"l_hip_pitch": -1, "l_knee": 2, "l_ank_pitch": 1, "r_hip_pitch": 1, "r_knee": -2, "r_ank_pitch": -1}
    root = np.zeros((100, 3))
    root[:, 2] = 0.22 * (np.cos(0.35 + depth) - np.cos(0.35))
    joints = {name: op3.standing[name] + sign * depth for name, sign in signs.items()}
    return op3, standing(op3, frames=100, joints=joints, root_offset=root)


def lean(op3, standing):
    further = 0.88 * np.clip((np.arange(150) - 25) / 50, 0, 1)
    return op3, standing(op3, frames=150, joints={"l_ank_pitch": 0.35 - further, "r_ank_pitch": -0.35 + further})


def arms_of_g1(op3, standing):
    robot = load_robot("g1")
    lift = 0.5 * (1 - np.cos(2 * np.pi * np.arange(75) / 75))
    sides = {"left_shoulder_roll_joint": 1, "right_shoulder_roll_joint": -1}
    joints = {name: robot.standing[name] + sign * lift for name, sign in sides.items()}
    return robot, standing(robot, frames=75, joints=joints)


@pytest.mark.parametrize("make", [wave, squat, lean, arms_of_g1])
def test_playback_agrees_with_a_plain_loop(make, op3, standing):
    robot, trajectory = make(op3, standing)
    judgement, other = judge(trajectory, robot, controller="pd"), second_opinion(robot, servo_path(trajectory, robot))
    assert judgement.playback is not None
    assert (other.fell_at is not None) == (make is lean)
    assert judgement.playback.fell_at_s == pytest.approx(other.fell_at, abs=0.02)
    if make is lean:
        return
    ours = {check.name: check.value for check in judgement.verdict.checks}
    assert ours["fall_height"] == pytest.approx(other.height, abs=0.001)
    assert ours["fall_orientation"] == pytest.approx(other.tilt, abs=0.0005)
    assert ours["mpjpe_global"] == pytest.approx(other.global_error, abs=0.0002)
    assert ours["mpjpe_relative"] == pytest.approx(other.relative_error, abs=0.0002)
    assert ours["joint_velocity_error"] == pytest.approx(other.speed_error, rel=0.03)


def test_figures_of_a_reference_agree(op3, standing):
    """A robot that slides with sunken feet and an elbow beyond its range, by how much is worked out from the MJCF."""
    slide = np.zeros((60, 3))
    slide[:, 0], slide[:, 2] = 0.1 * np.arange(60) / 50 + 0.01 * np.sin(np.arange(60) / 5), -0.006
    bend = np.linspace(0, op3.joints["l_el"].upper + 0.05, 60)
    trajectory = standing(op3, frames=60, root_offset=slide, joints={"l_el": bend})
    ours = {check.name: check.value for check in judge(trajectory, op3, physics=False).verdict.checks}
    trajectory = servo_path(trajectory, op3)
    model = plain_model(op3)
    data = mujoco.MjData(model)
    feet = [model.body(sole.body).id for sole in op3.soles.values()]
    boxes = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] in feet]
    lowest, places = np.inf, []
    for frame in range(len(trajectory.joint_pos)):
        data.qpos[:] = configuration(model, trajectory, frame / trajectory.fps)
        mujoco.mj_kinematics(model, data)
        for geom in boxes:
            reach = np.abs(data.geom_xmat[geom].reshape(3, 3)[2]) @ model.geom_size[geom]
            lowest = min(lowest, data.geom_xpos[geom, 2] - reach)
        places.append([data.xpos[body, :2].copy() for body in feet])
    assert ours["joint_range"] == pytest.approx(0.05, abs=1e-9)
    assert ours["ground_penetration"] == pytest.approx(-lowest, abs=0.0005)
    speeds = np.linalg.norm(np.diff(places, axis=0), axis=-1) * trajectory.fps
    assert ours["foot_skate"] == pytest.approx(speeds.mean(), rel=1e-6)
    assert ours["foot_skate_peak"] == pytest.approx(speeds.max(), rel=1e-6)
