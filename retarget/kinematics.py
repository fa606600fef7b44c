"""Symbolic kinematics: a compiled MuJoCo model walked into CasADi expressions with analytic Jacobians.

Tangent vectors have MuJoCo's layout (nv,): a free joint is a world translation (3) and a rotation vector in the body's
frame (3), a hinge or a slide is one number. Jacobians are those of MuJoCo's `mj_jac`: translations and rotation vectors
in the world frame. See Featherstone, "Rigid Body Dynamics Algorithms" (2008), chapters 2 and 4.
"""

from dataclasses import dataclass

import casadi as ca
import mujoco
import numpy as np
from numpy.typing import ArrayLike

from ros_free_stack.errors import UnsupportedModel


@dataclass(frozen=True)
class _Motion:
    """How one degree of freedom moves everything after it: along `axis`, or about it through `origin`."""

    body: int
    axis: ca.SX
    origin: ca.SX | None


class Kinematics:
    """Positions, orientations and Jacobians of a model's bodies as functions of the symbol `qpos` (nq,).

    Quaternions in `qpos` are taken to have unit norm.

    Raises:
        UnsupportedModel: the model has a ball joint.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.qpos = ca.SX.sym("qpos", model.nq)
        self._positions: list[ca.SX] = [ca.SX(3, 1)]
        self._rotations: list[ca.SX] = [ca.SX.eye(3)]
        self._ancestors: list[tuple[int, ...]] = [()]
        self._motions: dict[int, _Motion] = {}
        for body in range(1, model.nbody):
            self._place(body)

    def position(self, body: int, offset: ArrayLike = (0.0, 0.0, 0.0)) -> ca.SX:
        """(3,) world position of a point fixed to a body."""
        return self._positions[body] + self._rotations[body] @ _constant(offset)

    def rotation(self, body: int) -> ca.SX:
        """(3, 3) orientation of a body in the world."""
        return self._rotations[body]

    def position_jacobian(self, body: int, point: ca.SX) -> ca.SX:
        """(3, nv) derivative of a world point that moves with a body."""
        jacobian = ca.SX(3, self.model.nv)
        for dof in self._ancestors[body]:
            motion = self._motions[dof]
            jacobian[:, dof] = motion.axis if motion.origin is None else ca.cross(motion.axis, point - motion.origin)
        return jacobian

    def rotation_jacobian(self, body: int) -> ca.SX:
        """(3, nv) angular velocity of a body in the world frame."""
        jacobian = ca.SX(3, self.model.nv)
        for dof in self._ancestors[body]:
            if self._motions[dof].origin is not None:
                jacobian[:, dof] = self._motions[dof].axis
        return jacobian

    def centre_of_mass(self) -> tuple[ca.SX, ca.SX]:
        """(3,) centre of mass of the whole model and its Jacobian (3, nv), from subtree masses and centres."""
        model = self.model
        moments = [float(model.body_mass[b]) * self.position(b, model.body_ipos[b]) for b in range(model.nbody)]
        for body in range(model.nbody - 1, 0, -1):
            moments[model.body_parentid[body]] += moments[body]
        total = float(model.body_subtreemass[0])
        jacobian = ca.SX(3, model.nv)
        for dof, motion in self._motions.items():
            mass = float(model.body_subtreemass[motion.body])
            if motion.origin is None:
                jacobian[:, dof] = motion.axis * (mass / total)
            else:
                jacobian[:, dof] = ca.cross(motion.axis, moments[motion.body] - mass * motion.origin) / total
        return moments[0] / total, jacobian

    def _place(self, body: int) -> None:
        model = self.model
        parent = model.body_parentid[body]
        position = self.position(parent, model.body_pos[body])
        rotation = self._rotations[parent] @ _constant(_matrix(model.body_quat[body]))
        ancestors = self._ancestors[parent]
        first = model.body_jntadr[body]
        for joint in range(first, first + model.body_jntnum[body]):
            position, rotation, dofs = self._move(body, joint, position, rotation)
            ancestors += dofs
        self._positions.append(position)
        self._rotations.append(rotation)
        self._ancestors.append(ancestors)

    def _move(self, body: int, joint: int, position: ca.SX, rotation: ca.SX) -> tuple[ca.SX, ca.SX, tuple[int, ...]]:
        model = self.model
        kind, at, dof = model.jnt_type[joint], model.jnt_qposadr[joint], int(model.jnt_dofadr[joint])
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            position, rotation = self.qpos[at : at + 3], quaternion_matrix(self.qpos[at + 3 : at + 7])
            for k in range(3):
                self._motions[dof + k] = _Motion(body, ca.SX.eye(3)[:, k], None)
                self._motions[dof + 3 + k] = _Motion(body, rotation[:, k], position)
            return position, rotation, tuple(range(dof, dof + 6))
        if kind == mujoco.mjtJoint.mjJNT_BALL:
            raise UnsupportedModel(f"joint {model.joint(joint).name!r} is a ball joint; valid: free, hinge, slide")
        axis = rotation @ _constant(model.jnt_axis[joint])
        value = self.qpos[at] - float(model.qpos0[at])
        if kind == mujoco.mjtJoint.mjJNT_SLIDE:
            self._motions[dof] = _Motion(body, axis, None)
            return position + axis * value, rotation, (dof,)
        anchor = position + rotation @ _constant(model.jnt_pos[joint])
        self._motions[dof] = _Motion(body, axis, anchor)
        rotation = rotation @ _axis_rotation(model.jnt_axis[joint], value)
        return anchor - rotation @ _constant(model.jnt_pos[joint]), rotation, (dof,)


def quaternion_matrix(quaternion: ca.SX) -> ca.SX:
    """(3, 3) rotation matrix of a unit quaternion wxyz."""
    w, x, y, z = (quaternion[i] for i in range(4))
    return ca.vertcat(
        ca.horzcat(1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        ca.horzcat(2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        ca.horzcat(2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def rotation_error(rotation: ca.SX, target: ca.SX) -> ca.SX:
    """(3,) `2 sin(angle / 2) axis` of the world rotation from `target` to `rotation`.

    Equal to the rotation vector to second order and monotonic up to half a turn, where the rotation vector jumps.
    """
    error = rotation @ target.T
    axis_sin = ca.vertcat(error[2, 1] - error[1, 2], error[0, 2] - error[2, 0], error[1, 0] - error[0, 1]) / 2
    cosine = (error[0, 0] + error[1, 1] + error[2, 2] - 1) / 2
    return axis_sin / ca.sqrt(ca.fmax((1 + cosine) / 2, 1e-3))


def _matrix(quaternion: np.ndarray) -> np.ndarray:
    matrix = np.zeros(9)
    mujoco.mju_quat2Mat(matrix, np.asarray(quaternion, dtype=float))
    return matrix.reshape(3, 3)


def _constant(values: ArrayLike) -> ca.DM:
    """A constant with structural zeros, so that products with it cost nothing."""
    array = np.asarray(values, dtype=float)
    array = np.where(np.abs(array - np.round(array)) < 1e-14, np.round(array), array)
    return ca.sparsify(ca.DM(array))


def _axis_rotation(axis: np.ndarray, angle: ca.SX) -> ca.SX:
    """Rodrigues' formula; structurally sparse for an axis along x, y or z."""
    x, y, z = (float(a) for a in axis)
    cross = _constant([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    along = _constant(np.outer(axis, axis))
    return along + ca.cos(angle) * (_constant(np.eye(3) - np.outer(axis, axis))) + ca.sin(angle) * cross
