"""Footholds where feet were put down: the plan moved to what the robot could reach."""

from dataclasses import replace

import mujoco
import numpy as np

from retarget.body.geometry import RobotGeometry
from retarget.clip.human import yaw_rotation
from retarget.clip.runs import runs
from retarget.plan.footsteps import carried
from retarget.plan.targets import Targets
from ros_free_stack.messages import Bools, Floats


def latch(geometry: RobotGeometry, targets: Targets, qpos: Floats) -> Targets:
    """Targets whose stances are where a trajectory (N, nq) has its standing feet, flat on the floor as before.

    A foothold that a joint's limit or a limb in the way keeps from being reached would otherwise be striven for, and
    the rest of the body bent, as long as the foot stands. Swings are moved along, smoothly.
    """
    soles, rotations = targets.soles.copy(), targets.sole_rotations.copy()
    places, turns = _feet(geometry, qpos)
    for i in range(len(geometry.feet)):
        away = turns[:, i] @ np.swapaxes(rotations[:, i], 1, 2)
        yaw = np.arctan2(away[:, 1, 0] - away[:, 0, 1], away[:, 0, 0] + away[:, 1, 1])
        contact = targets.contacts[:, i]
        moves = carried(_held(np.column_stack([(places - soles)[:, i, :2], yaw]), contact), contact)
        soles[:, i, :2] += moves[:, :2]
        rotations[:, i] = yaw_rotation(moves[:, 2]) @ rotations[:, i]
    return replace(targets, soles=soles, sole_rotations=rotations)


def _feet(geometry: RobotGeometry, qpos: Floats) -> tuple[Floats, Floats]:
    """(N, F, 3) places of the soles' centres and (N, F, 3, 3) orientations of the feet."""
    data, feet = mujoco.MjData(geometry.model), geometry.feet
    places, turns = np.zeros((len(qpos), len(feet), 3)), np.zeros((len(qpos), len(feet), 3, 3))
    for k, configuration in enumerate(qpos):
        data.qpos[:] = configuration
        mujoco.mj_kinematics(geometry.model, data)
        for i, foot in enumerate(feet):
            turns[k, i] = data.xmat[foot.body].reshape(3, 3)
            places[k, i] = data.xpos[foot.body] + turns[k, i] @ foot.centre
    return places, turns


def _held(moves: Floats, contact: Bools) -> Floats:
    """(N, D) the median of `moves` (N, D) in each stance."""
    held = moves.copy()
    for start, end in runs(contact):
        held[start:end] = np.median(moves[start:end], axis=0)
    return held
