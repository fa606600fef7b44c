"""Where a trajectory puts the robot's bodies: the kinematics that every check reads, computed once."""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from ros_free_stack.errors import ModelMismatch
from ros_free_stack.messages import Floats, RobotTrajectory
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription


@dataclass(frozen=True)
class Reference:
    """A trajectory as poses of the judging model, with the contacts that MuJoCo finds in them.

    Attributes:
        robot: the description.
        trajectory: what is judged; joints in the description's order.
        model: the judging model with a free base.
        qpos: (T, nq) poses.
        body_pos: (T, B, 3) m, world.
        body_rot: (T, B, 3, 3) world from body.
        floor_depth: (T, G) how far each geom is below the floor, m; 0 where it is not.
        pair_depth: per frame, overlapping pairs of bodies and their depth in m.
    """

    robot: RobotDescription
    trajectory: RobotTrajectory
    model: mujoco.MjModel
    qpos: Floats
    body_pos: Floats
    body_rot: Floats
    floor_depth: Floats
    pair_depth: tuple[dict[tuple[str, str], float], ...]

    @property
    def dt(self) -> float:
        return 1.0 / self.trajectory.fps

    @cached_property
    def soles(self) -> dict[str, Floats]:
        """(T, 4, 3) corners of each sole, m, world."""
        return {foot: self.points(sole.body, sole.corners) for foot, sole in self.robot.soles.items()}

    @cached_property
    def attachments(self) -> dict[str, Floats]:
        """(T, 3) the robot point that plays each human joint, m, world."""
        return {joint: self.points(item.body, (item.offset,))[:, 0] for joint, item in self.robot.attachments.items()}

    def points(self, body: str, offsets: tuple[tuple[float, float, float], ...]) -> Floats:
        """(T, n, 3) world positions of points given in a body's frame."""
        return body_points(self.model, self.body_pos, self.body_rot, body, offsets)


def body_points(
    model: mujoco.MjModel,
    body_pos: Floats,
    body_rot: Floats,
    body: str,
    offsets: tuple[tuple[float, float, float], ...],
) -> Floats:
    """(T, n, 3) world positions of points in a body's frame, from body positions (T, B, 3) and rotations."""
    index = model.body(body).id
    return body_pos[:, None, index] + np.einsum("tij,nj->tni", body_rot[:, index], np.array(offsets))


def check_belongs(trajectory: RobotTrajectory, robot: RobotDescription) -> None:
    """ModelMismatch unless the trajectory was made for exactly this robot model."""
    if trajectory.model_sha256 != robot.sha256:
        raise ModelMismatch(
            f"the trajectory was made for {trajectory.robot} model {trajectory.model_sha256[:12]}, "
            f"this is {robot.name} model {robot.sha256[:12]}: retarget the motion again"
        )
    if set(trajectory.joint_names) != set(robot.joint_names):
        odd = sorted(set(trajectory.joint_names) ^ set(robot.joint_names))
        raise ModelMismatch(f"joints of trajectory and {robot.name} differ: {', '.join(odd)}")
    if set(trajectory.foot_names) != set(robot.foot_names):
        raise ModelMismatch(
            f"trajectory has feet {', '.join(trajectory.foot_names)}, {robot.name} has {', '.join(robot.foot_names)}"
        )


def in_robot_order(trajectory: RobotTrajectory, robot: RobotDescription) -> RobotTrajectory:
    """The same trajectory with joints and feet in the description's order."""
    if (trajectory.joint_names, trajectory.foot_names) == (robot.joint_names, robot.foot_names):
        return trajectory
    joints = [trajectory.joint_names.index(name) for name in robot.joint_names]
    feet = [trajectory.foot_names.index(name) for name in robot.foot_names]
    return RobotTrajectory(
        robot=trajectory.robot,
        model_sha256=trajectory.model_sha256,
        joint_names=robot.joint_names,
        fps=trajectory.fps,
        root_pos=trajectory.root_pos,
        root_quat=trajectory.root_quat,
        joint_pos=trajectory.joint_pos[:, joints],
        contacts=trajectory.contacts[:, feet],
        foot_names=robot.foot_names,
    )


def poses(trajectory: RobotTrajectory, robot: RobotDescription, model: mujoco.MjModel) -> Floats:
    """(T, nq) `qpos` of a model with a free base."""
    addresses, _ = joint_addresses(model, robot)
    qpos = np.tile(model.qpos0, (len(trajectory.joint_pos), 1))
    qpos[:, 0:3], qpos[:, 3:7] = trajectory.root_pos, trajectory.root_quat
    qpos[:, addresses] = trajectory.joint_pos
    return qpos


def make_reference(trajectory: RobotTrajectory, robot: RobotDescription, model: mujoco.MjModel) -> Reference:
    """Pose the model at every frame; ModelMismatch where trajectory and robot do not belong together."""
    check_belongs(trajectory, robot)
    trajectory = in_robot_order(trajectory, robot)
    qpos = poses(trajectory, robot, model)
    frames = len(qpos)
    body_pos = np.empty((frames, model.nbody, 3))
    body_rot = np.empty((frames, model.nbody, 3, 3))
    floor_depth = np.zeros((frames, model.ngeom))
    pairs: list[dict[tuple[str, str], float]] = []
    data = mujoco.MjData(model)
    floor = model.geom("floor").id
    for frame in range(frames):
        data.qpos[:] = qpos[frame]
        mujoco.mj_fwdPosition(model, data)
        body_pos[frame] = data.xpos
        body_rot[frame] = data.xmat.reshape(-1, 3, 3)
        pairs.append(_depths(model, data, floor, floor_depth[frame]))
    return Reference(robot, trajectory, model, qpos, body_pos, body_rot, floor_depth, tuple(pairs))


def _depths(
    model: mujoco.MjModel, data: mujoco.MjData, floor: int, floor_depth: Floats
) -> dict[tuple[str, str], float]:
    """Fill in each geom's depth below the floor and return the depth of each overlapping pair of bodies."""
    pairs: dict[tuple[str, str], float] = {}
    for (first, second), distance in zip(data.contact.geom, data.contact.dist, strict=True):
        if floor in (first, second):
            geom = second if first == floor else first
            floor_depth[geom] = max(floor_depth[geom], -distance)
        elif distance < 0:
            names = sorted(model.body(model.geom_bodyid[geom]).name for geom in (first, second))
            pair = (names[0], names[1])
            pairs[pair] = max(pairs.get(pair, 0.0), -float(distance))
    return pairs
