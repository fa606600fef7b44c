"""The least-squares problem of a stretch of frames, evaluated and linearised at a trajectory."""

from dataclasses import dataclass

import numpy as np

from retarget.body.clearance import Clearance, Clearances
from retarget.body.collision import Collision
from retarget.body.compiled import compiled
from retarget.body.frame_batch import BatchFunction
from retarget.body.geometry import RobotGeometry
from retarget.plan.targets import Targets
from retarget.solve.differences import Stretch, steps
from retarget.solve.frame_problem import DAMPING, ROOT_SHARE, SWING_WEIGHTS
from retarget.solve.frame_solver import POSTURE, STANDING_POSTURE
from retarget.solve.limits import JointBounds
from retarget.solve.trajectory_qp import LimitedDifferences, Quadratic, SoftRows
from retarget.solve.trajectory_terms import CORNERS, trajectory_terms
from ros_free_stack.messages import Floats

HELD_WEIGHTS = (2000.0, 600.0)
"""Weights of (position, rotation) of a foot that stands: it gives way by micrometres."""
COM_WEIGHT = 60.0
"""Weight of the centre of mass in lengths of a leg: its acceleration decides where the ZMP is."""
LANDING = 0.006
"""Height of a sole, in lengths of a leg, below which a swinging foot is led like one that stands, lest it scrapes."""
CLEAR = 0.01
"""The same above which a swinging sole stays where the plan has it higher."""
NEAR = 0.06
"""Height in lengths of a leg below which a corner of a swinging sole is kept above the floor: the next iteration sees
what comes from higher up."""
SMOOTHNESS = 10.0
"""Weight of a joint's change of step at `RATE` frames a second."""
ROOT_SMOOTHNESS = (100.0, 100.0)
"""The same of the root: translation in lengths of a leg, rotation."""
RATE = 50.0
ROOM = 2e-6
"""Least distance in rad that is kept from every limit of a joint."""
NEAR_LIMIT = 0.4
"""Share of a limit from which a joint's step, or change of step, is watched."""


class ClipModel:
    """The compiled functions of one robot's frames."""

    def __init__(
        self, geometry: RobotGeometry, collision: Collision | None = None, *, machine_code: bool = True
    ) -> None:
        """Build and compile them, but for those of a `collision` that is there already.

        `machine_code=False` stays in the CasADi virtual machine.
        """
        self.geometry = geometry
        terms = trajectory_terms(geometry)
        self.terms = BatchFunction(compiled(terms) if machine_code else terms)
        self.clearance = Clearance(geometry, collision or Collision(geometry, machine_code=machine_code))


@dataclass(frozen=True)
class Point:
    """A trajectory of a stretch (n, nq), what it costs, and how.

    Attributes:
        qpos: (n, nq).
        terms: outputs of `trajectory_terms` for each frame.
        foot_error: (n, F, 2) distances (m) and angles of the soles from their targets.
        steps, changes: (n + 3, nv) and (n + 2, nv) first and second differences.
        soft: heights of soles and distances between limbs that are to be kept.
        cost: without what `violation` counts.
        violation: distances in m and rad of held feet from their footholds, and by which soles are too low and limbs
            too near, all frames together.
        worst: the same of the worst frame.
    """

    qpos: Floats
    terms: dict[str, Floats]
    foot_error: Floats
    steps: Floats
    changes: Floats
    soft: SoftRows
    cost: float
    violation: float
    worst: float


class ClipProblem:
    """A stretch of a clip: targets, weights and limits of its frames."""

    def __init__(self, model: ClipModel, targets: Targets, com: Floats | None, stretch: Stretch) -> None:
        """`com` (N, 2) is a centre of mass of the whole clip to follow over the floor."""
        self._model, self.stretch, geometry = model, stretch, model.geometry
        self._index, self._dofs, self._standing = geometry.qpos_index, geometry.dof_index, geometry.standing
        self._length = geometry.limb_length
        self._bounds = JointBounds.of(geometry.robot, targets.fps)
        # A held root, and joints that only follow others.
        self._fixed = JointBounds.tangent(geometry, targets.fps).step == 0
        planned = self._planned_heights(targets)
        self._held = targets.contacts[stretch.frames] | (planned < LANDING * self._length)
        self._clear = np.clip(planned, 0.0, CLEAR * self._length)
        self._inputs = self._frame_inputs(targets, com)
        self._posture = POSTURE + (1 - targets.following[stretch.frames, None]) * (STANDING_POSTURE - POSTURE)
        root = np.repeat(ROOT_SMOOTHNESS, 3) / np.repeat([self._length, 1.0], 3) ** 2
        self.smoothness = np.concatenate([root, np.full(len(self._fixed) - 6, SMOOTHNESS)])
        self.smoothness *= ~self._fixed * (targets.fps / RATE) ** 4
        self._damping = DAMPING * np.where(np.arange(len(self._fixed)) < 6, ROOT_SHARE, 1.0)

    def evaluate(self, clip: Floats, qpos: Floats) -> Point:
        """The stretch at (n, nq) configurations, inside a clip (N, nq)."""
        step = steps(self.stretch.around(clip, qpos))
        change = np.diff(step, axis=0)
        terms = self._model.terms({"qpos": qpos[:, None], **self._inputs})
        foot_error = np.linalg.norm(terms["foot_error"], axis=2).reshape(*self._held.shape, 2)
        soft = self._soft_rows(terms, self._model.clearance(qpos))
        missing = np.zeros(len(qpos))
        np.maximum.at(missing, soft.frame, soft.lower)
        slip = foot_error * self._held[..., None]
        violation = missing + slip.sum(axis=(1, 2))
        tracking = terms["cost"].sum() - ((self._inputs["sole_weights"] * slip) ** 2).sum()
        posture = (self._posture * self._away(qpos) ** 2).sum()
        cost = float(tracking + posture + (self.smoothness * change**2).sum()) / 2
        return Point(qpos, terms, foot_error, step, change, soft, cost, float(violation.sum()), float(violation.max()))

    def quadratic(self, point: Point) -> Quadratic:
        """Gauss-Newton model of the frames' costs."""
        hessian, gradient = point.terms["hessian"].copy(), point.terms["gradient"][:, 0].copy()
        hessian[:, self._dofs, self._dofs] += self._posture
        gradient[:, self._dofs] += self._posture * self._away(point.qpos)
        hessian[:, self._fixed] = hessian[:, :, self._fixed] = gradient[:, self._fixed] = 0.0
        diagonal = np.arange(len(self._fixed))
        hessian[:, diagonal, diagonal] += np.where(self._fixed, 1.0, self._damping)
        return Quadratic(hessian, gradient)

    def box(self, point: Point, trust: float) -> tuple[Floats, Floats]:
        """(n, nv) bounds of the increments: joint ranges and the trust region."""
        joints = point.qpos[:, self._index]
        low = np.full((len(joints), len(self._fixed)), -trust)
        high = -low
        low[:, self._dofs] = np.maximum(-trust, np.minimum(self._bounds.lower + ROOM - joints, 0))
        high[:, self._dofs] = np.minimum(trust, np.maximum(self._bounds.upper - ROOM - joints, 0))
        return low, high

    def limits(self, point: Point) -> LimitedDifferences:
        """Limits of what increments add to the joints' steps and changes of step."""
        now = np.concatenate([point.steps, point.changes])[:, self._dofs]
        limit = np.repeat(
            [self._bounds.step - ROOM, self._bounds.change - ROOM], [len(point.steps), len(point.changes)], axis=0
        )
        return LimitedDifferences(-limit - now, limit - now, np.abs(now) > NEAR_LIMIT * limit)

    def within(self, qpos: Floats) -> Floats:
        """The configurations with joints inside their ranges to the last bit."""
        qpos[:, self._index] = np.clip(qpos[:, self._index], self._bounds.lower, self._bounds.upper)
        return qpos

    def _away(self, qpos: Floats) -> Floats:
        return qpos[:, self._index] - self._standing[self._index]

    def _planned_heights(self, targets: Targets) -> Floats:
        """(n, F) height of the lowest corner of each sole."""
        frames, feet = self.stretch.frames, self._model.geometry.feet
        offsets = np.array([foot.corners - foot.centre for foot in feet]).reshape(len(feet), CORNERS, 3)
        lowest = np.einsum("nfj,fcj->nfc", targets.sole_rotations[frames, :, 2], offsets).min(axis=2)
        return targets.soles[frames, :, 2] + lowest

    def _soft_rows(self, terms: dict[str, Floats], near: Clearances) -> SoftRows:
        """Swinging soles clear of the floor, limbs apart."""
        height = terms["height"][:, 0] - np.repeat(self._clear, CORNERS, axis=1)
        swinging = np.repeat(~self._held, CORNERS, axis=1)
        frame, corner = np.nonzero(swinging & (height < NEAR * self._length))
        frames = np.concatenate([frame, near.frame])
        jacobian = np.concatenate([terms["height_jacobian"][frame, corner], near.jacobian])
        jacobian[:, self._fixed] = 0.0
        lower = -np.concatenate([height[frame, corner], near.room])
        order = np.argsort(frames, kind="stable")
        return SoftRows(frames[order], jacobian[order], lower[order])

    def _frame_inputs(self, targets: Targets, com: Floats | None) -> dict[str, Floats]:
        """Inputs of `trajectory_terms` but `qpos`."""
        frames, count, per_length = self.stretch.frames, len(self.stretch), 1 / self._length
        weights = np.where(self._held[..., None], HELD_WEIGHTS, SWING_WEIGHTS) * [per_length, 1.0]
        return {
            "points": targets.points[frames],
            "rotations": targets.rotations[frames].reshape(count, targets.rotations.shape[1], 9),
            "soles": targets.soles[frames],
            "sole_rotations": targets.sole_rotations[frames].reshape(count, targets.soles.shape[1], 9),
            "com": np.zeros((count, 1, 2)) if com is None else com[frames, None],
            "sole_weights": weights,
            "com_weight": np.full((count, 1, 1), 0.0 if com is None else COM_WEIGHT * per_length),
        }
