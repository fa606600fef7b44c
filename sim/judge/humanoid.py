"""A robot's pose on the human skeleton, so that measures defined on human bodies apply to it.

Only the directions of the robot's segments are used, laid on human proportions: a robot with short legs is not
incoherent for having them. Joints that a robot lacks (spine, neck, head, collars, toes) follow from those it has.
"""

from collections.abc import Callable
from typing import Final

import numpy as np

from ros_free_stack.messages import Floats
from ros_free_stack.skeleton import INDEX, JOINT_COUNT
from sim.reference import Reference

SIDES: Final = ("left", "right")

# Bone lengths in leg lengths: medians over 179 captured takes of the CMU database.
_THIGH: Final = 0.449
_SHANK: Final = 0.552
_UPPER_ARM: Final = 0.343
_FOREARM: Final = 0.288
_FOOT: Final = 0.155
_HIP: Final = 0.152
_SPINE: Final = (("spine1", 0.157), ("spine2", 0.228), ("spine3", 0.299), ("neck", 0.57), ("head", 0.677))
_SHOULDER: Final = (0.40, 0.19)
"""Height of a shoulder above the pelvis along the trunk, and its distance from the trunk."""
_COLLAR: Final = (0.39, 0.07)


def human_joints(reference: Reference) -> Floats:
    """(T, 22, 3) the robot's motion on a human skeleton with legs of unit length."""
    robot = reference.attachments
    joints = np.zeros((len(reference.qpos), JOINT_COUNT, 3))
    hips = (robot["left_hip"] + robot["right_hip"]) / 2
    shoulders = (robot["left_shoulder"] + robot["right_shoulder"]) / 2
    trunk = _unit(shoulders - hips)
    leg = _leg_length(robot)
    joints[:, INDEX["pelvis"]] = pelvis = hips / leg
    for name, height in _SPINE:
        joints[:, INDEX[name]] = pelvis + height * trunk
    for side in SIDES:
        hip_line = _unit(robot[f"{side}_hip"] - hips)
        shoulder_line = _unit(robot[f"{side}_shoulder"] - shoulders)
        put = _placer(joints, side)
        put("collar", pelvis + _COLLAR[0] * trunk + _COLLAR[1] * shoulder_line)
        shoulder = put("shoulder", pelvis + _SHOULDER[0] * trunk + _SHOULDER[1] * shoulder_line)
        elbow = put("elbow", shoulder + _UPPER_ARM * _direction(robot, side, "shoulder", "elbow"))
        put("wrist", elbow + _FOREARM * _direction(robot, side, "elbow", "wrist"))
        hip = put("hip", pelvis + _HIP * hip_line)
        knee = put("knee", hip + _THIGH * _direction(robot, side, "hip", "knee"))
        ankle = put("ankle", knee + _SHANK * _direction(robot, side, "knee", "ankle"))
        put("foot", ankle + _FOOT * _sole_direction(reference, side))
    return joints


def _placer(joints: Floats, side: str) -> Callable[[str, Floats], Floats]:
    """A function that writes one of the side's joints and returns its position."""

    def put(name: str, position: Floats) -> Floats:
        joints[:, INDEX[f"{side}_{name}"]] = position
        return position

    return put


def _leg_length(robot: dict[str, Floats]) -> float:
    thigh = np.linalg.norm(robot["left_hip"] - robot["left_knee"], axis=1)
    shank = np.linalg.norm(robot["left_knee"] - robot["left_ankle"], axis=1)
    return float(np.median(thigh + shank))


def _direction(robot: dict[str, Floats], side: str, start: str, end: str) -> Floats:
    return _unit(robot[f"{side}_{end}"] - robot[f"{side}_{start}"])


def _sole_direction(reference: Reference, side: str) -> Floats:
    """From the ankle to the front of the sole."""
    for foot, sole in reference.robot.soles.items():
        if sole.ankle == f"{side}_ankle":
            front = np.argsort([corner[0] for corner in sole.corners])[-2:]
            return _unit(reference.soles[foot][:, front].mean(axis=1) - reference.attachments[f"{side}_ankle"])
    return np.zeros((len(reference.qpos), 3))


def _unit(vectors: Floats) -> Floats:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-9)
