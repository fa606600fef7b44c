"""Joints that follow others: MuJoCo's `<equality><joint>`, where one joint is a polynomial of another or a constant.

Kinematics, solvers and playback treat such a joint as a function of its source: the source is the coordinate, the
follower has no freedom of its own. A joint that a description locks is a follower of nothing.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from ros_free_stack.errors import UnsupportedModel
from ros_free_stack.messages import Floats

_SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True)
class Coupling:
    """q - q0 = c0 + c1 x + c2 x^2 + c3 x^3 + c4 x^4 with x = s - s0, for a joint q and its source s, None for x = 0.

    Attributes:
        joint: id of the joint that follows.
        source: id of the joint that it follows, or None.
        coefficients: c0 to c4.
    """

    joint: int
    source: int | None
    coefficients: tuple[float, float, float, float, float]


def joint_couplings(model: mujoco.MjModel) -> tuple[Coupling, ...]:
    """The model's active joint equalities, every source before its followers.

    Raises:
        UnsupportedModel: a loop closed by another kind of equality, a joint that follows two or itself, or one that is
            neither a hinge nor a slide.
    """
    found: dict[int, Coupling] = {}
    for equality in np.flatnonzero(model.eq_active0):
        kind = mujoco.mjtEq(int(model.eq_type[equality]))
        if kind in (mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD, mujoco.mjtEq.mjEQ_TENDON):
            name = model.equality(equality).name or kind.name.removeprefix("mjEQ_").lower()
            raise UnsupportedModel(
                f"equality {name!r} closes a loop of bodies or tendons; valid: <joint> equalities in <equality>"
            )
        if kind == mujoco.mjtEq.mjEQ_JOINT:
            coupling = _coupling(model, int(equality))
            if coupling.joint in found:
                raise UnsupportedModel(f"joint {model.joint(coupling.joint).name!r} follows two equalities")
            found[coupling.joint] = coupling
    return _ordered(model, found)


def settle(model: mujoco.MjModel, couplings: tuple[Coupling, ...], qpos: Floats) -> None:
    """Put every joint of a configuration (nq,) that follows another where it belongs."""
    for coupling in couplings:
        at = model.jnt_qposadr[coupling.joint]
        qpos[at] = model.qpos0[at] + np.polynomial.polynomial.polyval(
            _displacement(model, coupling, qpos), coupling.coefficients
        )


def fold(model: mujoco.MjModel, couplings: tuple[Coupling, ...], qpos: Floats, jacobian: Floats) -> None:
    """Move the columns of joints that follow others in a Jacobian (R, nv) to their sources, by the chain rule."""
    for coupling in reversed(couplings):
        column = jacobian[:, model.jnt_dofadr[coupling.joint]]
        if coupling.source is not None:
            slope = np.polynomial.polynomial.polyder(coupling.coefficients)
            rate = np.polynomial.polynomial.polyval(_displacement(model, coupling, qpos), slope)
            jacobian[:, model.jnt_dofadr[coupling.source]] += rate * column
        column[:] = 0.0


def _displacement(model: mujoco.MjModel, coupling: Coupling, qpos: Floats) -> float:
    if coupling.source is None:
        return 0.0
    at = model.jnt_qposadr[coupling.source]
    return float(qpos[at] - model.qpos0[at])


def _coupling(model: mujoco.MjModel, equality: int) -> Coupling:
    joint, source = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
    for item in (joint, source):
        if item >= 0 and mujoco.mjtJoint(int(model.jnt_type[item])) not in _SCALAR:
            raise UnsupportedModel(f"joint {model.joint(item).name!r} of an equality is neither a hinge nor a slide")
    c0, c1, c2, c3, c4 = (float(value) for value in model.eq_data[equality, :5])
    return Coupling(joint, source if source >= 0 else None, (c0, c1, c2, c3, c4))


def _ordered(model: mujoco.MjModel, found: dict[int, Coupling]) -> tuple[Coupling, ...]:
    ordered: list[Coupling] = []
    waiting = dict(found)
    while waiting:
        ready = [joint for joint, item in waiting.items() if item.source not in waiting]
        if not ready:
            names = ", ".join(repr(model.joint(joint).name) for joint in waiting)
            raise UnsupportedModel(f"joints {names} follow each other in a circle")
        ordered += [waiting.pop(joint) for joint in ready]
    return tuple(ordered)
