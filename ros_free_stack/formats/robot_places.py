"""Where a robot's bodies and soles are in each frame of a trajectory."""

import mujoco
import numpy as np

from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import joint_addresses, sole_corners
from ros_free_stack.robots import RobotDescription


def configurations(
    model: mujoco.MjModel, robot: RobotDescription, root_pos: Floats, root_quat: Floats, joint_pos: Floats
) -> Floats:
    """(T, nq) MuJoCo configurations; joints that follow others are put where they belong."""
    addresses, _ = joint_addresses(model, robot)
    root = int(model.jnt_qposadr[model.body_jntadr[model.body(robot.root_body).id]])
    couplings = joint_couplings(model)
    qpos = np.tile(model.qpos0, (len(joint_pos), 1))
    qpos[:, root : root + 7] = np.concatenate([root_pos, root_quat], axis=1)
    qpos[:, addresses] = joint_pos
    for row in qpos:
        settle(model, couplings, row)
    return qpos


def body_places(model: mujoco.MjModel, robot: RobotDescription, qpos: Floats) -> tuple[Floats, Floats]:
    """(T, B, 3) places of the bodies, the root first, and (T, F, 4, 3) of the soles' corners."""
    data = mujoco.MjData(model)
    root = int(model.body(robot.root_body).id)
    order = [root, *(body for body in range(1, model.nbody) if body != root)]
    bodies, corners = np.zeros((len(qpos), len(order), 3)), np.zeros((len(qpos), len(robot.soles), 4, 3))
    for frame, row in enumerate(qpos):
        data.qpos[:] = row
        mujoco.mj_kinematics(model, data)
        bodies[frame] = data.xpos[order]
        for foot, points in enumerate(sole_corners(model, data, robot).values()):
            corners[frame, foot] = points
    return bodies, corners
