"""Whole-body control: every few milliseconds one QP over accelerations and floor forces, through the position servos.

    min  sum w |J a + Jdot v - a_wanted|^2 + r |f|^2
    s.t. M a + c - passive = S' tau + Jc' G f,  f >= 0,  |tau| <= effort

with tasks for the centre of mass, the torso's orientation, the soles (still where they stand, following the plan where
they swing) and the joints; G f are forces at the soles' corners inside friction pyramids (Herzog et al. 2016, "Momentum
control with hierarchical inverse dynamics on a torque-controlled humanoid", here with weights in place of a hierarchy).
The torques become goals of the servos by their own law.
"""

import ctypes
from dataclasses import dataclass

import daqp
import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription
from sim.playback.actuation import Servos
from sim.playback.plan import Plan

PERIOD_S = 0.008
"""Time between two solutions, at least a cycle; servos hold the torque in between."""

FRICTION = 0.5
SOLE_SHARE = 0.8
"""Size of the soles, about their middles, that carry the planned forces."""

EFFORT_SHARE = 0.95
_EQUALITY = 5
_EDGES = np.array([[FRICTION, 0, 1], [-FRICTION, 0, 1], [0, FRICTION, 1], [0, -FRICTION, 1.0]])


@dataclass(frozen=True)
class Gains:
    """Weight of a task, and stiffness (1/s^2) and damping (1/s) of its wanted acceleration."""

    weight: float
    stiffness: float
    damping: float


COM = Gains(30.0, 40.0, 12.0)
TORSO = Gains(2.0, 150.0, 25.0)
STANDING = Gains(50.0, 0.0, 20.0)
SWING = Gains(20.0, 300.0, 35.0)
JOINTS = Gains(0.05, 100.0, 20.0)
ROOT_WEIGHT, FORCE_WEIGHT = 1e-4, 1e-2
STANDING_TILT = 100.0
"""Stiffness in 1/s^2 with which a standing sole is kept level."""


class WholeBody:
    """See the module; `goals` follows `sim.playback.controllers.Controller`."""

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription, servos: Servos, plan: Plan) -> None:
        self._model, self._robot, self._servos, self._plan = model, robot, servos, plan
        self._positions, self._dofs = joint_addresses(model, robot)
        self._weight = float(model.body_subtreemass[0])
        self._torso = model.body(robot.torso_body).id
        self._feet = [model.body(sole.body).id for sole in robot.soles.values()]
        self._corners = [np.array(sole.corners) for sole in robot.soles.values()]
        self._every = max(1, round(PERIOD_S / plan.cycle_s))
        self._free = model.nv > len(robot.joints)
        self._ideal = mujoco.MjData(model)
        self._torque: Floats | None = None
        self.unsolved = 0

    def goals(self, now: int, then: int, believed: mujoco.MjData) -> Floats:
        """(J,) goals in rad; where the QP has no solution the plan's torques stand in."""
        if not self._free:
            return self._servos.goals(self._plan.joint_pos[then], self._plan.joint_vel[then], self._plan.torque[then])
        if self._torque is None or now % self._every == 0:
            self._torque = self._solve(now, believed)
        angles, speeds = believed.qpos[self._positions], believed.qvel[self._dofs]
        ahead = angles + (then - now) * self._plan.cycle_s * speeds
        return self._servos.goals(ahead, speeds, self._torque)

    def _solve(self, cycle: int, data: mujoco.MjData) -> Floats:
        """(J,) torques in N m."""
        model, plan = self._model, self._plan
        inertia, bias = self._dynamics(data)
        ideal = self._ideal
        ideal.qpos[:], ideal.qvel[:] = plan.qpos[cycle], plan.qvel[cycle]
        mujoco.mj_kinematics(model, ideal)
        mujoco.mj_comPos(model, ideal)
        problem = _LeastSquares(model.nv)
        standing = plan.standing[cycle]
        offset = self._offset(data, ideal, standing)
        self._follow_com(problem, cycle, data, inertia, bias, offset)
        self._follow_torso(problem, data, ideal)
        jacobians = [
            self._follow_foot(problem, foot, bool(standing[foot]), data, ideal, cycle, offset)
            for foot in range(len(self._feet))
        ]
        self._follow_joints(problem, cycle, data)
        forces = np.concatenate([np.zeros((0, model.nv)), *(item for item in jacobians if item is not None)])
        return self._torques(problem, inertia, bias - data.qfrc_passive, forces)

    def _dynamics(self, data: mujoco.MjData) -> tuple[Floats, Floats]:
        model = self._model
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_makeM(model, data)
        mujoco.mj_fullM(model, data, inertia)
        mujoco.mj_passive(model, data)
        bias = np.zeros(model.nv)
        mujoco.mj_rne(model, data, 0, bias)
        return inertia, bias

    def _offset(self, data: mujoco.MjData, ideal: mujoco.MjData, standing: np.ndarray) -> Floats:
        """(3,) how far the standing feet are from where they were planned, over the floor: the plan moves with them."""
        drifts = [
            data.xpos[body] - ideal.xpos[body] for body, stands in zip(self._feet, standing, strict=True) if stands
        ]
        return np.mean(drifts, axis=0) * (1, 1, 0) if drifts else np.zeros(3)

    def _follow_com(
        self, problem: "_LeastSquares", cycle: int, data: mujoco.MjData, inertia: Floats, bias: Floats, offset: Floats
    ) -> None:
        """The free root's three forces are those on the whole: M a + c = m (a_com - g)."""
        plan, mass = self._plan, self._weight
        mujoco.mj_subtreeVel(self._model, data)
        wanted = (
            plan.com_acc[cycle]
            + COM.stiffness * (plan.com[cycle] + offset - data.subtree_com[0])
            + COM.damping * (plan.com_vel[cycle] - data.subtree_linvel[0])
        )
        problem.add(inertia[:3] / mass, wanted - bias[:3] / mass - self._model.opt.gravity, COM.weight)

    def _follow_torso(self, problem: "_LeastSquares", data: mujoco.MjData, ideal: mujoco.MjData) -> None:
        _, turning, rate = self._motion(data, self._torso, data.xpos[self._torso])
        wanted_rate = turning @ ideal.qvel
        error = _rotation(ideal.xmat[self._torso], data.xmat[self._torso])
        wanted = TORSO.stiffness * error + TORSO.damping * (wanted_rate - turning @ data.qvel)
        problem.add(turning, wanted - rate[3:], TORSO.weight)

    def _follow_foot(
        self,
        problem: "_LeastSquares",
        foot: int,
        standing: bool,
        data: mujoco.MjData,
        ideal: mujoco.MjData,
        cycle: int,
        offset: Floats,
    ) -> Floats | None:
        """Add a foot's task; (16, nv) generalised forces of its pyramids' edges, N per N, where it stands."""
        body, corners = self._feet[foot], self._corners[foot]
        middle = corners.mean(axis=0)
        rotation = data.xmat[body].reshape(3, 3)
        point = data.xpos[body] + rotation @ middle
        moving, turning, drift = self._motion(data, body, point)
        jacobian = np.concatenate([moving, turning])
        speed = jacobian @ data.qvel
        tilt = _rotation(ideal.xmat[body], data.xmat[body])
        if standing:
            level = np.concatenate([np.zeros(3), STANDING_TILT * tilt * (1, 1, 0)])
            problem.add(jacobian, level - STANDING.damping * speed - drift, STANDING.weight)
            edges = []
            for corner in middle + SOLE_SHARE * (corners - middle):
                at_corner = np.zeros((3, self._model.nv))
                mujoco.mj_jac(self._model, data, at_corner, None, data.xpos[body] + rotation @ corner, body)
                edges.append(_EDGES @ at_corner)
            return np.concatenate(edges)
        error = np.concatenate([self._plan.feet[cycle, foot] + offset - point, tilt])
        wanted = SWING.stiffness * error + SWING.damping * (jacobian @ self._plan.qvel[cycle] - speed)
        wanted += jacobian @ self._plan.qacc[cycle]
        problem.add(jacobian, wanted - drift, SWING.weight)
        return None

    def _follow_joints(self, problem: "_LeastSquares", cycle: int, data: mujoco.MjData) -> None:
        plan, dofs = self._plan, self._dofs
        wanted = (
            plan.qacc[cycle, dofs]
            + JOINTS.stiffness * (plan.joint_pos[cycle] - data.qpos[self._positions])
            + JOINTS.damping * (plan.joint_vel[cycle] - data.qvel[dofs])
        )
        problem.hessian[dofs, dofs] += JOINTS.weight
        problem.gradient[dofs] -= JOINTS.weight * wanted
        problem.hessian[range(6), range(6)] += ROOT_WEIGHT

    def _motion(self, data: mujoco.MjData, body: int, point: Floats) -> tuple[Floats, Floats, Floats]:
        """Jacobians (3, nv) of a point's position and of its body's rotation, and (6,) their drift Jdot v."""
        model = self._model
        moving, turning, moving_rate, turning_rate = (np.zeros((3, model.nv)) for _ in range(4))
        mujoco.mj_jac(model, data, moving, turning, point, body)
        mujoco.mj_jacDot(model, data, moving_rate, turning_rate, point, body)
        return moving, turning, np.concatenate([moving_rate @ data.qvel, turning_rate @ data.qvel])

    def _torques(self, problem: "_LeastSquares", inertia: Floats, bias: Floats, forces: Floats) -> Floats:
        """Solve for accelerations and forces, (in units of the robot's weight), and read the torques off."""
        nv, dofs = self._model.nv, self._dofs
        unit = self._weight * 9.81
        count = len(forces)
        hessian = np.zeros((nv + count, nv + count))
        hessian[:nv, :nv] = problem.hessian
        hessian[range(nv, nv + count), range(nv, nv + count)] = FORCE_WEIGHT
        gradient = np.concatenate([problem.gradient, np.zeros(count)])
        dynamics = np.concatenate([inertia, -unit * forces.T], axis=1)
        rows = np.concatenate([np.arange(6), dofs])
        effort = EFFORT_SHARE * self._robot.effort
        # daqp takes the first bounds for those of the variables themselves; accelerations have none.
        free = np.full(nv, 1e30)
        upper = np.concatenate([free, np.full(count, 10.0), -bias[:6], effort - bias[dofs]])
        lower = np.concatenate([-free, np.zeros(count), -bias[:6], -effort - bias[dofs]])
        sense = np.zeros(len(upper), dtype=ctypes.c_int)
        sense[nv + count : nv + count + 6] = _EQUALITY
        found, _, flag, _ = daqp.solve(hessian, gradient, np.ascontiguousarray(dynamics[rows]), upper, lower, sense)
        if flag < 1 or not np.isfinite(found.sum()):
            self.unsolved += 1
            return np.clip((bias - forces.sum(axis=0) * unit / max(count, 1))[dofs], -effort, effort)
        return (dynamics @ found + bias)[dofs]


class _LeastSquares:
    """The quadratic form of sums of |J a - b|^2."""

    def __init__(self, size: int) -> None:
        self.hessian, self.gradient = np.zeros((size, size)), np.zeros(size)

    def add(self, jacobian: Floats, wanted: Floats, weight: float) -> None:
        self.hessian += weight * jacobian.T @ jacobian
        self.gradient -= weight * jacobian.T @ wanted


def _rotation(wanted: Floats, actual: Floats) -> Floats:
    """(3,) rotation vector in the world from the actual to the wanted orientation."""
    return Rotation.from_matrix(wanted.reshape(3, 3) @ actual.reshape(3, 3).T).as_rotvec()
