"""Controllers of a playback: what goals the servos get, from the plan and from where the robot is believed to be.

`pd` sends the reference's angles and nothing else: the baseline. `default` adds the servos' feedforward,
goal = q + (tau + kd v) / kp, and leans the ankles of standing feet against the error of the divergent component of
motion (DCM, Englsberger et al. 2015), xi = c + v / omega. `wbc` is in `sim.whole_body`.
"""

from typing import Literal, Protocol, get_args

import mujoco
import numpy as np

from ros_free_stack.errors import UnknownName
from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription
from sim.actuation import Servos
from sim.plan import Plan

ControllerName = Literal["pd", "default", "wbc"]
CONTROLLERS: tuple[ControllerName, ...] = get_args(ControllerName)

DCM_GAIN = 1.2
"""Ankle offset in rad over DCM error per height of the centre of mass."""


class Controller(Protocol):
    """Goals for the servos, cycle by cycle."""

    def goals(self, now: int, then: int, believed: mujoco.MjData) -> Floats:
        """(J,) goals in rad for the plan's cycle `then`, from the state believed at its cycle `now`.

        `believed` holds the state with its kinematics (`mj_fwdPosition`, `mj_fwdVelocity`).
        """
        ...


def make_controller(
    name: ControllerName, model: mujoco.MjModel, robot: RobotDescription, servos: Servos, plan: Plan
) -> Controller:
    """The controller of that name.

    Args:
        name: one of `CONTROLLERS`.
        model: what the controller takes the robot to be.
        robot: its description.
        servos: its servos.
        plan: the reference.

    Raises:
        UnknownName: no such controller.
    """
    if name == "pd":
        return PlainPD(plan)
    if name == "default":
        return AnkleDCM(model, robot, servos, plan)
    if name == "wbc":
        from sim.whole_body import WholeBody

        return WholeBody(model, robot, servos, plan)
    raise UnknownName("controller", name, CONTROLLERS)


class PlainPD:
    """The reference's angles as they are."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan

    def goals(self, now: int, then: int, believed: mujoco.MjData) -> Floats:
        """See `Controller`."""
        del now, believed
        return self._plan.joint_pos[then]


class AnkleDCM:
    """Feedforward, and ankles that lean against the DCM error."""

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription, servos: Servos, plan: Plan) -> None:
        self._model, self._plan = model, plan
        self._goals = servos.goals(plan.joint_pos, plan.joint_vel, plan.torque)
        self._ankles = (
            [ankle_joints(model, robot, foot) for foot in robot.soles] if model.nv > len(plan.torque[0]) else []
        )
        self._bodies = [model.body(sole.body).id for sole in robot.soles.values()]
        self._middles = [np.mean(sole.corners, axis=0) for sole in robot.soles.values()]

    def goals(self, now: int, then: int, believed: mujoco.MjData) -> Floats:
        """See `Controller`."""
        goals = self._goals[then].copy()
        plan = self._plan
        if not self._ankles or not plan.standing[now].any():
            return goals
        mujoco.mj_subtreeVel(self._model, believed)
        height = max(float(plan.com[now, 2]), 0.05)
        omega = np.sqrt(-self._model.opt.gravity[2] / height)
        planned = plan.com[now, :2] + plan.com_vel[now, :2] / omega
        found = believed.subtree_com[0, :2] + believed.subtree_linvel[0, :2] / omega
        error = found - planned - self._drift(now, believed)
        for standing, joints in zip(plan.standing[now], self._ankles, strict=True):
            if standing:
                for place, joint in joints:
                    axis = believed.xaxis[joint]
                    goals[place] += DCM_GAIN / height * (axis[1] * error[0] - axis[0] * error[1])
        return goals

    def _drift(self, now: int, believed: mujoco.MjData) -> Floats:
        """(2,) how far the standing feet are from where they were planned: the plan moves with them."""
        drifts = [
            (believed.xpos[body] + believed.xmat[body].reshape(3, 3) @ middle - planned)[:2]
            for body, middle, planned, stands in zip(
                self._bodies, self._middles, self._plan.feet[now], self._plan.standing[now], strict=True
            )
            if stands
        ]
        return np.mean(drifts, axis=0)


def ankle_joints(model: mujoco.MjModel, robot: RobotDescription, foot: str) -> list[tuple[int, int]]:
    """(place in the description, joint id) of the hinges between a foot and its shank."""
    sole = robot.soles[foot]
    knee = robot.attachments.get(sole.ankle.replace("ankle", "knee"))
    shank = model.body(knee.body).id if knee else -1
    body, links = model.body(sole.body).id, set[int]()
    while body not in (0, shank) and len(links) < 2:
        links.add(body)
        body = int(model.body_parentid[body])
    joints = [(place, model.joint(name).id) for place, name in enumerate(robot.joint_names)]
    return [(place, joint) for place, joint in joints if int(model.jnt_bodyid[joint]) in links]
