"""What a controller may know of the robot: the simulation's true state, or what encoders and an IMU tell.

The estimate takes joint angles in whole encoder steps, joint speeds as their differences over a cycle through a
first-order filter, orientation and turning rate from the IMU with noise. The root's position comes by leg odometry: the
feet that should stand are taken to be where the plan puts them, and still. Its speed is what the IMU's accelerometer
adds up to, drawn slowly to the speed that leg odometry tells (a complementary filter: Bloesch et al. 2013 fuse the same
two by a Kalman filter). Leg odometry alone lags by the filter of the joint speeds and takes a foot that rocks on its
edge for a moving body; a controller that answers a capture point hard then shakes the robot until it falls.
"""

from dataclasses import dataclass
from typing import Protocol

import mujoco
import numpy as np

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription
from sim.playback.actuation import Servos
from sim.playback.plan import Plan

VELOCITY_CUTOFF_HZ = 12.0
"""Of the low-pass filter of joint speeds."""

BLEND_S = 0.1
"""Time in which the speed from the accelerometer gives way to that of leg odometry."""


@dataclass(frozen=True)
class SensorNoise:
    """Standard deviations of the sensors' white noise: rad, rad, rad/s, m/s^2.

    The defaults are those of a small IMU with orientation filter (0.1 deg of tilt from sample to sample, 0.3 deg/s of
    rate, 0.15 m/s^2 of acceleration, in which the tilt's share of gravity is) and of encoders whose only error are
    their steps.
    """

    encoder: float = 0.0
    tilt: float = 0.0017
    rate: float = 0.005
    acceleration: float = 0.15


class Estimator(Protocol):
    """Where the robot is believed to be."""

    def believe(self, cycle: int, actual: mujoco.MjData) -> mujoco.MjData:
        """The state believed at a cycle of the plan, with its kinematics."""
        ...


class TrueState:
    """The simulation's own state."""

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model, self._data = model, mujoco.MjData(model)

    def believe(self, cycle: int, actual: mujoco.MjData) -> mujoco.MjData:
        """See `Estimator`."""
        del cycle
        self._data.qpos[:], self._data.qvel[:] = actual.qpos, actual.qvel
        return posed(self._model, self._data)


class EncodersAndImu:
    """The state as joint encoders and an IMU in the root tell it."""

    def __init__(
        self,
        model: mujoco.MjModel,
        robot: RobotDescription,
        servos: Servos,
        plan: Plan,
        noise: SensorNoise,
        rng: np.random.Generator,
    ) -> None:
        self._model, self._servos, self._plan, self._noise, self._rng = model, servos, plan, noise, rng
        self._data = mujoco.MjData(model)
        self._positions, self._dofs = joint_addresses(model, robot)
        self._free = model.nv > len(robot.joints)
        self._bodies = [model.body(sole.body).id for sole in robot.soles.values()]
        self._middles = [np.mean(sole.corners, axis=0) for sole in robot.soles.values()]
        self._share = 1 - np.exp(-2 * np.pi * VELOCITY_CUTOFF_HZ * plan.cycle_s)
        self._blend = 1 - np.exp(-plan.cycle_s / BLEND_S)
        self._angles: Floats | None = None
        self._root, self._speed, self._before = np.zeros(3), np.zeros(3), np.zeros(3)

    def believe(self, cycle: int, actual: mujoco.MjData) -> mujoco.MjData:
        """See `Estimator`."""
        data, dt = self._data, self._plan.cycle_s
        angles = actual.qpos[self._positions]
        angles = self._servos.rounded(angles + self._rng.normal(0, 1, len(angles)) * self._noise.encoder)
        if self._angles is not None:
            speed = (angles - self._angles) / dt
            data.qvel[self._dofs] += self._share * (speed - data.qvel[self._dofs])
        data.qpos[self._positions] = angles
        if self._free:
            data.qpos[3:7] = actual.qpos[3:7]
            mujoco.mju_quatIntegrate(data.qpos[3:7], self._rng.normal(0, self._noise.tilt, 3), 1.0)
            data.qvel[3:6] = actual.qvel[3:6] + self._rng.normal(0, self._noise.rate, 3)
            self._speed += actual.qvel[:3] - self._before + self._rng.normal(0, self._noise.acceleration, 3) * dt
            self._before = actual.qvel[:3].copy()
            self._walk(cycle)
        self._angles = angles
        return posed(self._model, data)

    def _walk(self, cycle: int) -> None:
        """Put the root where the standing feet say, and keep it moving on where none stands."""
        data, plan, dt = self._data, self._plan, self._plan.cycle_s
        standing = plan.standing[cycle]
        if standing.any():
            data.qpos[:3] = data.qvel[:3] = 0.0
            mujoco.mj_kinematics(self._model, data)
            mujoco.mj_comPos(self._model, data)
            jacobian, offsets, speeds = np.zeros((3, self._model.nv)), [], []
            for foot in np.flatnonzero(standing):
                body = self._bodies[foot]
                point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ self._middles[foot]
                mujoco.mj_jac(self._model, data, jacobian, None, point, body)
                offsets.append(plan.feet[cycle, foot] - point)
                speeds.append(-jacobian @ data.qvel)
            root = np.mean(offsets, axis=0)
            self._speed += self._blend * (np.mean(speeds, axis=0) - self._speed)
        else:
            root = self._root + self._speed * dt
        self._root, data.qpos[:3], data.qvel[:3] = root, root, self._speed


def posed(model: mujoco.MjModel, data: mujoco.MjData) -> mujoco.MjData:
    """The same data with positions and velocities of bodies for its `qpos` and `qvel`."""
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    mujoco.mj_comVel(model, data)
    return data
