"""The robot in MuJoCo as the world that servo torques move: the place of the mechanism behind an emulated servo bus."""

from collections.abc import Mapping

import mujoco
import numpy as np

from ros_free_stack.errors import InvalidOption
from ros_free_stack.messages import Mount, RobotTrajectory
from ros_free_stack.robot_model import joint_addresses, standing_qpos
from ros_free_stack.robots import RobotDescription
from sim.model import judging_model

_FPS = 50.0


class ServoWorld:
    """Call it with a time step (s) and the torque of each servo by id (N m); it returns their (rad, rad/s) by id.

    The torques are the servos' own, speed-torque line included, so the model's actuators and the damping that stands
    for that line are switched off. Somebody holds the robot in its standing pose until the first servo pulls.

    Attributes:
        model, data: of MuJoCo; the robot begins in its standing pose.
        started: whether a servo has pulled.
    """

    def __init__(self, robot: RobotDescription, *, mount: Mount = "free") -> None:
        """
        Raises:
            InvalidOption: not every joint of the robot has a servo.
        """
        if robot.servos is None or not set(robot.joint_names) <= robot.servos.ids.keys():
            raise InvalidOption("--robot", f"{robot.name} has no Dynamixel servo for every joint in its description")
        mount = robot.mounted(mount)
        self._robot, self.started = robot, False
        self._poses: list[np.ndarray] = []
        self.model = model = judging_model(robot, mount=mount)
        model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_ACTUATION
        positions, dofs = joint_addresses(model, robot)
        self.data = mujoco.MjData(model)
        if mount == "free":
            self.data.qpos[:] = standing_qpos(model, robot)
        else:
            self.data.qpos[positions] = robot.standing_pos
        model.dof_damping[dofs] = 0.0
        ids = [robot.servos.ids[name] for name in robot.joint_names]
        self._joints = list(zip(ids, positions.tolist(), dofs.tolist(), strict=True))
        mujoco.mj_forward(model, self.data)

    def __call__(self, dt: float, torques: Mapping[int, float]) -> dict[int, tuple[float, float]]:
        self.started = self.started or any(torques.values())
        if self.started:
            self.model.opt.timestep = dt
            for identity, _, dof in self._joints:
                self.data.qfrc_applied[dof] = torques[identity]
            mujoco.mj_step(self.model, self.data)
            self._record()
        position, velocity = self.data.qpos, self.data.qvel
        return {identity: (float(position[at]), float(velocity[dof])) for identity, at, dof in self._joints}

    def _record(self) -> None:
        if self.data.time >= len(self._poses) / _FPS:
            root = self.data.body(self._robot.root_body)
            angles = self.data.qpos[[at for _, at, _ in self._joints]]
            self._poses.append(np.concatenate([root.xpos, root.xquat, angles]))

    def trajectory(self) -> RobotTrajectory:
        """What the robot has done since it was let go, at 50 frames a second; feet and contacts are not judged.

        Raises:
            InvalidMessage: no servo has pulled yet.
        """
        poses = np.array(self._poses).reshape(-1, 7 + len(self._joints))
        return RobotTrajectory(
            robot=self._robot.name,
            model_sha256=self._robot.sha256,
            joint_names=self._robot.joint_names,
            fps=_FPS,
            root_pos=poses[:, :3],
            root_quat=poses[:, 3:7],
            joint_pos=poses[:, 7:],
            contacts=np.zeros((len(poses), len(self._robot.foot_names)), dtype=bool),
            foot_names=self._robot.foot_names,
        )
