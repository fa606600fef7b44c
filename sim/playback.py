"""Physics playback: the robot tries the trajectory with its own position servos, on the floor, under gravity.

Servos get the reference plus feedforward, ctrl = q_ref + (tau_ff + kd v_ref) / kp, and the ankles of standing feet
lean against the error of the divergent component of motion (Englsberger et al. 2015), xi = c + v / omega: an ankle
offset of 1.2 error / h about the axis z x error. Both read the simulation's true state; a real robot does worse.
The robot starts at rest in the first pose and holds the last one, as it would on the bench.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from ros_free_stack.errors import InvalidFile
from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription
from sim.inverse_dynamics import inverse_dynamics
from sim.model import TIMESTEP_S, Mount, judging_model
from sim.reference import Reference

HOLD_S = 0.5
"""Time at rest before and after the motion."""

AFTERMATH_S = 0.6
"""How long a fall is watched before the simulation ends."""

DCM_GAIN = 1.2
"""Ankle offset over DCM error per height of the centre of mass."""

_DYNAMICS_DT_S = 0.02


@dataclass(frozen=True)
class Playback:
    """What happened, sampled at the trajectory's frames; N < T frames where a fall ended it early.

    "Greatest" values are those since the frame before; the first frame's include the hold before the motion and the
    last frame's all that came after it.

    Attributes:
        qpos: (N, nq) simulated poses.
        body_pos: (N, B, 3) m, world.
        body_rot: (N, B, 3, 3) world from body.
        joint_pos: (N, J) rad.
        joint_vel: (N, J) rad/s.
        torque: (N, J) N m, applied: the greatest magnitude.
        needed: (N, J) N m, feedforward torque of the reference: the greatest magnitude.
        saturated: (N, J) share of the time at the torque limit.
        contact_force: (N, F) N, normal force of the floor on each foot.
        height_error: (N,) m, of the torso body against the reference, greatest.
        orientation_error: (N,) difference of gravity along the torso's z axis, 0 to 2, greatest.
        fell_at_s: when the robot fell, from the motion's start (beyond its end if in the final hold), or None.
    """

    qpos: Floats
    body_pos: Floats
    body_rot: Floats
    joint_pos: Floats
    joint_vel: Floats
    torque: Floats
    needed: Floats
    saturated: Floats
    contact_force: Floats
    height_error: Floats
    orientation_error: Floats
    fell_at_s: float | None

    @property
    def frames(self) -> int:
        return len(self.qpos)


@dataclass(frozen=True)
class _Plan:
    """The reference at every physics step, S steps: hold, motion, hold."""

    start: Floats  # (nq,)
    ctrl: Floats  # (S, J) servo goals with feedforward, rad
    torque: Floats  # (S, J) feedforward, N m
    com: Floats  # (S, 3)
    dcm: Floats  # (S, 2)
    standing: Bools  # (S, F)
    torso_height: Floats  # (S,)
    torso_up: Floats  # (S,) z component of the torso's z axis


@dataclass(frozen=True)
class _Log:
    """The simulation at every physics step."""

    qpos: Floats
    qvel: Floats
    force: Floats
    height_error: Floats
    orientation_error: Floats
    contact_force: dict[int, Floats]  # by step
    fell_at_step: int | None


@dataclass(frozen=True)
class _Servos:
    """Position servos in the description's joint order: torque = kp (ctrl - q) - kd v."""

    actuators: np.ndarray
    kp: Floats
    kd: Floats


def play(reference: Reference, *, mount: Mount = "free", fall_height: float, fall_orientation: float) -> Playback:
    """Simulate a trajectory at 500 Hz from rest in its first pose.

    Args:
        reference: the trajectory's kinematics.
        mount: `free`, or `fixed` for a robot held in the air by its root.
        fall_height: error of the torso's height in m that counts as a fall.
        fall_orientation: error of gravity along the torso's z axis that counts as a fall.
    """
    robot = reference.robot
    model = reference.model if mount == "free" else judging_model(robot, mount="fixed")
    servos = _servos(model, robot)
    plan = _plan(reference, model, servos, mount)
    steps = len(plan.ctrl)
    frames = np.arange(len(reference.qpos))
    at_step = np.rint((HOLD_S + frames * reference.dt) / TIMESTEP_S).astype(int)
    log = _simulate(
        model,
        robot,
        plan,
        servos,
        record=frozenset(at_step.tolist()),
        fall=(fall_height, fall_orientation) if mount == "free" else (np.inf, np.inf),
    )
    done = len(log.qpos)
    fell = None if log.fell_at_step is None else log.fell_at_step * TIMESTEP_S - HOLD_S
    return _sample(model, robot, plan, log, at_step[at_step < min(done, steps)], fell)


def _servos(model: mujoco.MjModel, robot: RobotDescription) -> _Servos:
    joints = model.actuator_trnid[:, 0].tolist()
    actuators: list[int] = []
    for name in robot.joint_names:
        joint = model.joint(name).id
        if joint not in joints or model.actuator_gainprm[joints.index(joint), 0] <= 0:
            raise InvalidFile(robot.model_path, f"joint {name} has no position actuator")
        actuators.append(joints.index(joint))
    index = np.array(actuators)
    return _Servos(index, model.actuator_gainprm[index, 0], -model.actuator_biasprm[index, 2])


def _plan(reference: Reference, model: mujoco.MjModel, servos: _Servos, mount: Mount) -> _Plan:
    """Resample the reference with its holds and add the feedforward."""
    robot, trajectory = reference.robot, reference.trajectory
    held = int(np.ceil(HOLD_S * trajectory.fps)) + 2
    keys = np.clip(np.arange(-held, len(reference.qpos) + held), 0, len(reference.qpos) - 1)
    key_times = (np.arange(len(keys)) - held) * reference.dt
    end = trajectory.duration_s - reference.dt + HOLD_S
    coarse = np.arange(-HOLD_S, end + _DYNAMICS_DT_S, _DYNAMICS_DT_S)
    fine = np.arange(-HOLD_S, end, TIMESTEP_S)
    addresses, dofs = joint_addresses(model, robot)
    joints = CubicSpline(key_times, trajectory.joint_pos[keys])
    qpos = np.tile(model.qpos0, (len(coarse), 1))
    qpos[:, addresses] = joints(coarse)
    if mount == "free":
        qpos[:, :3] = CubicSpline(key_times, trajectory.root_pos[keys])(coarse)
        rotations = Rotation.from_quat(trajectory.root_quat[keys], scalar_first=True)
        qpos[:, 3:7] = RotationSpline(key_times, rotations)(coarse).as_quat(scalar_first=True)
    standing = trajectory.contacts[_nearest(coarse, reference)]
    dynamics = inverse_dynamics(model, robot, qpos, standing, _DYNAMICS_DT_S)
    torque, com, com_vel = (
        _interpolate(fine, coarse, values) for values in (dynamics.torque, dynamics.com, dynamics.com_vel)
    )
    feedforward = (torque + servos.kd * _interpolate(fine, coarse, dynamics.qvel[:, dofs])) / servos.kp
    torso = model.body(robot.torso_body).id
    height = _interpolate(fine, key_times, reference.body_pos[keys, torso, 2:])[:, 0]
    up = _interpolate(fine, key_times, reference.body_rot[keys, torso, 2, 2:])[:, 0]
    return _Plan(
        start=qpos[0],
        ctrl=joints(fine) + feedforward,
        torque=torque,
        com=com,
        dcm=com[:, :2] + com_vel[:, :2] / _omega(model, com[:, 2:]),
        standing=trajectory.contacts[_nearest(fine, reference)],
        torso_height=height,
        torso_up=up,
    )


def _omega(model: mujoco.MjModel, height: Floats) -> Floats:
    """Natural frequency of the inverted pendulum, 1/s."""
    return np.sqrt(-model.opt.gravity[2] / np.maximum(height, 0.05))


def _nearest(times: Floats, reference: Reference) -> np.ndarray:
    return np.clip(np.rint(times / reference.dt).astype(int), 0, len(reference.qpos) - 1)


def _interpolate(times: Floats, keys: np.ndarray, values: Floats) -> Floats:
    return np.stack([np.interp(times, keys, column) for column in values.T], axis=1)


def _simulate(
    model: mujoco.MjModel,
    robot: RobotDescription,
    plan: _Plan,
    servos: _Servos,
    *,
    record: frozenset[int],
    fall: tuple[float, float],
) -> _Log:
    """Step through the plan; stop a moment after a fall."""
    data = mujoco.MjData(model)
    data.qpos[:] = plan.start
    mujoco.mj_forward(model, data)
    torso = model.body(robot.torso_body).id
    feet = [model.body(sole.body).id for sole in robot.soles.values()]
    floats = model.nv > len(robot.joints)
    ankles = [_ankle_joints(model, robot, body) for body in feet]
    steps = len(plan.ctrl)
    qpos, qvel = np.empty((steps, model.nq)), np.empty((steps, model.nv))
    force = np.empty((steps, len(servos.kp)))
    errors = np.empty((steps, 2))
    contact_force: dict[int, Floats] = {}
    fell: int | None = None
    last = steps
    for step in range(steps):
        goal = plan.ctrl[step].copy()
        if floats:
            _lean_ankles(model, data, plan, step, ankles, goal)
        data.ctrl[servos.actuators] = goal
        mujoco.mj_step(model, data)
        qpos[step], qvel[step] = data.qpos, data.qvel
        force[step] = data.actuator_force[servos.actuators]
        errors[step, 0] = abs(data.xpos[torso, 2] - plan.torso_height[step]) if floats else 0.0
        errors[step, 1] = abs(data.xmat[torso, 8] - plan.torso_up[step]) if floats else 0.0
        if step in record:
            contact_force[step] = np.array([_normal_force(model, data, body) for body in feet])
        if fell is None and (errors[step, 0] > fall[0] or errors[step, 1] > fall[1]):
            fell, last = step, min(steps, step + int(AFTERMATH_S / TIMESTEP_S))
        if step + 1 >= last:
            break
    done = step + 1
    return _Log(
        qpos[:done],
        qvel[:done],
        force[:done],
        errors[:done, 0],
        errors[:done, 1],
        contact_force,
        fell,
    )


def _ankle_joints(model: mujoco.MjModel, robot: RobotDescription, foot: int) -> list[tuple[int, int]]:
    """(place in the description, joint id) of the hinges of a foot and of the link above it."""
    links = (foot, int(model.body_parentid[foot]))
    return [
        (place, model.joint(name).id)
        for place, name in enumerate(robot.joint_names)
        if model.jnt_bodyid[model.joint(name).id] in links
    ]


def _lean_ankles(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    plan: _Plan,
    step: int,
    ankles: list[list[tuple[int, int]]],
    goal: Floats,
) -> None:
    """Add the ankle offsets of the standing feet to the servo goals."""
    mujoco.mj_subtreeVel(model, data)
    height = max(float(plan.com[step, 2]), 0.05)
    omega = np.sqrt(-model.opt.gravity[2] / height)
    error_x, error_y = data.subtree_com[0, :2] + data.subtree_linvel[0, :2] / omega - plan.dcm[step]
    gain = DCM_GAIN / height
    for standing, joints in zip(plan.standing[step], ankles, strict=True):
        if standing:
            for place, joint in joints:
                axis = data.xaxis[joint]
                goal[place] += gain * (axis[1] * error_x - axis[0] * error_y)


def _normal_force(model: mujoco.MjModel, data: mujoco.MjData, body: int) -> float:
    """Force in N with which the floor presses on a body."""
    total, wrench = 0.0, np.zeros(6)
    for index, geoms in enumerate(data.contact.geom):
        bodies = model.geom_bodyid[geoms]
        if body in bodies and 0 in bodies:
            mujoco.mj_contactForce(model, data, index, wrench)
            total += float(wrench[0])
    return total


def _sample(
    model: mujoco.MjModel,
    robot: RobotDescription,
    plan: _Plan,
    log: _Log,
    at_step: np.ndarray,
    fell_at_s: float | None,
) -> Playback:
    """Reduce the log to the trajectory's frames."""
    addresses, dofs = joint_addresses(model, robot)
    limited = np.abs(log.force) >= 0.999 * robot.effort
    starts = np.concatenate([[0], at_step[:-1] + 1])

    def greatest(values: Floats) -> Floats:
        return np.maximum.reduceat(values, starts, axis=0)

    upto = len(log.qpos)
    counts = np.diff(np.append(starts, upto))
    body_pos = np.empty((len(at_step), model.nbody, 3))
    body_rot = np.empty((len(at_step), model.nbody, 3, 3))
    data = mujoco.MjData(model)
    for frame, step in enumerate(at_step):
        data.qpos[:] = log.qpos[step]
        mujoco.mj_kinematics(model, data)
        body_pos[frame], body_rot[frame] = data.xpos, data.xmat.reshape(-1, 3, 3)
    return Playback(
        qpos=log.qpos[at_step],
        body_pos=body_pos,
        body_rot=body_rot,
        joint_pos=log.qpos[at_step][:, addresses],
        joint_vel=log.qvel[at_step][:, dofs],
        torque=greatest(np.abs(log.force)),
        needed=greatest(np.abs(plan.torque[:upto])),
        saturated=np.add.reduceat(limited.astype(float), starts, axis=0) / counts[:, None],
        contact_force=np.stack([log.contact_force[int(step)] for step in at_step]),
        height_error=greatest(log.height_error),
        orientation_error=greatest(log.orientation_error),
        fell_at_s=fell_at_s,
    )
