"""Symbolic kinematics: a compiled MuJoCo model walked into CasADi expressions with analytic Jacobians.

Tangent vectors have MuJoCo's layout (nv,): a free joint is a world translation (3) and a rotation vector in the body's
frame (3), a hinge or a slide is one number. Jacobians are those of MuJoCo's `mj_jac`: translations and rotation vectors
in the world frame. A joint that follows another one (`ros_free_stack.couplings`) is a function of it: its own entry of
`qpos` plays no part, its column of every Jacobian is zero, and its motion counts, by the chain rule, to its source. See
Featherstone, "Rigid Body Dynamics Algorithms" (2008), chapters 2 to 4.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import casadi as ca
import mujoco
import numpy as np
from numpy.typing import ArrayLike

from ros_free_stack.couplings import Coupling, joint_couplings
from ros_free_stack.errors import UnsupportedModel


@dataclass(frozen=True)
class _Motion:
    """How one axis moves everything after it: along `axis`, or about it through `origin`, `rate` times its `dof`."""

    body: int
    dof: int
    rate: ca.SX | float
    axis: ca.SX
    origin: ca.SX | None


class Kinematics:
    """Positions, orientations and Jacobians of a model's bodies as functions of the symbol `qpos` (nq,).

    Quaternions in `qpos` are taken to have unit norm.

    Raises:
        UnsupportedModel: the model has a ball joint, or an equality that no joint can be eliminated by.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self.model = model
        self.qpos = ca.SX.sym("qpos", model.nq)
        self._couplings = {coupling.joint: coupling for coupling in joint_couplings(model)}
        self._positions: list[ca.SX] = [ca.SX(3, 1)]
        self._rotations: list[ca.SX] = [ca.SX.eye(3)]
        self._motions: list[tuple[_Motion, ...]] = [()]
        self._twists: dict[int, ca.SX] = {}
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
        return self._jacobian(
            (motion, motion.axis if motion.origin is None else ca.cross(motion.axis, point - motion.origin))
            for motion in self._motions[body]
        )

    def rotation_jacobian(self, body: int) -> ca.SX:
        """(3, nv) angular velocity of a body in the world frame."""
        return self._jacobian((motion, motion.axis) for motion in self._motions[body] if motion.origin is not None)

    def twist_jacobian(self, body: int) -> ca.SX:
        """(6, nv) velocity at the world's origin, above the angular velocity, of a body.

        What moves two bodies alike has the same nodes in both, and so no part in their difference.
        """
        jacobian = ca.SX(6, self.model.nv)
        for motion in self._motions[body]:
            jacobian[:, motion.dof] += motion.rate * self._twists.setdefault(id(motion), _twist(motion))
        return jacobian

    def centre_of_mass(self) -> tuple[ca.SX, ca.SX]:
        """(3,) centre of mass of the whole model and its Jacobian (3, nv), from subtree masses and centres."""
        model = self.model
        moments = [float(model.body_mass[b]) * self.position(b, model.body_ipos[b]) for b in range(model.nbody)]
        for body in range(model.nbody - 1, 0, -1):
            moments[model.body_parentid[body]] += moments[body]
        total = float(model.body_subtreemass[0])

        def column(motion: _Motion) -> ca.SX:
            mass = float(model.body_subtreemass[motion.body])
            if motion.origin is None:
                return motion.axis * (mass / total)
            return ca.cross(motion.axis, moments[motion.body] - mass * motion.origin) / total

        every = {id(motion): motion for motions in self._motions for motion in motions}
        return moments[0] / total, self._jacobian((motion, column(motion)) for motion in every.values())

    def _jacobian(self, columns: Iterable[tuple[_Motion, ca.SX]]) -> ca.SX:
        jacobian = ca.SX(3, self.model.nv)
        for motion, column in columns:
            jacobian[:, motion.dof] += motion.rate * column
        return jacobian

    def _place(self, body: int) -> None:
        model = self.model
        parent = model.body_parentid[body]
        position = self.position(parent, model.body_pos[body])
        rotation = self._rotations[parent] @ _constant(_matrix(model.body_quat[body]))
        motions = self._motions[parent]
        first = model.body_jntadr[body]
        for joint in range(first, first + model.body_jntnum[body]):
            position, rotation, moved = self._move(body, joint, position, rotation)
            motions += moved
        self._positions.append(position)
        self._rotations.append(rotation)
        self._motions.append(motions)

    def _move(
        self, body: int, joint: int, position: ca.SX, rotation: ca.SX
    ) -> tuple[ca.SX, ca.SX, tuple[_Motion, ...]]:
        model = self.model
        kind, at, dof = model.jnt_type[joint], model.jnt_qposadr[joint], int(model.jnt_dofadr[joint])
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            position, rotation = self.qpos[at : at + 3], quaternion_matrix(self.qpos[at + 3 : at + 7])
            along = (_Motion(body, dof + k, 1.0, ca.SX.eye(3)[:, k], None) for k in range(3))
            about = (_Motion(body, dof + 3 + k, 1.0, rotation[:, k], position) for k in range(3))
            return position, rotation, (*along, *about)
        if kind == mujoco.mjtJoint.mjJNT_BALL:
            raise UnsupportedModel(f"joint {model.joint(joint).name!r} is a ball joint; valid: free, hinge, slide")
        axis = rotation @ _constant(model.jnt_axis[joint])
        value, source, rate = self._value(joint)
        if kind == mujoco.mjtJoint.mjJNT_SLIDE:
            position, origin = position + axis * value, None
        else:
            origin = position + rotation @ _constant(model.jnt_pos[joint])
            rotation = rotation @ _axis_rotation(model.jnt_axis[joint], value)
            position = origin - rotation @ _constant(model.jnt_pos[joint])
        if source is None:
            return position, rotation, ()
        return position, rotation, (_Motion(body, int(model.jnt_dofadr[source]), rate, axis, origin),)

    def _value(self, joint: int) -> tuple[ca.SX, int | None, ca.SX | float]:
        """Displacement of a joint from the model's own pose, the joint that decides it, and its rate against that."""
        coupling = self._couplings.get(joint)
        if coupling is None:
            at = self.model.jnt_qposadr[joint]
            return self.qpos[at] - float(self.model.qpos0[at]), joint, 1.0
        if coupling.source is None:
            return ca.SX(coupling.coefficients[0]), None, 0.0
        x, source, rate = self._value(coupling.source)
        return _polynomial(coupling, x), source, rate * _slope(coupling, x)


def _twist(motion: _Motion) -> ca.SX:
    if motion.origin is None:
        return ca.vertcat(motion.axis, ca.SX(3, 1))
    return ca.vertcat(ca.cross(motion.origin, motion.axis), motion.axis)


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


def _polynomial(coupling: Coupling, x: ca.SX) -> ca.SX:
    return sum((c * x**power for power, c in enumerate(coupling.coefficients) if c), ca.SX(0))


def _slope(coupling: Coupling, x: ca.SX) -> ca.SX:
    return sum((c * power * x ** (power - 1) for power, c in enumerate(coupling.coefficients) if c and power), ca.SX(0))


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
