"""Controllers of a playback: what goals the servos get, from the plan and from where the robot is believed to be.

`pd` sends the reference's angles and nothing else: the baseline. `default` adds the servos' feedforward,
goal = q + (tau + kd v) / kp, and moves the pressure under the standing feet against the error of the divergent
component of motion (DCM, Englsberger et al. 2015), xi = c + v / omega. `wbc` is in `sim.whole_body`.
"""

from typing import Protocol, get_args

import mujoco
import numpy as np
from scipy.optimize import nnls

from ros_free_stack.errors import UnknownName
from ros_free_stack.messages import ControllerName, Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription
from sim.actuation import Servos
from sim.footholds import Footholds
from sim.plan import Plan

CONTROLLERS: tuple[ControllerName, ...] = get_args(ControllerName)

DCM_GAIN = 6.0
"""Shift of the centre of pressure over DCM error; above 1 the error shrinks."""

SOLE_SHARE = 2.0
"""Size of a sole, about its middle, to which the pressure may be asked to go. More than 1, since the robot gives way to
the moment and the servo's own spring takes a part of it back; without a limit the foot rolls over its edge."""

EVENNESS = 0.003
"""Weight of even loads, beside that of the pressure's place in m, where many shares of the weight put it there."""

LEAST_HEIGHT_M = 0.05
"""Of a centre of mass, so that a robot that lies on the floor divides by no zero."""


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
        return DcmFeedback(model, robot, servos, plan)
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


class DcmFeedback:
    """Feedforward, and forces on the floor that move the centre of pressure against the DCM error.

    The pressure is to move by `DCM_GAIN` times the error, as far as the standing soles reach. Each of their corners
    presses along its line to the centre of mass, as a pendulum on it would, with a share of the weight that puts the
    pressure there. What that asks of the joints beyond the plan, -J' df, goes to the servos as goals that lie
    torque / kp further: on one foot it is the ankle's moment, on two the legs also take load from each other. Feet that
    have landed beside their footholds take the plan along (`sim.footholds`).
    """

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription, servos: Servos, plan: Plan) -> None:
        self._model, self._plan, self._kp = model, plan, servos.kp
        self._goals = servos.goals(plan.joint_pos, plan.joint_vel, plan.torque)
        self._free = model.nv > len(robot.joints)
        _, self._dofs = joint_addresses(model, robot)
        self._bodies = [model.body(sole.body).id for sole in robot.soles.values()]
        self._corners = [_resized(np.array(sole.corners), SOLE_SHARE) for sole in robot.soles.values()]
        self._footholds = Footholds(model, robot, plan)
        self._gravity = -float(model.opt.gravity[2])
        self._weight = float(model.body_subtreemass[0]) * self._gravity

    def goals(self, now: int, then: int, believed: mujoco.MjData) -> Floats:
        """See `Controller`."""
        goals, plan = self._goals[then], self._plan
        standing = np.flatnonzero(plan.standing[now])
        if not self._free or not len(standing):
            return goals
        mujoco.mj_subtreeVel(self._model, believed)
        omega = np.sqrt(self._gravity / max(float(plan.com[now, 2]), LEAST_HEIGHT_M))
        drift = self._footholds.drift(now, believed)
        planned = plan.com[now, :2] + plan.com_vel[now, :2] / omega + drift
        error = believed.subtree_com[0, :2] + believed.subtree_linvel[0, :2] / omega - planned
        zmp = plan.com[now, :2] - plan.com_acc[now, :2] / omega**2 + drift
        torque = self._torque(standing, zmp, zmp + DCM_GAIN * error, believed)
        return goals + torque / self._kp + self._footholds.joints(now, believed)

    def _torque(self, standing: np.ndarray, planned: Floats, wanted: Floats, believed: mujoco.MjData) -> Floats:
        """(J,) N m that the joints give beyond the plan to press at `wanted` (2,) m and not at `planned`."""
        points = np.concatenate([self._on_floor(int(foot), believed) for foot in standing])
        com = believed.subtree_com[0]
        shares = corner_loads(points, wanted) - corner_loads(points, planned)
        forces = self._weight * shares[:, None] * (com - points) / max(float(com[2]), LEAST_HEIGHT_M)
        torque, moving, turning = np.zeros(self._model.nv), *np.zeros((2, 3, self._model.nv))
        ends = np.cumsum([len(self._corners[foot]) for foot in standing])[:-1]
        for foot, at, force in zip(standing, np.split(points, ends), np.split(forces, ends), strict=True):
            body = self._bodies[foot]
            mujoco.mj_jac(self._model, believed, moving, turning, believed.xpos[body], body)
            moment = np.cross(at - believed.xpos[body], force).sum(axis=0)
            torque -= moving.T @ force.sum(axis=0) + turning.T @ moment
        return torque[self._dofs]

    def _on_floor(self, foot: int, believed: mujoco.MjData) -> Floats:
        """(4, 3) m, the corners within which the pressure under a foot may be asked to go."""
        body = self._bodies[foot]
        return believed.xpos[body] + self._corners[foot] @ believed.xmat[body].reshape(3, 3).T


def _resized(points: Floats, share: float) -> Floats:
    """(n, 3) points moved from their middle to `share` times their distance from it."""
    middle = points.mean(axis=0)
    return middle + share * (points - middle)


def corner_loads(corners: Floats, pressure: Floats) -> Floats:
    """(C,) shares of the weight on corners that put the centre of pressure at a point, or as near to it as they reach.

    Of all such shares, none below 0, the most even ones (least squares).

    Args:
        corners: (C, 3) m.
        pressure: (2,) m.
    """
    count = len(corners)
    rows = np.vstack([np.ones(count), (corners[:, :2] - pressure).T, EVENNESS * np.eye(count)])
    return nnls(rows, np.concatenate([[1.0], np.zeros(2 + count)]))[0]
