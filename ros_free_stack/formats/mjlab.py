"""Reference motions of mjlab and BeyondMimic (Liao et al., 2025): `.npz` with positions and velocities of every body.

fps (1,); joint_pos, joint_vel (T, J); body_pos_w (T, B, 3), body_quat_w (T, B, 4) wxyz, body_lin_vel_w and
body_ang_vel_w (T, B, 3), all of the bodies' frames in the world; B are the model's bodies in its order, without the
world. Velocities of joints and root are central differences, those of bodies follow from them through the model.
"""

from pathlib import Path

import mujoco
import numpy as np

from ros_free_stack.errors import InvalidFile, ModelMismatch
from ros_free_stack.files import atomic_path
from ros_free_stack.formats.robot_places import configurations
from ros_free_stack.messages import Floats, RobotTrajectory
from ros_free_stack.robot_model import joint_addresses, kinematic_model
from ros_free_stack.robots import load_robot


def write(path: Path, trajectory: RobotTrajectory) -> tuple[str, ...]:
    """Write a trajectory with all velocities.

    Raises:
        InvalidFile: it has a single frame, which has no velocity.
        ModelMismatch: it was made for another model of the robot.
        UnknownName: its robot is not described here.
    """
    arrays = motion_arrays(path, trajectory)
    with atomic_path(path) as temporary, temporary.open("wb") as stream:
        np.savez(stream, fps=np.array([trajectory.fps]), **arrays)  # pyright: ignore[reportArgumentType]
    return ()


def motion_arrays(path: Path, trajectory: RobotTrajectory) -> dict[str, Floats]:
    """The arrays of the file by name, float32 as training code keeps them."""
    robot = load_robot(trajectory.robot)
    if trajectory.model_sha256 != robot.sha256 or trajectory.joint_names != robot.joint_names:
        raise ModelMismatch(f"the trajectory was made for another model of {robot.name} than the one described here")
    if len(trajectory.joint_pos) < 2:
        raise InvalidFile(path, "a trajectory of one frame has no velocities")
    model = kinematic_model(robot)
    qpos = configurations(model, robot, trajectory.root_pos, trajectory.root_quat, trajectory.joint_pos)
    qvel = _velocities(model, qpos, trajectory.fps)
    data = mujoco.MjData(model)
    bodies = np.empty((len(qpos), model.nbody - 1, 13))
    for frame in range(len(qpos)):
        data.qpos[:], data.qvel[:] = qpos[frame], qvel[frame]
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        # cvel is seen from the centre of mass of the whole tree; move it to the body's own frame
        angular, arm = data.cvel[1:, :3], data.xpos[1:] - data.subtree_com[model.body_rootid[1:]]
        linear = data.cvel[1:, 3:] + np.cross(angular, arm)
        bodies[frame] = np.concatenate([data.xpos[1:], data.xquat[1:], linear, angular], axis=1)
    _, columns = joint_addresses(model, robot)
    arrays = {
        "joint_pos": trajectory.joint_pos,
        "joint_vel": qvel[:, columns],
        "body_pos_w": bodies[..., :3],
        "body_quat_w": bodies[..., 3:7],
        "body_lin_vel_w": bodies[..., 7:10],
        "body_ang_vel_w": bodies[..., 10:],
    }
    return {name: values.astype(np.float32) for name, values in arrays.items()}  # pyright: ignore[reportReturnType]


def _velocities(model: mujoco.MjModel, qpos: Floats, fps: float) -> Floats:
    """(T, nv) central differences of configurations, one-sided at the ends."""
    qvel = np.empty((len(qpos), model.nv))
    for frame, row in enumerate(qvel):
        before, after = max(frame - 1, 0), min(frame + 1, len(qpos) - 1)
        mujoco.mj_differentiatePos(model, row, (after - before) / fps, qpos[before], qpos[after])
    return qvel
