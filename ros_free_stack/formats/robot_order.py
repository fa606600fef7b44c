"""In which order a file without names has a robot's joints: depth first (MuJoCo) or breadth first (PhysX, Isaac)."""

from typing import Final

import mujoco
import numpy as np

from ros_free_stack.formats.robot_places import configurations
from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import kinematic_model
from ros_free_stack.robots import RobotDescription

CLOSE_M: Final = 0.02
"""Bodies this close to where the file has them are where the joints put them."""
_FRAMES: Final = 20


def breadth_first(
    robot: RobotDescription, root_pos: Floats, root_quat: Floats, joints: Floats, bodies: Floats
) -> list[int] | None:
    """Where each of the robot's joints stands in a breadth-first file; None where the file's bodies do not show it.

    Args:
        robot: the robot.
        root_pos: (T, 3) m.
        root_quat: (T, 4) wxyz.
        joints: (T, J) as the file has them.
        bodies: (T, B, 3) places of the bodies in the order of the joints.
    """
    model = kinematic_model(robot)
    if bodies.shape[1] != model.nbody - 1 or not len(bodies):
        return None
    depth = [0] * model.nbody
    for body in range(1, model.nbody):
        depth[body] = depth[int(model.body_parentid[body])] + 1
    body_order = sorted(range(1, model.nbody), key=lambda body: (depth[body], body))
    of_joint = [int(model.joint(name).bodyid[0]) for name in robot.joint_names]
    file_order = sorted(range(len(of_joint)), key=lambda joint: body_order.index(of_joint[joint]))
    places = [file_order.index(joint) for joint in range(len(of_joint))]
    rows = np.linspace(0, len(bodies) - 1, min(len(bodies), _FRAMES)).astype(int)
    data = mujoco.MjData(model)
    errors = {"depth": 0.0, "breadth": 0.0}
    for kind, order, columns in (
        ("depth", list(range(1, model.nbody)), list(range(len(places)))),
        ("breadth", body_order, places),
    ):
        qpos = configurations(model, robot, root_pos[rows], root_quat[rows], joints[rows][:, columns])
        for row, frame in zip(qpos, rows, strict=True):
            data.qpos[:] = row
            mujoco.mj_kinematics(model, data)
            errors[kind] += float(np.linalg.norm(data.xpos[order] - bodies[frame], axis=1).max()) / len(rows)
    return places if errors["breadth"] < CLOSE_M < errors["depth"] else None
