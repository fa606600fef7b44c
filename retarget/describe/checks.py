"""Whether a description works: its kinematics are MuJoCo's, and a short motion retargets inside every limit."""

from dataclasses import dataclass

import casadi as ca
import mujoco
import numpy as np

from retarget.body.geometry import measure
from retarget.body.kinematics import Kinematics
from retarget.pipeline import Retargeter
from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.messages import Floats, HumanMotion, RobotTrajectory
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import FPS, INDEX

POSES = 20
AGREEMENT_M = 1e-9
EXCESS = 1e-6

REST = {
    "pelvis": (0.0, 0.0, 0.94), "left_hip": (0.0, 0.085, 0.865), "spine1": (-0.02, 0.0, 1.055),
    "left_knee": (0.02, 0.085, 0.47), "spine2": (-0.015, 0.0, 1.185), "left_ankle": (-0.02, 0.085, 0.075),
    "spine3": (-0.005, 0.0, 1.25), "left_foot": (0.11, 0.085, 0.02), "neck": (-0.02, 0.0, 1.455),
    "left_collar": (-0.015, 0.075, 1.365), "head": (0.0, 0.0, 1.555), "left_shoulder": (-0.02, 0.18, 1.40),
    "left_elbow": (-0.03, 0.21, 1.13), "left_wrist": (0.02, 0.22, 0.90),
}  # fmt: skip
"""A person of 1.7 m who stands, m; the right side mirrors the left."""


@dataclass(frozen=True)
class CheckResult:
    """One check: what was measured, in words, and whether that is good."""

    name: str
    detail: str
    passed: bool


def check_description(robot: RobotDescription) -> list[CheckResult]:
    """Run every check.

    Raises:
        StackError: the description does not load or its model is not supported.
    """
    difference = kinematics_difference(robot)
    found = [CheckResult("kinematics", f"{difference:.1e} m off MuJoCo", difference < AGREEMENT_M)]
    result = Retargeter(robot).retarget(check_motion())
    excess = limit_excess(robot, result.trajectory)
    worst = max(excess, key=lambda name: excess[name])
    found.append(CheckResult("limits", f"{worst} exceeded by {excess[worst]:.1e}", excess[worst] < EXCESS))
    errors = result.report.position_error_cm
    limb = max(errors, key=lambda name: errors[name].mean)
    found.append(CheckResult("following", f"worst on average {limb}, {errors[limb].mean:.1f} cm", True))
    return found


def kinematics_difference(robot: RobotDescription) -> float:
    """Largest difference in m between our attachments and MuJoCo's in random poses within the limits."""
    model = measure(robot).model
    kinematics = Kinematics(model)
    bodies = [(model.body(item.body).id, item.offset) for item in robot.attachments.values()]
    places = [kinematics.position(body, offset) for body, offset in bodies]
    function = ca.Function("points", [kinematics.qpos], [ca.horzcat(*places)])
    data, rng = mujoco.MjData(model), np.random.default_rng(0)
    worst = 0.0
    for _ in range(POSES):
        for name in robot.joints:
            data.joint(name).qpos[:] = rng.uniform(robot.joints[name].lower, robot.joints[name].upper)
        settle(model, joint_couplings(model), data.qpos)
        mujoco.mj_kinematics(model, data)
        ours = function(data.qpos).full().T
        theirs = [data.xpos[body] + data.xmat[body].reshape(3, 3) @ np.array(offset) for body, offset in bodies]
        worst = max(worst, float(np.abs(ours - theirs).max()))
    return worst


def limit_excess(robot: RobotDescription, trajectory: RobotTrajectory) -> dict[str, float]:
    """How far a trajectory is beyond each kind of limit, by its own differences: rad, rad/s, rad/s^2."""
    angles = trajectory.joint_pos
    speeds = np.diff(angles, axis=0) * trajectory.fps
    changes = np.diff(speeds, axis=0) * trajectory.fps
    return {
        "range": max(float((robot.lower - angles).max()), float((angles - robot.upper).max()), 0.0),
        "velocity": max(float((np.abs(speeds) - robot.velocity).max()), 0.0),
        "acceleration": max(float((np.abs(changes) - robot.acceleration).max()), 0.0),
    }


def check_motion() -> HumanMotion:
    """Two seconds: a person bends the knees a little while both arms rise to the side and come down again."""
    phase = np.linspace(0, 1, int(2 * FPS) + 1)
    rise = np.sin(np.pi * phase) ** 2
    joints = np.repeat(_rest()[None], len(phase), axis=0)
    upper = [name for name in INDEX if not name.endswith(("knee", "ankle", "foot"))]
    joints[:, [INDEX[name] for name in upper], 2] -= 0.12 * rise[:, None]
    for side, sign in (("left", 1.0), ("right", -1.0)):
        joints[:, INDEX[f"{side}_knee"]] += rise[:, None] * [0.12, 0.0, -0.05]
        shoulder = joints[:, INDEX[f"{side}_shoulder"]]
        turn = sign * 1.2 * rise
        for name in ("elbow", "wrist"):
            place = joints[:, INDEX[f"{side}_{name}"]]
            joints[:, INDEX[f"{side}_{name}"]] = shoulder + _rolled(place - shoulder, turn)
    return HumanMotion(joints, FPS, prompt="a person squats and raises both arms", source="check")


def _rest() -> Floats:
    joints = np.zeros((len(INDEX), 3))
    for name, place in REST.items():
        joints[INDEX[name]] = place
        joints[INDEX[name.replace("left", "right")]] = np.array(place) * ([1, -1, 1] if "left" in name else [1, 1, 1])
    return joints


def _rolled(vectors: Floats, angles: Floats) -> Floats:
    """Vectors (T, 3) turned about x by angles (T,), so that positive raises what hangs toward y."""
    cos, sin = np.cos(angles), np.sin(angles)
    x, y, z = vectors.T
    return np.column_stack([x, cos * y - sin * z, sin * y + cos * z])
