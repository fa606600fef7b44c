"""What a controller knows beforehand: the reference at every control cycle, with the torques that it needs.

The robot rests in the first pose before the motion and in the last one after it, as it would on the bench.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation, RotationSpline

from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robot_model import joint_addresses
from sim.playback.actuation import Servos
from sim.playback.inverse_dynamics import inverse_dynamics
from sim.reference import Reference

HOLD_S = 0.5
"""Time at rest before and after the motion."""

_DYNAMICS_DT_S = 0.02


@dataclass(frozen=True)
class Plan:
    """The reference at K control cycles: hold, motion, hold.

    Attributes:
        cycle_s: s between cycles.
        hold_s: from cycle 0 to the motion's first frame: whole cycles, so that goals are the very frames of a path that
            is on the servos' cycle.
        qpos: (K, nq) poses.
        qvel: (K, nv) velocities, MuJoCo's conventions.
        qacc: (K, nv) accelerations.
        joint_pos: (K, J) rad.
        joint_vel: (K, J) rad/s.
        torque: (K, J) N m that the servos must give.
        com: (K, 3) m.
        com_vel: (K, 3) m/s.
        com_acc: (K, 3) m/s^2.
        standing: (K, F) whether each foot should stand.
        feet: (K, F, 3) m, where the sole's middle should be.
        torso_height: (K,) m.
        torso_up: (K,) z component of the torso's z axis.
    """

    cycle_s: float
    hold_s: float
    qpos: Floats
    qvel: Floats
    qacc: Floats
    joint_pos: Floats
    joint_vel: Floats
    torque: Floats
    com: Floats
    com_vel: Floats
    com_acc: Floats
    standing: Bools
    feet: Floats
    torso_height: Floats
    torso_up: Floats

    @property
    def cycles(self) -> int:
        return len(self.qpos)


def make_plan(reference: Reference, model: mujoco.MjModel, servos: Servos) -> Plan:
    """Resample the reference with its holds and work out its dynamics.

    Args:
        reference: the trajectory's kinematics.
        model: the model that will be simulated, with a free or a held root.
        servos: of that model.
    """
    robot, trajectory = reference.robot, reference.trajectory
    cycle_s = servos.cycle_steps * model.opt.timestep
    hold_s = float(np.ceil(HOLD_S / cycle_s - 1e-9)) * cycle_s
    held = int(np.ceil(hold_s * trajectory.fps)) + 2
    keys = np.clip(np.arange(-held, len(reference.qpos) + held), 0, len(reference.qpos) - 1)
    key_times = (np.arange(len(keys)) - held) * reference.dt
    end = trajectory.duration_s - reference.dt + hold_s
    coarse = np.arange(-hold_s, end + _DYNAMICS_DT_S, _DYNAMICS_DT_S)
    times = -hold_s + cycle_s * np.arange(round((end + hold_s) / cycle_s))

    def poses(at: np.ndarray) -> Floats:
        addresses, _ = joint_addresses(model, robot)
        qpos = np.tile(model.qpos0, (len(at), 1))
        qpos[:, addresses] = CubicSpline(key_times, trajectory.joint_pos[keys])(at)
        if model.nv > len(robot.joints):
            qpos[:, :3] = CubicSpline(key_times, trajectory.root_pos[keys])(at)
            rotations = Rotation.from_quat(trajectory.root_quat[keys], scalar_first=True)
            qpos[:, 3:7] = RotationSpline(key_times, rotations)(at).as_quat(scalar_first=True)
        return qpos

    def nearest(at: np.ndarray) -> Bools:
        return trajectory.contacts[np.clip(np.rint(at / reference.dt).astype(int), 0, len(reference.qpos) - 1)]

    def from_keys(values: Floats) -> Floats:
        return interpolate(times, key_times, values[keys])

    addresses, dofs = joint_addresses(model, robot)
    dynamics = inverse_dynamics(model, robot, poses(coarse), nearest(coarse), _DYNAMICS_DT_S)
    qvel, qacc, torque, com, com_vel = (
        interpolate(times, coarse, values)
        for values in (dynamics.qvel, dynamics.qacc, dynamics.torque, dynamics.com, dynamics.com_vel)
    )
    torso = model.body(robot.torso_body).id
    qpos = poses(times)
    soles = [from_keys(corners.mean(axis=1)) for corners in reference.soles.values()]
    return Plan(
        cycle_s=cycle_s,
        hold_s=hold_s,
        qpos=qpos,
        qvel=qvel,
        qacc=qacc,
        joint_pos=qpos[:, addresses],
        joint_vel=qvel[:, dofs],
        torque=torque,
        com=com,
        com_vel=com_vel,
        com_acc=interpolate(times, coarse, np.gradient(dynamics.com_vel, _DYNAMICS_DT_S, axis=0)),
        standing=nearest(times),
        feet=np.stack(soles, axis=1) if soles else np.zeros((len(times), 0, 3)),
        torso_height=from_keys(reference.body_pos[:, torso, 2:])[:, 0],
        torso_up=from_keys(reference.body_rot[:, torso, 2, 2:])[:, 0],
    )


def interpolate(times: np.ndarray, keys: np.ndarray, values: Floats) -> Floats:
    """Values (K, n) at `keys` interpolated linearly at `times` (N,): (N, n)."""
    return np.stack([np.interp(times, keys, column) for column in values.T], axis=1)
