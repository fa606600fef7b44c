"""Centre of mass and zero moment point (ZMP) of a whole-body motion, by inverse dynamics."""

import copy
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from retarget.body.geometry import RobotGeometry
from ros_free_stack.messages import Floats

LEAST_LOAD = 0.2
"""Share of the weight below which the ZMP of a nearly flying robot means nothing."""
VELOCITY_SMOOTHING = 1.0
"""Standard deviation of the Gaussian filter on velocities, in frames: accelerations of sampled motions are noisy."""


@dataclass(frozen=True)
class Dynamics:
    """`centre_of_mass` (N, 3) m and `zmp` (N, 2) m of a motion."""

    centre_of_mass: Floats
    zmp: Floats


def whole_body_dynamics(geometry: RobotGeometry, qpos: Floats, fps: float) -> Dynamics:
    """Dynamics of (N, nq) configurations: the ZMP is where the floor must push for the base to need no other force.

    Vukobratovic and Borovac 2004, "Zero-moment point: thirty-five years of its life".
    """
    model = copy.copy(geometry.model)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    data = mujoco.MjData(model)
    velocity = _velocities(model, qpos, fps)
    acceleration = np.gradient(velocity, 1 / fps, axis=0) if len(qpos) > 1 else np.zeros_like(velocity)
    weight = -float(model.opt.gravity[2]) * float(model.body_subtreemass[0])
    com, zmp = np.zeros((len(qpos), 3)), np.zeros((len(qpos), 2))
    root = model.body(geometry.robot.root_body).id
    for k in range(len(qpos)):
        data.qpos[:], data.qvel[:], data.qacc[:] = qpos[k], velocity[k], acceleration[k]
        mujoco.mj_inverse(model, data)
        com[k] = data.subtree_com[0]
        force = data.qfrc_inverse[:3]
        moment = data.xmat[root].reshape(3, 3) @ data.qfrc_inverse[3:6] + np.cross(data.qpos[:3], force)
        load = max(force[2], LEAST_LOAD * weight)
        zmp[k] = -moment[1] / load, moment[0] / load
    return Dynamics(com, zmp)


def _velocities(model: mujoco.MjModel, qpos: Floats, fps: float) -> Floats:
    count = len(qpos)
    velocity = np.zeros((count, model.nv))
    for k in range(count):
        before, after = max(k - 1, 0), min(k + 1, count - 1)
        if after > before:
            mujoco.mj_differentiatePos(model, velocity[k], (after - before) / fps, qpos[before], qpos[after])
    return gaussian_filter1d(velocity, VELOCITY_SMOOTHING, axis=0, mode="nearest")
