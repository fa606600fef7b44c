"""One frame's least-squares problem as a CasADi function: Gauss-Newton terms, foot poses, sole heights, balance."""

from collections.abc import Iterable

import casadi as ca

from retarget.geometry import RobotGeometry
from retarget.kinematics import Kinematics, rotation_error


def frame_problem(geometry: RobotGeometry) -> ca.Function:
    """Build the function of one frame, with P points, K body frames, F feet and tangent dimension nv.

    Inputs: `qpos` (nq); `points` (3, P), `rotations` (9, K, row-major), `soles` (3, F), `sole_rotations` (9, F) and
    `com` (2) are targets; `point_weights` (P), `rotation_weights` (K), `sole_weights` (2, F: position, rotation) and
    `com_weight` (1) multiply residuals.

    Outputs: `hessian` (nv, nv) J'J and `gradient` (nv) J'r of all weighted residuals, `cost` (1) r'r;
    `foot_error` (6F) position and rotation errors of the feet with `foot_jacobian` (6F, nv); `height` (4F) of the sole
    corners with `height_jacobian` (4F, nv); `point_error` (P) in m; `centre_of_mass` (3).
    """
    kinematics = Kinematics(geometry.model)
    followed, frames, feet = geometry.followed, geometry.frames, geometry.feet
    inputs = {
        "qpos": kinematics.qpos,
        "points": ca.SX.sym("points", 3, len(followed)),
        "rotations": ca.SX.sym("rotations", 9, len(frames)),
        "soles": ca.SX.sym("soles", 3, len(feet)),
        "sole_rotations": ca.SX.sym("sole_rotations", 9, len(feet)),
        "com": ca.SX.sym("com", 2),
        "point_weights": ca.SX.sym("point_weights", len(followed)),
        "rotation_weights": ca.SX.sym("rotation_weights", len(frames)),
        "sole_weights": ca.SX.sym("sole_weights", 2, len(feet)),
        "com_weight": ca.SX.sym("com_weight"),
    }
    errors: list[ca.SX] = []
    jacobians: list[ca.SX] = []
    distances: list[ca.SX] = []
    for i, name in enumerate(followed):
        body, weight = geometry.bodies[name], inputs["point_weights"][i]
        point = kinematics.position(body, geometry.offsets[name])
        error = point - inputs["points"][:, i]
        errors.append(weight * error)
        jacobians.append(weight * kinematics.position_jacobian(body, point))
        distances.append(ca.norm_2(error))
    for i, body in enumerate(frames.values()):
        weight = inputs["rotation_weights"][i]
        errors.append(weight * rotation_error(kinematics.rotation(body), _matrix(inputs["rotations"][:, i])))
        jacobians.append(weight * kinematics.rotation_jacobian(body))
    foot_errors: list[ca.SX] = []
    foot_jacobians: list[ca.SX] = []
    heights: list[ca.SX] = []
    height_jacobians: list[ca.SX] = []
    for i, foot in enumerate(feet):
        sole = kinematics.position(foot.body, foot.centre)
        target = _matrix(inputs["sole_rotations"][:, i])
        pair = (sole - inputs["soles"][:, i], rotation_error(kinematics.rotation(foot.body), target))
        pair_jacobian = (kinematics.position_jacobian(foot.body, sole), kinematics.rotation_jacobian(foot.body))
        foot_errors += pair
        foot_jacobians += pair_jacobian
        for k in range(2):
            errors.append(inputs["sole_weights"][k, i] * pair[k])
            jacobians.append(inputs["sole_weights"][k, i] * pair_jacobian[k])
        for corner in foot.corners:
            point = kinematics.position(foot.body, corner)
            heights.append(point[2])
            height_jacobians.append(kinematics.position_jacobian(foot.body, point)[2, :])
    com, com_jacobian = kinematics.centre_of_mass()
    errors.append(inputs["com_weight"] * (com[:2] - inputs["com"]))
    jacobians.append(inputs["com_weight"] * com_jacobian[:2, :])

    residual, jacobian = ca.vertcat(*errors), ca.vertcat(*jacobians)
    outputs = {
        "hessian": jacobian.T @ jacobian,
        "gradient": jacobian.T @ residual,
        "cost": ca.dot(residual, residual),
        "foot_error": ca.vertcat(*foot_errors),
        "foot_jacobian": ca.vertcat(*foot_jacobians),
        "height": ca.vertcat(*heights),
        "height_jacobian": ca.vertcat(*height_jacobians),
        "point_error": ca.vertcat(*distances),
        "centre_of_mass": com,
    }
    return ca.Function("frame", list(inputs.values()), _dense(outputs.values()), list(inputs), list(outputs))


def _matrix(row_major: ca.SX) -> ca.SX:
    return ca.reshape(row_major, 3, 3).T


def _dense(expressions: Iterable[ca.SX]) -> list[ca.SX]:
    return [ca.densify(expression) for expression in expressions]
