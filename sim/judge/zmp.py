"""The zero moment point: where the floor would have to push for a motion to be as it is."""

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from ros_free_stack.messages import Floats

_SMOOTHING_S = 0.04
"""Twice derived positions of a sampled motion are mostly noise without it."""

_FLIGHT = 0.05
"""Below this share of the weight on the floor the point means nothing."""


def zero_moment_point(model: mujoco.MjModel, qpos: Floats, fps: float) -> Floats:
    """(T, 2) m, the ZMP on the floor z = 0 of a motion of the whole model; NaN in flight.

    With linear momentum P, angular momentum L about the centre of mass c and weight m g, the floor's force is
    f = dP/dt - m g and its moment about the origin c x f + dL/dt; the ZMP is (-M_y, M_x) / f_z.
    Source: Vukobratovic and Borovac 2004, eq. 5.

    Args:
        model: a robot with a free base and nothing else that moves.
        qpos: (T, nq) poses.
        fps: poses a second.
    """
    com, linear, angular = _momenta(model, qpos, fps)
    mass = float(model.body_subtreemass[0])
    force = _rate(mass * linear, fps) - mass * model.opt.gravity
    moment = np.cross(com, force) + _rate(angular, fps)
    standing = force[:, 2] > _FLIGHT * mass * -model.opt.gravity[2]
    point = np.full((len(qpos), 2), np.nan)
    point[standing] = np.column_stack([-moment[:, 1], moment[:, 0]])[standing] / force[standing, 2:]
    return point


def _momenta(model: mujoco.MjModel, qpos: Floats, fps: float) -> tuple[Floats, Floats, Floats]:
    """(T, 3) each: centre of mass, its velocity, angular momentum about it."""
    data = mujoco.MjData(model)
    com, linear, angular = (np.empty((len(qpos), 3)) for _ in range(3))
    last = len(qpos) - 1
    for frame in range(len(qpos)):
        before, after = max(frame - 1, 0), min(frame + 1, last)
        data.qpos[:] = qpos[frame]
        if after > before:
            mujoco.mj_differentiatePos(model, data.qvel, (after - before) / fps, qpos[before], qpos[after])
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_subtreeVel(model, data)
        com[frame], linear[frame] = data.subtree_com[0], data.subtree_linvel[0]
        angular[frame] = data.subtree_angmom[0]
    return com, linear, angular


def _rate(values: Floats, fps: float) -> Floats:
    """The derivative (T, 3) by time of smoothed values; 0 of a single frame."""
    if len(values) < 2:
        return np.zeros_like(values)
    return np.gradient(gaussian_filter1d(values, _SMOOTHING_S * fps, axis=0, mode="nearest"), axis=0) * fps
