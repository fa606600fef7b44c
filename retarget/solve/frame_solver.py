"""Frame by frame Gauss-Newton sequential quadratic programming with hard joint limits and planted feet.

Each frame solves a few of the quadratic programs of `retarget.solve.frame_problem`, each at the step that the last one
led to. Bounds of the joints' and the root's steps are hard and never contradict each other (`retarget.solve.limits`).
What may ask for more than they allow is soft, by weights so large that it is kept wherever it can be: the pose of feet
that stand, the heights of the other feet's corners, the distances between limbs.
"""

from time import perf_counter

import mujoco
import numpy as np

from retarget.body.collision import Collision
from retarget.body.compiled import BufferedFunction, compiled
from retarget.body.geometry import RobotGeometry
from retarget.plan.targets import Goal, Targets
from retarget.solve.frame_problem import COM_WEIGHT, NEAREST, POSE, UNBOUNDED, frame_functions
from retarget.solve.frame_program import EQUALITY, SOFT, FrameProgram
from retarget.solve.limits import JointBounds
from retarget.solve.solution import History, Solution, at_limit
from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.errors import SolverFailed
from ros_free_stack.messages import Bools, Floats

ITERATIONS = 3
FIRST_ITERATIONS = 40
FIRST_STARTS = 6
CLEARLY_BETTER = 0.7
"""Cost over the lowest so far at which another start is preferred: from a rest none of the others would be reached."""
APPROACH_STEPS = 12
"""Steps from the standing pose to the first frame's."""
TRUST, AT_ONCE = 0.3, 1e3
"""Largest increment of one iteration for the first frame, m and rad, and its change: nothing brakes there."""
CONVERGED, FOLLOWED = 1e-3, 1e-2
"""Norms of the increment, m and rad, after which the first frame, and a later one, need no further iteration: what an
increment leaves is of second order."""

POSTURE, STANDING_POSTURE = 2e-2, 2.0
"""Pull of the joints toward the standing pose while following (it holds what no target moves and prefers the nearer of
two ways to place a hand) and while standing."""

PLANTED_M, PLANTED_RAD = 0.004, 0.03
"""A standing foot within this of its foothold is planted: held there from then on."""
SETTLED_S = 0.1
"""A standing foot that has not reached its foothold by then is planted where it is, if it lies on the floor."""

FOOT_SOFTNESS, FLOOR_SOFTNESS, LIMB_SOFTNESS = 1e-7, 1e-6, 3e-6
"""Share of a violation that DAQP leaves, in each kind of soft rows."""


class FrameSolver:
    """Solves the frames of one robot one after the other; holds the compiled problem, its memory and the last frame.

    Attributes:
        qpos: (nq,) the last configuration.
        planted: (F,) the feet that it holds.
        released: (F,) standing feet that it could not keep where they were planted.
        last: (nv,) the last step.
        collision: the distances between its limbs.
        program: the quadratic program; it counts those without a solution, where the step stays as it was, inside its
            bounds.
        bounds: (nv,) and (nv,) least and largest last step; the next one overwrites them.
    """

    def __init__(self, geometry: RobotGeometry, *, machine_code: bool = True) -> None:
        """Build and compile the problem of `geometry`; `machine_code=False` stays in the CasADi virtual machine."""
        started = perf_counter()
        self.geometry = geometry
        functions = frame_functions(geometry)
        self._frame, self._state = (
            BufferedFunction(compiled(function) if machine_code else function)
            for function in (functions.program, functions.state)
        )
        self.collision = Collision(geometry, machine_code=machine_code)
        self._couplings = joint_couplings(geometry.model)
        bodies = [geometry.model.body(foot.body).name for foot in geometry.feet]
        self._soles = {
            pair: [bodies.index(name) for name in names]
            for pair, names in enumerate(geometry.robot.collision_pairs)
            if all(name in bodies for name in names)
        }
        feet, nv = len(geometry.feet), geometry.model.nv
        # DAQP's rows: those that the function writes, then those of the limbs.
        self._rows = np.zeros((POSE * feet + NEAREST, nv))
        self._frame.write_to("rows", self._rows[: POSE * feet])
        self._frame.read_from("apart_rows", self._rows[POSE * feet :])
        for name, memory in self._frame.inputs.items():
            self._state.read_from(name, memory.T)
        outputs = self._frame.outputs
        bounds = (outputs["upper"][:, 0], outputs["lower"][:, 0])
        data = (outputs["hessian"].T, outputs["gradient"][:, 0], self._rows, *bounds)
        self.program = FrameProgram(data, LIMB_SOFTNESS)
        self._start, self._step, self._last, self._apart = (
            self._frame.inputs[name][:, 0] for name in ("start", "step", "last", "apart")
        )
        self._apart_rows = self._rows[POSE * feet :]
        aimed = ("points", "rotations", "soles", "sole_rotations")
        self._aimed = [self._frame.inputs[name].T for name in aimed]
        self.bounds = outputs["low"][:, 0], outputs["high"][:, 0]
        self.qpos = geometry.standing
        self.planted, self.released = np.zeros(feet, dtype=bool), np.zeros(feet, dtype=bool)
        self.last = np.zeros(nv)
        self._stood = [0] * feet
        self._fps: float | None = None
        self.preparation_s = perf_counter() - started

    def solve(self, targets: Targets, com: Floats | None = None) -> Solution:
        """Solve a clip, from rest; `com` (N, 2) is a centre of mass to follow over the floor."""
        history = History(len(targets), self.geometry)
        for k in range(len(targets)):
            goal = targets.goal(k, com)
            outputs = self.step(goal, targets.fps) if k else self.start(goal)
            history.record(k, self, outputs)
        return history.solution(targets)

    def start(self, goal: Goal) -> dict[str, np.ndarray]:
        """Forget what was, find the first configuration from several starts, and rest there.

        Returns:
            What `retarget.solve.frame_problem.FrameFunctions.state` tells of the configuration; the next call
            overwrites them.

        Raises:
            SolverFailed: no program of any start had a solution.
        """
        self.last[:], self._fps = 0.0, None
        self.program.forget()
        self._hold(np.zeros_like(self.planted))
        self._aim(goal)
        self.qpos = self._first(goal)
        if not self.program.solved:
            raise SolverFailed("the first frame's pose", f"DAQP {self.program.status}")
        self._begin()
        return self._end(goal)

    def step(self, goal: Goal, fps: float) -> dict[str, np.ndarray]:
        """Go on to the next frame, 1 / `fps` s after the last one; returns what `start` does."""
        if fps != self._fps:
            self.last *= (self._fps or fps) / fps
            self._frame.inputs["limits"][:], self._fps = JointBounds.tangent(self.geometry, fps).table, fps
        if (self.planted & ~goal.contacts).any():
            self._hold(self.planted & goal.contacts)
        self._aim(goal)
        self._begin()
        self._keep_apart(1 / fps)
        # The last step is a guess of this one.
        step, (low, high) = self._step, self.bounds
        step[:] = self.last
        for _ in range(ITERATIONS):
            increment = self._increment()
            step += increment
            # Several times faster than `numpy.clip` on few numbers.
            np.minimum(np.maximum(step, low, out=step), high, out=step)
            if increment @ increment < FOLLOWED**2:
                break
        return self._end(goal)

    @property
    def limited(self) -> Bools:
        """(J,) joints at a limit of range, speed or acceleration in the last frame."""
        dofs, (low, high) = self.geometry.dof_index, self.bounds
        if self._fps is None:
            return np.zeros(len(dofs), dtype=bool)
        return at_limit(low[dofs], self.last[dofs], high[dofs])

    def _first(self, goal: Goal) -> Floats:
        """The best of several starts for the first frame: approached from the standing pose, and seeded draws."""
        geometry, inputs = self.geometry, self._frame.inputs
        index, robot = geometry.qpos_index, geometry.robot
        bounds = JointBounds.tangent(geometry, 1.0)
        free = np.where(bounds.step > 0, 1.0, 0.0)
        inputs["limits"][:] = JointBounds(bounds.lower, bounds.upper, TRUST * free, AT_ONCE * free).table
        rng = np.random.default_rng(0)
        best, lowest = self._approached(goal), np.inf
        for start in range(FIRST_STARTS):
            self.qpos = best if start == 0 else self._placed(goal)
            if start:
                draw = self.qpos[index] + (robot.upper - robot.lower) / 4 * rng.uniform(-1, 1, len(index))
                self.qpos[index] = np.clip(draw, robot.lower, robot.upper)
            self._settle(FIRST_ITERATIONS)
            away = self.qpos[index] - geometry.standing[index]
            cost = self._state.outputs["cost"].item() + inputs["posture"].item() * float(away @ away)
            if cost < CLEARLY_BETTER * lowest:
                best, lowest = self.qpos, cost
        settle(geometry.model, self._couplings, best)
        return best

    def _approached(self, goal: Goal) -> Floats:
        """The configuration to which the points lead that move from the standing pose's to the goal's.

        A robot that has followed the person from a rest is in this branch, wherever a clip is cut.
        """
        self.qpos = self._placed(goal)
        points = self._frame.inputs["points"].T
        root = goal.points[self.geometry.followed.index("pelvis")]
        turn = goal.rotations[0] @ self.geometry.references["pelvis"].T
        own = np.stack([self.geometry.points[name] for name in self.geometry.followed])
        own = root + (own - self.geometry.points["pelvis"]) @ turn.T
        for share in np.linspace(0, 1, APPROACH_STEPS + 1)[1:]:
            points[:] = own + share * (goal.points - own)
            self._settle(ITERATIONS)
        return self.qpos

    def _settle(self, iterations: int) -> None:
        """Iterate from the last configuration, with no limits but range, until it stays."""
        for _ in range(iterations):
            self._begin()
            self._keep_apart(np.inf)
            step = self._increment()
            self._step[:] = np.clip(step, *self.bounds)
            self.qpos = self._state()["qpos"][:, 0].copy()
            if step @ step < CONVERGED**2:
                break

    def _placed(self, goal: Goal) -> Floats:
        """The standing pose with the root where the goal wants the pelvis."""
        geometry, qpos = self.geometry, self.geometry.standing.copy()
        if not geometry.held:
            turn = goal.rotations[0] @ geometry.references["pelvis"].T
            pelvis = geometry.points["pelvis"]
            qpos[:3] = goal.points[geometry.followed.index("pelvis")] + turn @ (qpos[:3] - pelvis)
            mujoco.mju_mat2Quat(qpos[3:7], turn.ravel())
        return qpos

    def _aim(self, goal: Goal) -> None:
        inputs = self._frame.inputs
        points, rotations, soles, sole_rotations = self._aimed
        points[:], soles[:] = goal.points, goal.soles
        rotations[:], sole_rotations[:] = goal.rotations.reshape(-1, 9), goal.sole_rotations.reshape(-1, 9)
        inputs["contact"][:, 0] = goal.contacts
        inputs["posture"][:] = POSTURE + (1 - goal.following) * (STANDING_POSTURE - POSTURE)
        inputs["com_weight"][:] = 0.0
        if goal.com is not None:
            inputs["com_weight"][:] = COM_WEIGHT / self.geometry.limb_length
            inputs["com"][:, 0] = goal.com

    def _hold(self, planted: Bools) -> None:
        """Hold these feet (F,) from now on, at their anchors."""
        self.planted = planted
        self._frame.inputs["held"][:, 0] = planted
        sense = np.where(planted, SOFT + EQUALITY, SOFT)
        softness = np.where(planted, FOOT_SOFTNESS, FLOOR_SOFTNESS)
        self.program.mark(0, np.repeat(sense, POSE), np.repeat(softness, POSE))

    def _begin(self) -> None:
        """Begin a frame at the last configuration."""
        self._start[:], self._step[:], self._last[:] = self.qpos, 0.0, self.last

    def _keep_apart(self, frame_s: float) -> None:
        """Limbs apart, but for feet that stand too near each other: rows that contradict the footholds would pull at
        everything else, with forces beyond what a Gauss-Newton step may leave out."""
        free = [pair for pair, feet in self._soles.items() if self.planted[feet].all()]
        approach = self.collision.approach(self.qpos, frame_s, NEAREST, self.last, free)
        count = len(approach.least)
        self._apart_rows[:count], self._apart[:count] = approach.jacobian, approach.least
        self._apart[count:] = -UNBOUNDED

    def _end(self, goal: Goal) -> dict[str, np.ndarray]:
        """Keep the configuration after the step, and decide which feet the next frame holds."""
        outputs = self._state()
        self.last = self._step.copy()
        self.qpos = outputs["qpos"][:, 0].copy()
        settle(self.geometry.model, self._couplings, self.qpos)
        planted, released = [], []
        for i, (distance, angle, height, upright) in enumerate(outputs["feet"].T.tolist()):
            stands, near = bool(goal.contacts[i]), distance < PLANTED_M and angle < PLANTED_RAD
            self._stood[i] = self._stood[i] + 1 if stands else 0
            released.append(bool(self.planted[i]) and not near)
            if stands and not self.planted[i]:
                lies = height < PLANTED_M and upright > np.cos(PLANTED_RAD)
                # The first frame is solved to its end: what keeps its feet from their footholds would do so later, too.
                waited = self._fps is None or (not near and self._stood[i] >= SETTLED_S * self._fps)
                settled = lies and waited
                place = np.concatenate([goal.soles[i], goal.sole_rotations[i].ravel()])
                self._frame.inputs["anchors"][:, i] = outputs["sole"][:, i] if settled else place
                near = near or settled
            planted.append(stands and near)
        self.released = np.array(released, dtype=bool)
        if planted != self.planted.tolist():
            self._hold(np.array(planted, dtype=bool))
        return outputs

    def _increment(self) -> Floats:
        """Solve one quadratic program: increment (nv,) of the step."""
        self._frame()
        return self.program.solve()
