"""The torques that a reference needs: inverse dynamics, with the floor's forces shared out among the soles."""

from dataclasses import dataclass
from typing import Final

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription, Sole
from sim.playback.linear import damped_shares

_FRICTION: Final = 0.5
_REGULARISATION: Final = 1e-3

_EDGES: Final = np.array([[_FRICTION, 0, 1], [-_FRICTION, 0, 1], [0, _FRICTION, 1], [0, -_FRICTION, 1.0]])
_MOMENTS: Final = np.cross(np.eye(3), _EDGES[:, None])
"""(4, 3, 3): an arm (3,) times one of these is the moment of that edge's force."""


@dataclass(frozen=True)
class Dynamics:
    """What a reference motion implies, frame by frame.

    Attributes:
        qvel: (T, nv) velocities.
        qacc: (T, nv) accelerations.
        com: (T, 3) centre of mass, m.
        com_vel: (T, 3) m/s.
        torque: (T, J) joint torques in N m that servos must supply, joint damping included.
    """

    qvel: Floats
    qacc: Floats
    com: Floats
    com_vel: Floats
    torque: Floats


def inverse_dynamics(
    model: mujoco.MjModel, robot: RobotDescription, qpos: Floats, contacts: Bools, dt: float
) -> Dynamics:
    """Velocities, centre of mass and feedforward torques of a motion sampled every `dt` seconds.

    With M(q) a + c(q, v) - passive = S' tau + sum J_k' f_k, contact forces f_k at the corners of soles in contact
    are the non-negative combination of friction-cone edges that best explains the six root equations; joint torques
    are what remains. A motion that such forces cannot explain (unbalanced, flying) leaves a residue at the root that
    nothing supplies: it will not track.

    Args:
        model: with a free or a fixed base.
        robot: its description.
        qpos: (T, nq) poses.
        contacts: (T, F) whether each foot stands.
        dt: s between poses.
    """
    frames = len(qpos)
    qvel, qacc = _derivatives(model, qpos, dt)
    com = np.empty((frames, 3))
    forces = np.empty((frames, model.nv))
    floor_forces = np.zeros((frames, model.nv))
    free = model.nv > len(robot.joints)
    data = mujoco.MjData(model)
    flags = model.opt.disableflags
    model.opt.disableflags = flags | int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    for frame in range(frames):
        data.qpos[:], data.qvel[:], data.qacc[:] = qpos[frame], qvel[frame], qacc[frame]
        mujoco.mj_inverse(model, data)
        com[frame] = data.subtree_com[0]
        forces[frame] = data.qfrc_inverse
        if free and contacts[frame].any():
            floor_forces[frame] = _floor_forces(model, data, robot, contacts[frame])
    model.opt.disableflags = flags
    _, dofs = joint_addresses(model, robot)
    torque = gaussian_filter1d((forces - floor_forces)[:, dofs], 0.02 / dt, axis=0, mode="nearest")
    com_vel = np.asarray(np.gradient(com, dt, axis=0))
    return Dynamics(qvel, qacc, com, com_vel, torque)


def _derivatives(model: mujoco.MjModel, qpos: Floats, dt: float) -> tuple[Floats, Floats]:
    """Central differences of poses, smoothed over 20 ms."""
    frames = len(qpos)
    qvel = np.zeros((frames, model.nv))
    for frame in range(frames):
        before, after = max(frame - 1, 0), min(frame + 1, frames - 1)
        if after > before:
            mujoco.mj_differentiatePos(model, qvel[frame], (after - before) * dt, qpos[before], qpos[after])
    qvel = gaussian_filter1d(qvel, 0.02 / dt, axis=0, mode="nearest")
    return qvel, np.gradient(qvel, dt, axis=0) if frames > 1 else np.zeros_like(qvel)


def _floor_forces(model: mujoco.MjModel, data: mujoco.MjData, robot: RobotDescription, contacts: Bools) -> Floats:
    """(nv,) generalised force of the floor on the standing soles."""
    standing = [sole for sole, stands in zip(robot.soles.values(), contacts, strict=True) if stands]
    weight = model.body_subtreemass[0] * np.linalg.norm(model.opt.gravity)
    generators = weight * np.concatenate([_cone_edges(model, data, sole) for sole in standing]).T
    return generators @ damped_shares(generators[:6], data.qfrc_inverse[:6], _REGULARISATION * weight)


def _cone_edges(model: mujoco.MjModel, data: mujoco.MjData, sole: Sole) -> Floats:
    """(16, nv) generalised forces of 1 N upwards along the four edges of the friction cone at each corner of a sole."""
    body = data.body(sole.body)
    arms = np.array(sole.corners) @ body.xmat.reshape(3, 3).T
    wrenches = np.empty((len(arms), len(_EDGES), 6))
    wrenches[..., :3], wrenches[..., 3:] = _EDGES, (arms @ _MOMENTS).swapaxes(0, 1)
    jacobian = np.zeros((6, model.nv))
    mujoco.mj_jacBody(model, data, jacobian[:3], jacobian[3:], body.id)
    return wrenches.reshape(-1, 6) @ jacobian
