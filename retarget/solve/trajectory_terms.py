"""One frame of a trajectory as a CasADi function: Gauss-Newton terms of its targets, feet, and heights of the soles."""

import casadi as ca

from retarget.body.geometry import RobotGeometry
from retarget.body.kinematics import Kinematics, rotation_error
from retarget.solve.frame_problem import POINT_WEIGHTS, ROTATION_WEIGHTS

CORNERS = 4
"""Corners of a sole."""


def trajectory_terms(geometry: RobotGeometry) -> ca.Function:
    """Build the function of one frame, with P points, K body frames, F feet and tangent dimension nv.

    Inputs: `qpos` (nq); targets `points` (3, P), `rotations` (9, K, row-major), `soles` (3, F), `sole_rotations` (9, F)
    and `com` (2); weights `sole_weights` (2, F: position, rotation) and `com_weight` (1). The other weights are those
    of `retarget.solve.frame_problem`.

    Outputs: `hessian` (nv, nv) J'J and `gradient` (nv) J'r of the weighted residuals, `cost` (1) r'r; `foot_error`
    (3, 2F) position (m) and rotation errors of the feet; `height` (4F) m of the sole corners with `height_jacobian`
    (nv, 4F); `point_error` (P) m; `centre_of_mass` (3).
    """
    kinematics, size = Kinematics(geometry.model), geometry.limb_length
    followed, frames, feet = geometry.followed, geometry.frames, geometry.feet
    shapes = {
        "points": (3, len(followed)),
        "rotations": (9, len(frames)),
        "soles": (3, len(feet)),
        "sole_rotations": (9, len(feet)),
        "com": (2, 1),
        "sole_weights": (2, len(feet)),
        "com_weight": (1, 1),
    }
    inputs = {"qpos": kinematics.qpos} | {name: ca.SX.sym(name, *shape) for name, shape in shapes.items()}
    residuals: list[ca.SX] = []
    jacobians: list[ca.SX] = []
    distances: list[ca.SX] = []
    for i, name in enumerate(followed):
        weight = POINT_WEIGHTS.get(name.removeprefix("left_").removeprefix("right_"), 1.0) / size
        point = kinematics.position(geometry.bodies[name], geometry.offsets[name])
        error = point - inputs["points"][:, i]
        residuals.append(weight * error)
        jacobians.append(weight * kinematics.position_jacobian(geometry.bodies[name], point))
        distances.append(ca.norm_2(error))
    for i, (name, body) in enumerate(frames.items()):
        weight = ROTATION_WEIGHTS.get(name, 1.0)
        residuals.append(weight * rotation_error(kinematics.rotation(body), _matrix(inputs["rotations"][:, i])))
        jacobians.append(weight * kinematics.rotation_jacobian(body))
    foot_errors: list[ca.SX] = []
    heights: list[ca.SX] = []
    height_rows: list[ca.SX] = []
    for i, foot in enumerate(feet):
        sole = kinematics.position(foot.body, foot.centre)
        turn = rotation_error(kinematics.rotation(foot.body), _matrix(inputs["sole_rotations"][:, i]))
        pair = (sole - inputs["soles"][:, i], turn)
        pair_rows = (kinematics.position_jacobian(foot.body, sole), kinematics.rotation_jacobian(foot.body))
        foot_errors += pair
        residuals += [inputs["sole_weights"][k, i] * pair[k] for k in range(2)]
        jacobians += [inputs["sole_weights"][k, i] * pair_rows[k] for k in range(2)]
        for corner in foot.corners:
            point = kinematics.position(foot.body, corner)
            heights.append(point[2])
            height_rows.append(kinematics.position_jacobian(foot.body, point)[2, :])
    com, com_jacobian = kinematics.centre_of_mass()
    residuals.append(inputs["com_weight"] * (com[:2] - inputs["com"]))
    jacobians.append(inputs["com_weight"] * com_jacobian[:2, :])
    residual, jacobian = ca.vertcat(*residuals), ca.vertcat(*jacobians)
    outputs = {
        "hessian": jacobian.T @ jacobian,
        "gradient": jacobian.T @ residual,
        "cost": ca.dot(residual, residual),
        "foot_error": ca.horzcat(ca.SX(3, 0), *foot_errors),
        "height": ca.vertcat(ca.SX(0, 1), *heights),
        "height_jacobian": ca.vertcat(ca.SX(0, geometry.model.nv), *height_rows).T,
        "point_error": ca.vertcat(*distances),
        "centre_of_mass": com,
    }
    dense = [ca.densify(expression) for expression in outputs.values()]
    return ca.Function("trajectory_terms", list(inputs.values()), dense, list(inputs), list(outputs))


def _matrix(row_major: ca.SX) -> ca.SX:
    return ca.reshape(row_major, 3, 3).T
