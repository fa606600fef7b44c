"""Controllers of a playback: what goals the servos get, from the plan and from where the robot is believed to be.

`pd` sends the reference's angles and nothing else: the baseline. `default` adds the servos' feedforward,
goal = q + (tau + kd v) / kp, and leans the ankles of standing feet against the error of the divergent component of
motion (DCM, Englsberger et al. 2015), xi = c + v / omega. `wbc` is in `sim.whole_body`.
"""

from typing import Protocol, get_args

import mujoco
import numpy as np

from ros_free_stack.errors import UnknownName
from ros_free_stack.messages import ControllerName, Floats
from ros_free_stack.robots import RobotDescription
from sim.actuation import Servos
from sim.plan import Plan

CONTROLLERS: tuple[ControllerName, ...] = get_args(ControllerName)

DCM_GAIN = 6.0
"""Shift of the centre of pressure over DCM error; above 1 the error shrinks."""

SOLE_SHARE = 4.0
"""Size of a sole, about its middle, to which the pressure may be asked to go. More than 1, since the robot gives way to
the moment and the servo's own spring takes a part of it back; without a limit the foot rolls over its edge."""


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
    """Feedforward, and ankles that move the centre of pressure against the DCM error.

    The pressure under a standing foot is to move by `DCM_GAIN` times the error, as far as its sole reaches; the ankle's
    servo gives the moment that this takes by a goal that lies moment / kp further.
    """

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription, servos: Servos, plan: Plan) -> None:
        self._model, self._plan, self._kp = model, plan, servos.kp
        self._goals = servos.goals(plan.joint_pos, plan.joint_vel, plan.torque)
        free = model.nv > len(robot.joints)
        self._ankles = [ankle_joints(model, robot, foot) for foot in robot.soles] if free else []
        self._bodies = [model.body(sole.body).id for sole in robot.soles.values()]
        corners = [np.array(sole.corners) for sole in robot.soles.values()]
        self._middles = [points.mean(axis=0) for points in corners]
        self._halves = [SOLE_SHARE * np.ptp(points, axis=0)[:2] / 2 for points in corners]
        self._gravity = -float(model.opt.gravity[2])
        self._weight = float(model.body_subtreemass[0]) * self._gravity

    def goals(self, now: int, then: int, believed: mujoco.MjData) -> Floats:
        """See `Controller`."""
        goals, plan = self._goals[then].copy(), self._plan
        standing = plan.standing[now]
        if not self._ankles or not standing.any():
            return goals
        mujoco.mj_subtreeVel(self._model, believed)
        height = max(float(plan.com[now, 2]), 0.05)
        omega = np.sqrt(self._gravity / height)
        drift = self._drift(now, believed)
        planned = plan.com[now, :2] + plan.com_vel[now, :2] / omega + drift
        error = believed.subtree_com[0, :2] + believed.subtree_linvel[0, :2] / omega - planned
        zmp = plan.com[now, :2] - plan.com_acc[now, :2] / omega**2 + drift
        load = self._weight / standing.sum()
        for foot in np.flatnonzero(standing):
            x, y = load * self._shift(int(foot), zmp, DCM_GAIN * error, believed)
            for place, joint in self._ankles[foot]:
                axis = believed.xaxis[joint]
                goals[place] += (axis[1] * x - axis[0] * y) / self._kp[place]
        return goals

    def _shift(self, foot: int, zmp: Floats, wanted: Floats, believed: mujoco.MjData) -> Floats:
        """(2,) m by which the pressure under a foot can move of what is wanted, over the floor."""
        body, middle, half = self._bodies[foot], self._middles[foot][:2], self._halves[foot]
        across = believed.xmat[body].reshape(3, 3)[:2, :2]
        now = _clamped((zmp - believed.xpos[body, :2]) @ across - middle, half)
        return across @ (_clamped(now + wanted @ across, half) - now)

    def _drift(self, now: int, believed: mujoco.MjData) -> Floats:
        """(2,) how far the standing feet are from where they were planned: the plan moves with them."""
        drifts = [
            (believed.xpos[body] + believed.xmat[body].reshape(3, 3) @ middle - planned)[:2]
            for body, middle, planned, stands in zip(
                self._bodies, self._middles, self._plan.feet[now], self._plan.standing[now], strict=True
            )
            if stands
        ]
        return sum(drifts, np.zeros(2)) / len(drifts)


def _clamped(values: Floats, bound: Floats) -> Floats:
    return np.minimum(np.maximum(values, -bound), bound)


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
