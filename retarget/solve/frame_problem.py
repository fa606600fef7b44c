"""One frame as a quadratic program, in CasADi: least squares over a step of the configuration, bounds and rows.

With the configuration q after the step s from where the frame began, the residuals r and their Jacobian J at q, and the
last frame's step l, an increment d of the step minimises

    |W (r + J d)|^2 + |d|^2_D + |s + d - l|^2_S + p |q + d - standing|^2

subject to bounds of s + d, planted feet held where they are, the other feet's corners above the floor, and limbs apart.
"""

from dataclasses import dataclass

import casadi as ca
import numpy as np

from retarget.body.geometry import RobotGeometry
from retarget.body.kinematics import Kinematics, rotation_error
from retarget.solve.limits import reach

POINT_WEIGHTS = {"pelvis": 6.0, "elbow": 2.0, "wrist": 3.0, "knee": 1.0}
"""Weights of position errors in units of the reference length."""
ROTATION_WEIGHTS = {"pelvis": 4.0, "torso": 4.0, "head": 1.0}
COM_WEIGHT = 15.0
SWING_WEIGHTS = (10.0, 3.0)
STANCE_WEIGHTS = (40.0, 10.0)
"""Weights of a foot's (position in leg lengths, rotation): in the air, and standing but not yet planted."""
DAMPING = 2e-2
ROOT_SHARE = 0.1
"""Damping of the root over that of a joint."""
STEP_CHANGE = 2e-2
"""Cost of a joint's change of step, against jitter; the root weighs its own tracking."""

NEAREST = 12
"""Pairs of limbs that one frame keeps apart."""
UNBOUNDED = 1e30


POSE, CORNERS = 6, 4
"""Rows of a foot: its pose where it is held; of a foot in the air its corners take the place of the first four."""


class _Residuals:
    """Weighted residuals and their Jacobians."""

    def __init__(self) -> None:
        self._errors: list[ca.SX] = []
        self._jacobians: list[ca.SX] = []

    def add(self, weight: ca.SX | float, error: ca.SX, jacobian: ca.SX) -> None:
        self._errors.append(weight * error)
        self._jacobians.append(weight * jacobian)

    def terms(self) -> tuple[ca.SX, ca.SX, ca.SX]:
        """J'J (nv, nv), J'r (nv,) and r'r."""
        error, jacobian = ca.vertcat(*self._errors), ca.vertcat(*self._jacobians)
        hessian = jacobian.T @ jacobian
        # The lower half is the upper one: half of the products.
        return ca.triu2symm(ca.triu(hessian)), jacobian.T @ error, ca.dot(error, error)


@dataclass
class _Rows:
    """Rows (nv,) of constraints with their bounds, and what is told of the feet."""

    jacobian: list[ca.SX]
    lower: list[ca.SX]
    upper: list[ca.SX]
    states: list[ca.SX]
    soles: list[ca.SX]


@dataclass(frozen=True)
class FrameFunctions:
    """Two functions of one frame with the same inputs, for P points, K body frames, F feet, tangent dimension nv.

    Inputs: `start` (nq) configuration and `step` (nv) from it; `limits` (nv, 4: `JointBounds.table`) and `last` (nv)
    the last frame's step; `points` (3, P), `rotations` (9, K, row-major), `soles` (3, F), `sole_rotations` (9, F) and
    `com` (2) targets; `contact` and `held` (F) 1 for feet that stand and for those held at their `anchors` (12, F:
    position, rotation); `com_weight` (1) of the residual; `posture` (1) pull toward the standing pose; `apart_rows`
    (nv, NEAREST) and `apart` (NEAREST) least changes of distances between limbs since the start.

    Attributes:
        program: the quadratic program after the step: `low`, `high` (nv) bounds of the step; `hessian` (nv, nv),
            `gradient` (nv), `rows` (nv, POSE F) of the feet, and bounds `lower`, `upper` (nv + POSE F + NEAREST) of the
            increment, of the feet and of the limbs.
        state: what is reached after the step: `qpos` (nq); `cost` (1) of the residuals; `point_error` (P) m; `feet`
            (4, F): distance to the target in m and rad, height of the corner farthest from the floor in m, cosine of
            the tilt; `sole` (12, F: position, rotation); `centre_of_mass` (3).
    """

    program: ca.Function
    state: ca.Function


def frame_functions(geometry: RobotGeometry) -> FrameFunctions:
    """Build the functions of one frame."""
    model, feet = geometry.model, len(geometry.feet)
    kinematics, residuals = Kinematics(model), _Residuals()
    shapes = {
        "start": (model.nq, 1), "step": (model.nv, 1), "limits": (model.nv, 4), "last": (model.nv, 1),
        "points": (3, len(geometry.followed)), "rotations": (9, len(geometry.frames)), "soles": (3, feet),
        "sole_rotations": (9, feet), "contact": (feet, 1), "held": (feet, 1), "anchors": (12, feet), "com": (2, 1),
        "com_weight": (1, 1), "posture": (1, 1), "apart_rows": (model.nv, NEAREST), "apart": (NEAREST, 1),
    }  # fmt: skip
    inputs = {name: ca.SX.sym(name, *shape) for name, shape in shapes.items()}
    distances = _follow(geometry, kinematics, inputs, residuals)
    low, high = reach(_joint_positions(geometry, inputs["start"]), inputs["last"], inputs["limits"])
    feet_rows = _feet(geometry, kinematics, inputs, residuals)
    com, com_jacobian = kinematics.centre_of_mass()
    residuals.add(inputs["com_weight"], com[:2] - inputs["com"], com_jacobian[:2, :])

    hessian, gradient, cost = residuals.terms()
    own_hessian, own_gradient = _regularisation(geometry, kinematics.qpos, inputs)
    apart = inputs["apart"] - inputs["apart_rows"].T @ inputs["step"]
    program = {
        "low": low,
        "high": high,
        "hessian": hessian + own_hessian,
        "gradient": gradient + own_gradient,
        "rows": ca.vertcat(ca.SX(0, model.nv), *feet_rows.jacobian).T,
        "lower": ca.vertcat(low - inputs["step"], *feet_rows.lower, apart),
        "upper": ca.vertcat(high - inputs["step"], *feet_rows.upper, ca.SX.ones(NEAREST) * UNBOUNDED),
    }
    state = {
        "qpos": kinematics.qpos,
        "cost": cost,
        "point_error": ca.vertcat(*distances),
        "feet": ca.horzcat(ca.SX(4, 0), *feet_rows.states),
        "sole": ca.horzcat(ca.SX(12, 0), *feet_rows.soles),
        "centre_of_mass": com,
    }
    return FrameFunctions(
        _after_step("frame_program", kinematics.qpos, inputs, program),
        _after_step("frame_state", kinematics.qpos, inputs, state),
    )


def _after_step(name: str, qpos: ca.SX, inputs: dict[str, ca.SX], outputs: dict[str, ca.SX]) -> ca.Function:
    """The function of expressions in `qpos` at the configuration after the step."""
    here = ca.Function("here", [qpos, *inputs.values()], list(outputs.values()))
    results = here.call([stepped(inputs["start"], inputs["step"]), *inputs.values()])
    dense = [ca.densify(value) for value in results]
    return ca.Function(name, list(inputs.values()), dense, list(inputs), list(outputs))


def _follow(
    geometry: RobotGeometry, kinematics: Kinematics, inputs: dict[str, ca.SX], residuals: _Residuals
) -> list[ca.SX]:
    """Residuals of points and orientations; returns the points' distances to their targets."""
    distances: list[ca.SX] = []
    for i, name in enumerate(geometry.followed):
        weight = POINT_WEIGHTS.get(name.removeprefix("left_").removeprefix("right_"), 1.0) / geometry.limb_length
        point = kinematics.position(geometry.bodies[name], geometry.offsets[name])
        error = point - inputs["points"][:, i]
        residuals.add(weight, error, kinematics.position_jacobian(geometry.bodies[name], point))
        distances.append(ca.norm_2(error))
    for i, (name, body) in enumerate(geometry.frames.items()):
        error = rotation_error(kinematics.rotation(body), _matrix(inputs["rotations"][:, i]))
        residuals.add(ROTATION_WEIGHTS.get(name, 1.0), error, kinematics.rotation_jacobian(body))
    return distances


def _feet(geometry: RobotGeometry, kinematics: Kinematics, inputs: dict[str, ca.SX], residuals: _Residuals) -> _Rows:
    """Residuals of the soles, and rows that hold some and keep the others' corners above the floor."""
    rows = _Rows([], [], [], [], [])
    for i, foot in enumerate(geometry.feet):
        held, landing = inputs["held"][i], inputs["contact"][i] * (1 - inputs["held"][i])
        goal = ca.vertcat(inputs["soles"][:, i], inputs["sole_rotations"][:, i])
        goal = ca.if_else(held, inputs["anchors"][:, i], goal)
        sole, turn = kinematics.position(foot.body, foot.centre), kinematics.rotation(foot.body)
        errors = (sole - goal[:3], rotation_error(turn, _matrix(goal[3:])))
        jacobians = (kinematics.position_jacobian(foot.body, sole), kinematics.rotation_jacobian(foot.body))
        for k, unit in enumerate((geometry.limb_length, 1.0)):
            weight = (SWING_WEIGHTS[k] + landing * (STANCE_WEIGHTS[k] - SWING_WEIGHTS[k])) / unit
            residuals.add(weight, errors[k], jacobians[k])
        corners = [kinematics.position(foot.body, corner) for corner in foot.corners]
        heights = ca.vertcat(*[corner[2] for corner in corners])
        error, pose, loose = ca.vertcat(*errors), ca.vertcat(*jacobians), UNBOUNDED * (1 - held)
        clear = ca.vertcat(*[kinematics.position_jacobian(foot.body, corner)[2, :] for corner in corners])
        rows.jacobian += [ca.if_else(held, ca.densify(pose[:CORNERS, :]), ca.densify(clear)), pose[CORNERS:, :]]
        first, last = -error[:CORNERS], -error[CORNERS:]
        rows.lower += [ca.if_else(held, first, -heights), last - loose]
        rows.upper += [ca.if_else(held, first, UNBOUNDED), last + loose]
        upright = ca.dot(turn[2, :], ca.DM(foot.reference[2, :]).T)
        rows.states.append(ca.vertcat(*[ca.norm_2(e) for e in errors], ca.mmax(ca.fabs(heights)), upright))
        rows.soles.append(ca.vertcat(sole, ca.vec(turn.T)))
    return rows


def stepped(start: ca.SX, step: ca.SX) -> ca.SX:
    """(nq,) configuration after a tangent step (nv,), as `mujoco.mj_integratePos` makes it."""
    half = ca.norm_2(step[3:6]) / 2
    # sin(x) / x without a division by zero.
    share = ca.if_else(half < 1e-6, 0.5, ca.sin(half) / (2 * ca.fmax(half, 1e-6)))
    w, (x, y, z) = ca.cos(half), (share * step[3 + i] for i in range(3))
    a, b, c, d = (start[3 + i] for i in range(4))
    turned = ca.vertcat(
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )
    return ca.vertcat(start[:3] + step[:3], turned / ca.norm_2(turned), start[7:] + step[6:])


def _joint_positions(geometry: RobotGeometry, qpos: ca.SX) -> ca.SX:
    """(nv,) positions of the described joints in the places of their steps, 0 elsewhere."""
    positions = ca.SX.zeros(geometry.model.nv)
    for address, dof in zip(geometry.qpos_index.tolist(), geometry.dof_index.tolist(), strict=True):
        positions[dof] = qpos[address]
    return positions


def _regularisation(geometry: RobotGeometry, qpos: ca.SX, inputs: dict[str, ca.SX]) -> tuple[ca.SX, ca.SX]:
    """(nv, nv) and (nv,) of damping, of an even step and of the pull toward the standing pose."""
    nv = geometry.model.nv
    damping, smoothing = np.full(nv, DAMPING), np.full(nv, STEP_CHANGE)
    damping[:6] *= ROOT_SHARE
    smoothing[:3] = (POINT_WEIGHTS["pelvis"] / geometry.limb_length) ** 2
    smoothing[3:6] = ROTATION_WEIGHTS["pelvis"] ** 2
    posture = ca.SX(nv, 1)
    posture[geometry.dof_index.tolist()] = inputs["posture"]
    away = _joint_positions(geometry, qpos - ca.DM(geometry.standing))
    hessian = ca.diag(posture + ca.DM(damping + smoothing))
    return hessian, ca.DM(smoothing) * (inputs["step"] - inputs["last"]) + posture * away


def _matrix(row_major: ca.SX) -> ca.SX:
    return ca.reshape(row_major, 3, 3).T
