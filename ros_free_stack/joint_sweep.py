"""Joint ranges that the geometry allows, for models that state none: turn each joint until its limb hits the robot.

Touching another limb does not bound a joint (the other limb can be moved away; the self-collision check of the
whole pose is there for that), touching its own limb or the trunk does.
"""

import mujoco
import numpy as np

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import joint_addresses, robot_spec, standing_qpos
from ros_free_stack.robots import RobotDescription

Pairs = frozenset[tuple[int, int]]


def limb_of_bodies(model: mujoco.MjModel, root_body: str) -> tuple[int, ...]:
    """For each body its ancestor just below the root body, or the root itself for the trunk and the world."""
    root = model.body(root_body).id
    limbs: list[int] = []
    for body in range(model.nbody):
        parent = int(model.body_parentid[body])
        limbs.append(root if body in (0, root) else body if parent == root else limbs[parent])
    return tuple(limbs)


def sweep_joint_ranges(
    robot: RobotDescription, *, step_rad: float = 0.01, tolerance_m: float = 1e-3, margin_rad: float = 0.03
) -> Floats:
    """(J, 2) free range in rad of each joint: the wider of the sweeps from the standing pose and from all zeros.

    A sweep ends at the first overlap deeper than `tolerance_m` that the start did not have, less `margin_rad`, or at
    half a turn.
    """
    model = robot_spec(robot).compile()
    addresses, _ = joint_addresses(model, robot)
    standing = standing_qpos(model, robot)
    zeros = standing.copy()
    zeros[addresses] = 0.0
    sweeps = [_sweep(model, robot, start, addresses, step_rad, tolerance_m, margin_rad) for start in (standing, zeros)]
    low, high = np.min(sweeps, axis=0)[:, 0], np.max(sweeps, axis=0)[:, 1]
    return np.column_stack([low, high])


def _sweep(
    model: mujoco.MjModel,
    robot: RobotDescription,
    start: Floats,
    addresses: np.ndarray,
    step_rad: float,
    tolerance_m: float,
    margin_rad: float,
) -> Floats:
    data = mujoco.MjData(model)
    limbs = limb_of_bodies(model, robot.root_body)
    root = model.body(robot.root_body).id

    def overlaps(qpos: Floats) -> Pairs:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        deep = data.contact.dist[: data.ncon] < -tolerance_m
        pairs = model.geom_bodyid[data.contact.geom[: data.ncon][deep]].tolist()
        return frozenset((a, b) for a, b in pairs if a and b and (limbs[a] == limbs[b] or root in (limbs[a], limbs[b])))

    known = overlaps(start)
    ranges = np.zeros((len(addresses), 2))
    for j, address in enumerate(addresses):
        for side, direction in enumerate((-1.0, 1.0)):
            qpos = start.copy()
            while abs(qpos[address] + direction * step_rad) <= np.pi:
                qpos[address] += direction * step_rad
                if overlaps(qpos) - known:
                    qpos[address] -= direction * (step_rad + margin_rad)
                    break
            ranges[j, side] = qpos[address]
    return ranges
