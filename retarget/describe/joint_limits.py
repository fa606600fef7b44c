"""Joint limits from a model: what it states; where it states nothing, a sweep or a default that is said to be one."""

from dataclasses import dataclass

import mujoco
import numpy as np

from retarget.describe.joint_sweep import sweep_joint_ranges
from retarget.describe.tree import Tree
from ros_free_stack.messages import Floats
from ros_free_stack.robots import JointLimits

DEFAULT_VELOCITY = 10.0
DEFAULT_ACCELERATION = 100.0
"""rad/s and rad/s^2 (m/s and m/s^2 for slides): slower than every humanoid's larger joints, and a lively motion."""
EFFORT_SHARE = 0.15
"""Default torque: this share of the robot's weight at an arm of its size."""

_AT_JOINTS = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)


@dataclass(frozen=True)
class FoundLimits:
    """Limits by joint name, and what of them the model does not state, also by name: `range`, `effort`."""

    limits: dict[str, JointLimits]
    guessed: dict[str, tuple[str, ...]]


def actuated_joints(tree: Tree) -> list[int]:
    """Ids of the joints that a motor moves; all that follow no other where the model has no motors."""
    model = tree.model
    own = [joint for body in sorted(tree.children) if body != tree.base for joint in tree.joints(body)]
    driven = {
        int(model.actuator_trnid[k, 0])
        for k in range(model.nu)
        if mujoco.mjtTrn(int(model.actuator_trntype[k])) in _AT_JOINTS
    }
    return [joint for joint in own if joint in driven or not driven]


def joint_ranges(tree: Tree, joints: list[int], starts: list[Floats]) -> tuple[Floats, list[bool]]:
    """(njnt, 2) ranges of all joints, rad or m, and for each of `joints` whether it was swept, since none is stated."""
    model = tree.model
    swept = [not model.jnt_limited[joint] for joint in joints]
    ranges = np.where(model.jnt_limited[:, None].astype(bool), model.jnt_range, [-np.pi, np.pi])
    unknown = [joint for joint, unlimited in zip(joints, swept, strict=True) if unlimited]
    if unknown:
        ranges[unknown] = sweep_joint_ranges(model, unknown, tree.base, starts, step=0.03)
    return ranges, swept


def found_limits(tree: Tree, joints: list[int], ranges: Floats, swept: list[bool]) -> FoundLimits:
    """Limits of the joints, from the model's ranges and motors."""
    model = tree.model
    default = EFFORT_SHARE * float(model.body_subtreemass[tree.base]) * 9.81 * tree.size
    limits: dict[str, JointLimits] = {}
    guessed: dict[str, tuple[str, ...]] = {}
    for joint, unlimited in zip(joints, swept, strict=True):
        effort = _effort(model, joint)
        name = model.joint(joint).name
        lower, upper = (round(float(value), 5) for value in ranges[joint])
        limits[name] = JointLimits(
            lower, upper, DEFAULT_VELOCITY, DEFAULT_ACCELERATION, round(default if effort is None else effort, 3)
        )
        guessed[name] = tuple(word for word, guess in (("range", unlimited), ("effort", effort is None)) if guess)
    return FoundLimits(limits, guessed)


def _effort(model: mujoco.MjModel, joint: int) -> float | None:
    """Torque or force limit of a joint: its own, else that of its motor; None where neither is stated."""
    if model.jnt_actfrclimited[joint]:
        return float(np.abs(model.jnt_actfrcrange[joint]).min())
    for k in np.flatnonzero(model.actuator_trnid[:, 0] == joint):
        gear = abs(float(model.actuator_gear[k, 0]))
        if model.actuator_forcelimited[k]:
            return gear * float(np.abs(model.actuator_forcerange[k]).min())
        plain = model.actuator_biastype[k] == mujoco.mjtBias.mjBIAS_NONE
        if plain and model.actuator_ctrllimited[k]:
            gain = abs(float(model.actuator_gainprm[k, 0]))
            return gear * gain * float(np.abs(model.actuator_ctrlrange[k]).min())
    return None
