"""Frame by frame Gauss-Newton sequential quadratic programming with hard joint limits and planted feet.

Each frame minimises |W r|^2 over increments d of the configuration, J r's Jacobian:
    min 1/2 d'(J'W^2 J + D) d + (J'W^2 r + ...)'d   with   low <= q + d <= high,   Jc d = -c,   z + Jz d >= 0,
                                                           Jl (s + d) >= l
where c are the pose errors of feet that stand, z the heights of the other feet's corners (soft), s the step that the
frame has made so far and l the least changes of the distances between limbs (soft). The quadratic programs are solved
by DAQP (Arnstrom, Bemporad and Axehill 2022, "A dual active-set solver for embedded quadratic programming using
recursive LDL' updates").
"""

from dataclasses import dataclass
from time import perf_counter

import daqp
import mujoco
import numpy as np

from retarget.collision import Approach, Collision
from retarget.compiled import BufferedFunction, compiled
from retarget.geometry import RobotGeometry
from retarget.limits import JointBounds
from retarget.problem import frame_problem
from retarget.targets import Targets
from ros_free_stack.messages import Bools, Floats

ITERATIONS = 3
FIRST_ITERATIONS = 40
FIRST_STARTS = 6
TRUST = 0.3

POINT_WEIGHTS = {"pelvis": 6.0, "elbow": 2.0, "wrist": 3.0, "knee": 1.0}
"""Weights of position errors in units of the leg's length."""
ROTATION_WEIGHT = 4.0
SWING_WEIGHTS = (10.0, 3.0)
STANCE_WEIGHTS = (40.0, 10.0)
"""Weights of a foot's (position, rotation): in the air, and standing but not yet planted."""
COM_WEIGHT = 15.0
DAMPING = 2e-2
POSTURE, STANDING_POSTURE = 2e-2, 2.0
"""Pull of the joints toward the standing pose while following (it holds what no target moves and prefers the nearer of
two ways to place a hand) and while standing."""
STEP_CHANGE = 2e-2
"""Cost of a joint's change of step, against jitter; the free base, which has no limits, weighs its own tracking."""
ROOT_SHARE = 0.1

PLANTED_M, PLANTED_RAD = 0.004, 0.03
"""A standing foot within this of its foothold is planted: an equality from then on."""

_EQUALITY, _SOFT = 5, 8


@dataclass(frozen=True)
class Solution:
    """A solved clip.

    Attributes:
        qpos: (N, nq) configurations.
        point_error: (N, P) distances of the followed points to their targets, m.
        foot_error: (N, F) distances of the soles to their targets, m.
        centre_of_mass: (N, 3) m.
        released: (N, F) whether a standing foot could not be kept on its foothold.
        limited: (N, J) whether a joint was at one of its bounds.
    """

    qpos: Floats
    point_error: Floats
    foot_error: Floats
    centre_of_mass: Floats
    released: Bools
    limited: Bools


class FrameSolver:
    """Solves the frames of one robot one after the other; holds the compiled problem and its memory."""

    def __init__(self, geometry: RobotGeometry, *, machine_code: bool = True) -> None:
        """Build and compile the problem of `geometry`; `machine_code=False` stays in the CasADi virtual machine."""
        started = perf_counter()
        self.geometry = geometry
        function = frame_problem(geometry)
        self._function = BufferedFunction(compiled(function) if machine_code else function)
        self._collision = Collision(geometry)
        self.preparation_s = perf_counter() - started
        self._damping = np.full(geometry.model.nv, DAMPING)
        self._damping[:6] *= ROOT_SHARE
        self._smoothing = np.full(geometry.model.nv, STEP_CHANGE)
        leg = geometry.length("left_hip", "left_knee", "left_ankle")
        self._smoothing[:3] = (POINT_WEIGHTS["pelvis"] / leg) ** 2
        self._smoothing[3:6] = ROTATION_WEIGHT**2
        weights = [POINT_WEIGHTS[name.removeprefix("left_").removeprefix("right_")] for name in geometry.followed]
        self._per_leg = 1 / leg
        self._posture = POSTURE
        inputs = self._function.inputs
        inputs["point_weights"][:, 0] = np.array(weights) / leg
        inputs["rotation_weights"][:] = ROTATION_WEIGHT

    def solve(self, targets: Targets, com: Floats | None = None) -> Solution:
        """Solve a clip, from rest; `com` (N, 2) is a centre of mass to follow over the floor."""
        count, feet = targets.contacts.shape
        geometry = self.geometry
        bounds = JointBounds.of(geometry.robot, targets.fps)
        self._function.inputs["com_weight"][:] = 0.0 if com is None else COM_WEIGHT * self._per_leg
        qpos = self._first(targets, com, bounds)
        step = np.zeros(geometry.model.nv)
        planted = np.zeros(feet, dtype=bool)
        history = _History(count, geometry, feet)
        for k in range(count):
            self._aim(targets, k, com, planted)
            if k == 0:
                low, high = qpos[geometry.qpos_index], qpos[geometry.qpos_index]
            else:
                low, high = bounds.reach(qpos[geometry.qpos_index], step[geometry.dof_index])
            approach = self._collision.approach(qpos, 1 / targets.fps)
            qpos, step, kept = self._frame(qpos, step, low, high, planted & targets.contacts[k], approach)
            outputs = self._evaluate(qpos)
            errors = outputs["foot_error"].reshape(feet, 2, 3)
            distance = np.linalg.norm(errors[:, 0], axis=1)
            angle = np.linalg.norm(errors[:, 1], axis=1)
            near = (distance < PLANTED_M) & (angle < PLANTED_RAD)
            history.record(k, qpos, outputs, distance, low, high)
            history.released[k] = targets.contacts[k] & planted & ~(kept & near)
            planted = targets.contacts[k] & near
        return history.solution()

    def _first(self, targets: Targets, com: Floats | None, bounds: JointBounds) -> Floats:
        """The best of several starts for the first frame: the standing pose, and seeded draws around it."""
        geometry = self.geometry
        rng = np.random.default_rng(0)
        planted = np.zeros(len(geometry.feet), dtype=bool)
        self._aim(targets, 0, com, planted)
        best, lowest = geometry.standing, np.inf
        for start in range(FIRST_STARTS):
            qpos = geometry.standing.copy()
            qpos[:3] += targets.points[0, geometry.followed.index("pelvis")] - geometry.points["pelvis"]
            mujoco.mju_mat2Quat(qpos[3:7], (targets.rotations[0, 0] @ geometry.references["pelvis"].T).ravel())
            if start:
                spread = (bounds.upper - bounds.lower) / 4
                draw = qpos[geometry.qpos_index] + spread * rng.uniform(-1, 1, len(spread))
                qpos[geometry.qpos_index] = np.clip(draw, bounds.lower, bounds.upper)
            for _ in range(FIRST_ITERATIONS):
                approach = self._collision.approach(qpos, np.inf)
                rest = np.zeros_like(self._damping)
                increment = self._increment(qpos, rest, rest, bounds.lower, bounds.upper, planted, approach)[0]
                qpos = self._moved(qpos, increment, bounds.lower, bounds.upper)
                if np.abs(increment).max() < 1e-4:
                    break
            cost = self._evaluate(qpos)["cost"].item() + self._posture * self._posture_error(qpos) ** 2
            # Another branch must be clearly better than the one that the standing pose leads to.
            if cost < 0.98 * lowest:
                best, lowest = qpos, cost
        return best

    def _posture_error(self, qpos: Floats) -> float:
        index = self.geometry.qpos_index
        return float(np.linalg.norm(qpos[index] - self.geometry.standing[index]))

    def _aim(self, targets: Targets, k: int, com: Floats | None, planted: Bools) -> None:
        self._posture = POSTURE + (1 - targets.following[k]) * (STANDING_POSTURE - POSTURE)
        inputs = self._function.inputs
        inputs["points"][:] = targets.points[k].T
        inputs["rotations"][:] = targets.rotations[k].reshape(-1, 9).T
        inputs["soles"][:] = targets.soles[k].T
        inputs["sole_rotations"][:] = targets.sole_rotations[k].reshape(-1, 9).T
        stance = targets.contacts[k] & ~planted
        weights = np.where(stance[None], np.array(STANCE_WEIGHTS)[:, None], np.array(SWING_WEIGHTS)[:, None])
        inputs["sole_weights"][:] = weights * np.array([self._per_leg, 1.0])[:, None]
        if com is not None:
            inputs["com"][:, 0] = com[k]

    def _evaluate(self, qpos: Floats) -> dict[str, np.ndarray]:
        self._function.inputs["qpos"][:, 0] = qpos
        return self._function()

    def _frame(
        self, start: Floats, last_step: Floats, low: Floats, high: Floats, planted: Bools, approach: Approach
    ) -> tuple[Floats, Floats, Bools]:
        """One frame from the last configuration: (configuration, whole step (nv,), feet kept as equalities)."""
        qpos, step, kept = start, np.zeros_like(last_step), planted
        for _ in range(ITERATIONS):
            increment, solved = self._increment(qpos, step, last_step, low, high, kept, approach)
            if not solved:
                kept = np.zeros_like(kept)
                increment, _ = self._increment(qpos, step, last_step, low, high, kept, approach)
            qpos = self._moved(qpos, increment, low, high)
            step = step + increment
        step[self.geometry.dof_index] = (qpos - start)[self.geometry.qpos_index]
        return qpos, step, kept

    def _increment(
        self,
        qpos: Floats,
        step: Floats,
        last_step: Floats,
        low: Floats,
        high: Floats,
        planted: Bools,
        approach: Approach,
    ) -> tuple[Floats, bool]:
        """Solve one quadratic program: increment (nv,) after `step` (nv,), and whether its constraints can be kept."""
        geometry, nv = self.geometry, self.geometry.model.nv
        out = self._evaluate(qpos)
        dofs, joints = geometry.dof_index, qpos[geometry.qpos_index]
        hessian = out["hessian"] + np.diag(self._damping + self._smoothing)
        hessian[dofs, dofs] += self._posture
        gradient = out["gradient"][:, 0] + self._smoothing * (step - last_step)
        gradient[dofs] += self._posture * (joints - geometry.standing[geometry.qpos_index])

        equal, free = np.repeat(planted, 6), np.repeat(~planted, 4)
        rows = np.concatenate([out["foot_jacobian"][equal], out["height_jacobian"][free], approach.jacobian])
        limbs = len(approach.least)
        count, held = nv + len(rows), int(equal.sum())
        lower, upper = np.full(count, -TRUST), np.full(count, TRUST)
        lower[dofs], upper[dofs] = low - joints, high - joints
        lower[nv : nv + held] = upper[nv : nv + held] = -out["foot_error"][equal, 0]
        lower[nv + held : count - limbs], upper[nv + held :] = -out["height"][free, 0], 1e30
        lower[count - limbs :] = approach.least - approach.jacobian @ step
        sense = np.zeros(count, dtype=np.int32)
        sense[nv : nv + held], sense[nv + held :] = _EQUALITY, _SOFT
        increment, _, flag, _ = daqp.solve(
            np.ascontiguousarray(hessian), gradient, np.ascontiguousarray(rows), upper, lower, sense
        )
        return np.clip(increment, lower[:nv], upper[:nv]), flag > 0

    def _moved(self, qpos: Floats, increment: Floats, low: Floats, high: Floats) -> Floats:
        moved = qpos.copy()
        mujoco.mj_integratePos(self.geometry.model, moved, increment, 1.0)
        index = self.geometry.qpos_index
        moved[index] = np.clip(moved[index], low, high)
        return moved


class _History:
    """Arrays of a clip that is being solved."""

    def __init__(self, count: int, geometry: RobotGeometry, feet: int) -> None:
        self.qpos = np.zeros((count, geometry.model.nq))
        self.point_error = np.zeros((count, len(geometry.followed)))
        self.foot_error = np.zeros((count, feet))
        self.centre_of_mass = np.zeros((count, 3))
        self.released = np.zeros((count, feet), dtype=bool)
        self.limited = np.zeros((count, len(geometry.qpos_index)), dtype=bool)
        self._index = geometry.qpos_index

    def record(
        self,
        k: int,
        qpos: Floats,
        outputs: dict[str, np.ndarray],
        foot_error: Floats,
        low: Floats,
        high: Floats,
    ) -> None:
        self.qpos[k] = qpos
        self.point_error[k] = outputs["point_error"][:, 0]
        self.foot_error[k] = foot_error
        self.centre_of_mass[k] = outputs["centre_of_mass"][:, 0]
        joints = qpos[self._index]
        self.limited[k] = (k > 0) & ((joints <= low + 1e-9) | (joints >= high - 1e-9))

    def solution(self) -> Solution:
        return Solution(self.qpos, self.point_error, self.foot_error, self.centre_of_mass, self.released, self.limited)
