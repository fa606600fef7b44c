"""A whole clip at once: Gauss-Newton on the trajectory, inside hard limits of every joint.

The trajectory minimises the frames' least-squares costs and its own acceleration (`clip_problem.py`). Each step is one
quadratic program (`trajectory_qp.py`) and a backtracking search (`filter.py`; Nocedal and Wright 2006, "Numerical
optimization", chapters 15 and 18). It starts from the frame solver's trajectory. That keeps every joint's limits, these
are linear in the joints, and so every later trajectory keeps them too, wherever the iteration ends.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from retarget.body.collision import Collision
from retarget.body.geometry import RobotGeometry
from retarget.plan.targets import Targets
from retarget.solve.clip_problem import ClipModel, ClipProblem, Point
from retarget.solve.differences import Stretch, moved
from retarget.solve.effort import Effort
from retarget.solve.filter import LESS, Filter
from retarget.solve.frame_solver import PLANTED_M, PLANTED_RAD
from retarget.solve.limits import active_limits
from retarget.solve.solution import Solution
from retarget.solve.trajectory_qp import TrajectoryQP
from retarget.solve.windows import LENGTH, windows
from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.messages import Floats

DRAFT, ITERATIONS, MOST = 1, 4, 10
"""Iterations of a draft, after which what violates nothing is good enough, and after which the search ends."""
TRUST, MOST_TRUST = 0.3, 0.6
"""Largest increment of the first iteration, and of any later one, m and rad."""
LESS_TRUST, LEAST_TRUST = 0.25, 0.05
"""Share of the trust that is left after a step that the filter refused, and the trust below which the search ends."""
FULL = 0.99
"""Share of the trust from which an increment is held back by it: the next one may be twice as large."""
SHORTEST_STEP = 0.1
"""Share of a step below which the search gives up."""
GAIN = 0.05
"""Share of the cost that an iteration must gain for another one to follow."""
TIGHT, STRAY = 2e-5, 5e-4
"""Mean violation of a frame, and of the worst one, m or rad, that counts as none."""
AGAIN = 1.1
"""A violation that could not be mended before counts as none up to this multiple of it."""
LEVEL = 1e-3
"""Share by which cost and violation may grow from one point to the next: rounding, where nothing is left to gain."""


Efforts = defaultdict[Stretch, Effort]


@dataclass(frozen=True)
class ClipSolution:
    """A solved clip.

    Attributes:
        solution: the trajectory.
        unsolved: frames (start, end) that stayed as they were at the start: no better trajectory was found.
    """

    solution: Solution
    unsolved: tuple[tuple[int, int], ...]


class ClipSolver:
    """Solves whole clips of one robot."""

    def __init__(
        self, geometry: RobotGeometry, collision: Collision | None = None, *, machine_code: bool = True
    ) -> None:
        """See `ClipModel`."""
        self._geometry, self._model = geometry, ClipModel(geometry, collision, machine_code=machine_code)
        self._couplings = joint_couplings(geometry.model)

    def solve(
        self,
        targets: Targets,
        start: Floats,
        com: Floats | None = None,
        stretches: list[Stretch] | None = None,
        *,
        efforts: Efforts | None = None,
        draft: bool = False,
        solved: Callable[[float], None] | None = None,
    ) -> ClipSolution:
        """Improve a clip of N frames, from rest to rest.

        Args:
            targets: what the robot should do.
            start: (N, nq) trajectory to start from, inside the limits.
            com: (N, 2) centre of mass to follow over the floor.
            stretches: what to solve one after the other; overlapping windows by default.
            efforts: of each stretch, where the clip is solved several times.
            draft: another solution follows: do not go on to the end.
            solved: is told the share of the stretches that are solved, after each.
        """
        qpos, unsolved = start.copy(), list[tuple[int, int]]()
        efforts = defaultdict(Effort) if efforts is None else efforts
        stretches = windows(len(qpos)) if stretches is None else stretches
        for done, stretch in enumerate(stretches, start=1):
            problem = ClipProblem(self._model, targets, com, stretch)
            better = self._improved(problem, qpos, efforts[stretch], DRAFT if draft else MOST)
            if better is None:
                unsolved.append((stretch.start, stretch.end))
            else:
                qpos[stretch.frames] = better
            if solved is not None:
                solved(done / len(stretches))
        for configuration in qpos:
            settle(self._geometry.model, self._couplings, configuration)
        return ClipSolution(self._measured(qpos, targets), tuple(unsolved))

    def _improved(self, problem: ClipProblem, clip: Floats, effort: Effort, most: int) -> Floats | None:
        """(n, nq) better configurations of a stretch of a clip (N, nq), or None if none were found."""
        stretch, count = problem.stretch, len(problem.stretch)
        first = now = problem.evaluate(clip, clip[stretch.frames])
        program = TrajectoryQP(stretch, self._geometry.dof_index, problem.smoothness)
        tried = Filter(count)
        tried.add(now.cost, now.violation)
        bound, kept, idle, trust = 2 * first.violation + 5 * TIGHT * count, None, 0, TRUST
        for done in range(1, most + 1):
            increments = program.solve(
                problem.quadratic(now), now.changes, problem.box(now, trust), now.soft, problem.limits(now)
            )
            effort.left -= program.iterations
            then = None if increments is None else _step(problem, clip, now, increments, tried)
            if then is None:
                trust *= LESS_TRUST
                if effort.spent or trust < LEAST_TRUST:
                    break
                continue
            if np.abs(increments).max() > FULL * trust:
                trust = min(2 * trust, MOST_TRUST)
            tried.add(then.cost, then.violation)
            # One program may bend what it mends; two say that no more can be mended.
            idle = idle + 1 if then.violation > LESS * now.violation else 0
            settled = now.cost - then.cost < GAIN * now.cost
            if idle > 1 and settled:
                effort.unmended = then.violation
            firm = idle > 1 or then.violation < AGAIN * effort.unmended
            firm = firm or (then.violation < TIGHT * count and then.worst < STRAY)
            now = then
            if now.violation < bound:
                # Of points that cost about the same the one is kept that violates less.
                if kept is None or now.violation < max(kept.violation, TIGHT * count) or now.cost < LESS * kept.cost:
                    kept = now
                if firm and (settled or done >= ITERATIONS):
                    break
            if effort.spent:
                break
        return None if kept is None else kept.qpos

    def _measured(self, qpos: Floats, targets: Targets) -> Solution:
        errors: list[Floats] = []
        points: list[Floats] = []
        centres: list[Floats] = []
        for start in range(0, len(qpos), LENGTH):
            stretch = Stretch(start, min(start + LENGTH, len(qpos)), len(qpos))
            found = ClipProblem(self._model, targets, None, stretch).evaluate(qpos, qpos[stretch.frames])
            errors.append(found.foot_error)
            points.append(found.terms["point_error"][:, 0])
            centres.append(found.terms["centre_of_mass"][:, 0])
        limits = active_limits(self._geometry.robot, qpos[:, self._geometry.qpos_index], targets.fps)
        distance, angle = np.moveaxis(np.concatenate(errors), 2, 0)
        return Solution(
            qpos=qpos,
            point_error=np.concatenate(points),
            foot_error=distance,
            centre_of_mass=np.concatenate(centres),
            released=targets.contacts & ((distance > PLANTED_M) | (angle > PLANTED_RAD)),
            limited=np.any(list(limits.values()), axis=0),
        )


def _step(problem: ClipProblem, clip: Floats, now: Point, increments: Floats, tried: Filter) -> Point | None:
    """The first point on the way along `increments` (n, nv) that the filter accepts."""
    share = 1.0
    while share >= SHORTEST_STEP:
        then = problem.evaluate(clip, problem.within(moved(now.qpos, share * increments)))
        level = then.cost < (1 + LEVEL) * now.cost and then.violation < (1 + LEVEL) * now.violation
        if level or tried.accepts(then.cost, then.violation):
            return then
        share /= 2
    return None
