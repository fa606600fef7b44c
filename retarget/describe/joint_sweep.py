"""Joint ranges that the geometry allows, for models that state none: turn each joint until its limb hits the robot.

Touching another limb does not bound a joint (the other limb can be moved away; the self-collision check of the
whole pose is there for that), touching its own limb or the trunk does.
"""

from collections.abc import Sequence

import mujoco
import numpy as np

from ros_free_stack.messages import Floats

Pairs = frozenset[tuple[int, int]]


def limb_of_bodies(model: mujoco.MjModel, root: int) -> tuple[int, ...]:
    """For each body its ancestor just below the body `root`, or `root` itself for the trunk and the world."""
    limbs: list[int] = []
    for body in range(model.nbody):
        parent = int(model.body_parentid[body])
        limbs.append(root if body in (0, root) else body if parent == root else limbs[parent])
    return tuple(limbs)


def sweep_joint_ranges(
    model: mujoco.MjModel,
    joints: Sequence[int],
    root: int,
    starts: Sequence[Floats],
    *,
    step: float = 0.01,
    tolerance_m: float = 1e-3,
    margin: float = 0.03,
) -> Floats:
    """(J, 2) free range in rad or m of each joint: the widest of the sweeps from each start.

    A sweep ends at the first overlap deeper than `tolerance_m` that the start did not have, less `margin`, or at half a
    turn.

    Args:
        model: compiled with meshes.
        joints: J ids of hinges and slides.
        root: id of the body that all limbs hang from.
        starts: configurations (nq,).
        step: of a sweep, rad or m.
        tolerance_m: depth of an overlap that counts.
        margin: kept from the overlap, rad or m.
    """
    sweeps = [_sweep(model, joints, root, start, step, tolerance_m, margin) for start in starts]
    return np.column_stack([np.min(sweeps, axis=0)[:, 0], np.max(sweeps, axis=0)[:, 1]])


def _sweep(
    model: mujoco.MjModel,
    joints: Sequence[int],
    root: int,
    start: Floats,
    step: float,
    tolerance_m: float,
    margin: float,
) -> Floats:
    data = mujoco.MjData(model)
    limbs = limb_of_bodies(model, root)

    def overlaps(qpos: Floats) -> Pairs:
        data.qpos[:] = qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        deep = data.contact.dist[: data.ncon] < -tolerance_m
        pairs = model.geom_bodyid[data.contact.geom[: data.ncon][deep]].tolist()
        return frozenset((a, b) for a, b in pairs if a and b and (limbs[a] == limbs[b] or root in (limbs[a], limbs[b])))

    known = overlaps(start)
    ranges = np.zeros((len(joints), 2))
    for j, joint in enumerate(joints):
        address = model.jnt_qposadr[joint]
        for side, direction in enumerate((-1.0, 1.0)):
            qpos = start.copy()
            while abs(qpos[address] + direction * step) <= np.pi:
                qpos[address] += direction * step
                if overlaps(qpos) - known:
                    qpos[address] -= direction * (step + margin)
                    break
            ranges[j, side] = qpos[address]
    return ranges
