"""Controllers of a playback: what goals the servos get, from the plan and from where the robot is believed to be.

`pd` sends the reference's angles and nothing else: the baseline. `default` adds the servos' feedforward,
goal = q + (tau + kd v) / kp, and moves the pressure under the standing feet against the error of the divergent
component of motion (DCM, Englsberger et al. 2015), xi = c + v / omega. `wbc` is in `sim.playback.whole_body`.
"""

from typing import Final, Protocol, get_args

import mujoco
import numpy as np

from ros_free_stack.errors import UnknownName
from ros_free_stack.messages import ControllerName, Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription
from sim.playback.actuation import Servos
from sim.playback.footholds import Footholds
from sim.playback.linear import damped_shares
from sim.playback.plan import Plan

CONTROLLERS: tuple[ControllerName, ...] = get_args(ControllerName)

DCM_GAIN = 6.0
"""Shift of the centre of pressure over DCM error; above 1 the error shrinks."""

SOLE_SHARE = 2.0
"""Size of a sole, about its middle, to which the pressure may be asked to go. More than 1, since the robot gives way to
the moment and the servo's own spring takes a part of it back; without a limit the foot rolls over its edge."""

EVENNESS = 0.003
"""Weight of even loads, beside that of the pressure's place in m, where many shares of the weight put it there."""

_WHOLE: Final = np.array([1.0, 0.0, 0.0])
"""Sum of the shares, and their moment about the pressure."""

LEAST_HEIGHT_M = 0.05
"""Of a centre of mass, so that a robot that lies on the floor divides by no zero."""


class Controller(Protocol):
    """Goals for the servos, cycle by cycle; `unsolved` counts those for which its own program had no solution."""

    unsolved: int

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
        from sim.playback.whole_body import WholeBody

        return WholeBody(model, robot, servos, plan)
    raise UnknownName("controller", name, CONTROLLERS)


class PlainPD:
    """The reference's angles as they are."""

    unsolved = 0

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
    have landed beside their footholds take the plan along (`sim.playback.footholds`).
    """

    unsolved = 0

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription, servos: Servos, plan: Plan) -> None:
        self._model, self._kp = model, servos.kp
        self._goals = servos.goals(plan.joint_pos, plan.joint_vel, plan.torque)
        self._free = model.nv > len(robot.joints)
        _, self._dofs = joint_addresses(model, robot)
        soles = robot.soles.values()
        self._bodies = np.array([model.body(sole.body).id for sole in soles], dtype=int)
        self._corners = np.array([_resized(np.array(sole.corners), SOLE_SHARE) for sole in soles])
        self._footholds = Footholds(model, robot, plan)
        gravity = -float(model.opt.gravity[2])
        self._weight = float(model.body_subtreemass[0]) * gravity
        self._standing = plan.standing
        self._omega = np.sqrt(gravity / np.maximum(plan.com[:, 2:], LEAST_HEIGHT_M))
        self._dcm = plan.com[:, :2] + plan.com_vel[:, :2] / self._omega
        self._zmp = plan.com[:, :2] - plan.com_acc[:, :2] / self._omega**2

    def goals(self, now: int, then: int, believed: mujoco.MjData) -> Floats:
        """See `Controller`."""
        goals, standing = self._goals[then], np.flatnonzero(self._standing[now])
        if not self._free or not len(standing):
            return goals
        mujoco.mj_subtreeVel(self._model, believed)
        drift, added = self._footholds.follow(now, believed)
        dcm = believed.subtree_com[0, :2] + believed.subtree_linvel[0, :2] / self._omega[now]
        error, zmp = dcm - self._dcm[now] - drift, self._zmp[now] + drift
        torque = self._torque(standing, zmp, zmp + DCM_GAIN * error, believed)
        return goals + torque / self._kp + added

    def _torque(self, standing: np.ndarray, planned: Floats, wanted: Floats, believed: mujoco.MjData) -> Floats:
        """(J,) N m that the joints give beyond the plan to press at `wanted` (2,) m and not at `planned`."""
        bodies, com = self._bodies[standing], believed.subtree_com[0]
        feet, rotations = believed.xpos[bodies], believed.xmat[bodies].reshape(-1, 3, 3)
        arms = self._corners[standing] @ rotations.transpose(0, 2, 1)
        corners = (feet[:, None] + arms).reshape(-1, 3)
        shares = corner_loads(corners, wanted) - corner_loads(corners, planned)
        loads = (self._weight / max(float(com[2]), LEAST_HEIGHT_M) * shares).reshape(*arms.shape[:2], 1)
        # A corner's force is load (com - corner); about the foot, its moment is load arm x (com - foot).
        reach, place = com - feet, (loads * arms).sum(axis=1)
        forces, moment, floor = loads.sum(axis=1) * reach - place, np.zeros(3), np.zeros(self._model.nv)
        for foot, body in enumerate(bodies.tolist()):
            mujoco.mju_cross(moment, place[foot], reach[foot])
            mujoco.mj_applyFT(self._model, believed, forces[foot], moment, feet[foot], body, floor)
        return -floor[self._dofs]


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
    rows = np.ones((3, len(corners)))
    rows[1:] = (corners[:, :2] - pressure).T
    return damped_shares(rows, _WHOLE, EVENNESS)
