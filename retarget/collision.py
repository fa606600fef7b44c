"""Distances between a robot's limbs, and how far they may shrink in one frame.

Limbs are capsules: the distance of two is that of two segments less their radii. Limbs approach each other ever more
slowly, as with the velocity damper of Faverjon and Tournassoud 1987, "A local based approach for path planning of
manipulators with a high number of degrees of freedom": joints of limited acceleration cannot stop at once.
"""

import math
from dataclasses import dataclass
from itertools import product

import casadi as ca
import numpy as np

from retarget.compiled import BufferedFunction, compiled
from retarget.geometry import RobotGeometry
from retarget.kinematics import Kinematics
from ros_free_stack.messages import Floats

APPROACH_RATE = 12.0
"""Share of the distance left by which two limbs may approach each other, a second."""
NEAR_M = 0.08
"""Distance beyond the margin from which two limbs are left out: more than two hands close in one frame."""
AHEAD = 5.0
"""Frames for which the nearest limbs are foreseen."""
MARGIN = 0.005
"""Distance to keep, in lengths of a leg."""

_TINY = 1e-9


@dataclass(frozen=True)
class Approach:
    """Bounds on one frame's step s (nv,): `jacobian` (R, nv) @ s >= `least` (R,), the least change of distance."""

    jacobian: Floats
    least: Floats


class Collision:
    """A robot's M pairs of capsules.

    Attributes:
        margins: (M,) distances to keep, m.
    """

    def __init__(self, geometry: RobotGeometry, *, machine_code: bool = True) -> None:
        """Build and compile the distances of `geometry`; `machine_code=False` stays in the CasADi virtual machine."""
        self._first, self._second, self._nearest = capsule_pairs(geometry)
        self._limbs = np.searchsorted(self._nearest, np.arange(len(self._first)), side="right")
        function = proximity(geometry)
        self._function = BufferedFunction(compiled(function) if machine_code else function)
        self._lines = self._function.outputs["lines"].T
        self._jacobians = self._function.outputs["jacobians"].T
        self.margins = np.full(len(self._first), MARGIN * geometry.limb_length)
        # Capsules that overlap in the standing pose are rounder there than what they stand for.
        self.margins = np.minimum(self.margins, self.distances(geometry.standing))

    def distances(self, qpos: Floats) -> Floats:
        """(M,) distances in m at a configuration (nq,); negative where capsules overlap."""
        return self._measure(qpos).copy()

    def approach(self, qpos: Floats, frame_s: float, most: int | None = None, step: Floats | None = None) -> Approach:
        """How near limbs may come to each other in a frame of `frame_s` seconds that starts at `qpos` (nq,).

        The distance that is left above the margin, or missing, shrinks by at most, or at least, the same share. Pairs
        beyond `NEAR_M` are left out, or all but the `most` that will be nearest in `AHEAD` more of the last `step`
        (nv,), one of each two limbs: hands that are about to meet come before feet that stand side by side.
        """
        left = self._measure(qpos) - self.margins
        if most is None:
            near = np.flatnonzero(left < NEAR_M)
        else:
            then = left if step is None else left + AHEAD * self._parting(step)
            # Sorted by distance among those of the same two limbs, the nearest comes first.
            near = np.lexsort((then, self._limbs))[self._nearest]
            near = near[np.argpartition(then[near], most - 1)[:most]] if len(near) > most else near
        lines = np.zeros((len(near), len(self._jacobians) // 6, 6))
        pairs = np.arange(len(near))
        lines[pairs, self._first[near]] = self._lines[near]
        lines[pairs, self._second[near]] -= self._lines[near]
        jacobian = lines.reshape(len(near), -1) @ self._jacobians
        return Approach(jacobian, math.expm1(-APPROACH_RATE * frame_s) * left[near])

    def _parting(self, step: Floats) -> Floats:
        """(M,) how far the pairs part in a step (nv,)."""
        velocities = (self._jacobians @ step).reshape(-1, 6)
        # A pair parts at the speed of its line against its first limb less that against its second.
        return (self._lines * (velocities[self._first] - velocities[self._second])).sum(axis=1)

    def _measure(self, qpos: Floats) -> Floats:
        self._function.inputs["qpos"][:, 0] = qpos
        return self._function()["distances"][:, 0]


def proximity(geometry: RobotGeometry) -> ca.Function:
    """Build the function of M pairs of capsules on L limbs, with tangent dimension nv.

    Input: `qpos` (nq). Outputs: `distances` (M) m; `lines` (6, M) the unit line from the second to the first nearest
    point, (direction, moment about the origin); `jacobians` (nv, 6L) of every limb's velocity at the origin and angular
    velocity, transposed. The speed at which a pair parts is its line times the difference of its limbs' velocities.
    """
    kinematics, robot = Kinematics(geometry.model), geometry.robot
    bodies = {name: geometry.model.body(name).id for name in robot.capsules}
    segments = {
        name: [
            tuple(kinematics.position(bodies[name], end) for end in (capsule.start, capsule.end))
            for capsule in capsules
        ]
        for name, capsules in robot.capsules.items()
    }
    distances: list[ca.SX] = []
    lines: list[ca.SX] = []
    for a, b in robot.collision_pairs:
        for i, k in product(range(len(segments[a])), range(len(segments[b]))):
            nearest, other = nearest_points(*segments[a][i], *segments[b][k])
            between = nearest - other
            length = ca.sqrt(ca.dot(between, between) + _TINY**2)
            distances.append(length - robot.capsules[a][i].radius - robot.capsules[b][k].radius)
            lines.append(ca.vertcat(between, ca.cross(nearest, between)) / length)
    origin = ca.SX.zeros(3, 1)
    jacobians = [
        ca.vertcat(kinematics.position_jacobian(body, origin), kinematics.rotation_jacobian(body)).T
        for body in bodies.values()
    ]
    outputs = {
        "distances": ca.vertcat(*distances) if distances else ca.SX(0, 1),
        "lines": ca.horzcat(*lines) if lines else ca.SX(6, 0),
        "jacobians": ca.horzcat(*jacobians) if jacobians else ca.SX(geometry.model.nv, 0),
    }
    return ca.Function(
        "proximity", [kinematics.qpos], [ca.densify(value) for value in outputs.values()], ["qpos"], list(outputs)
    )


def nearest_points(a: ca.SX, b: ca.SX, c: ca.SX, d: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The points (3,) nearest to each other on segments from a to b and from c to d.

    Ericson 2005, "Real-Time Collision Detection", 5.1.9. Of parallel segments any nearest points.
    """
    u, v, w = b - a, d - c, a - c
    # Of a segment that is a point any share is right: zero.
    uu, vv, uv = ca.dot(u, u) + _TINY, ca.dot(v, v) + _TINY, ca.dot(u, v)
    uw, vw = ca.dot(u, w), ca.dot(v, w)
    s = _share((uv * vw - uw * vv) / ca.fmax(uu * vv - uv * uv, _TINY**2))
    t = _share((uv * s + vw) / vv)
    s = _share((uv * t - uw) / uu)
    return a + s * u, c + t * v


def capsule_pairs(geometry: RobotGeometry) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(M,) first and (M,) second limb of every pair of capsules, in the order of `proximity`, and where in them the
    pairs of each two limbs start."""
    robot, limbs = geometry.robot, list(geometry.robot.capsules)
    counts = [len(robot.capsules[a]) * len(robot.capsules[b]) for a, b in robot.collision_pairs]
    pairs = np.array([(limbs.index(a), limbs.index(b)) for a, b in robot.collision_pairs], dtype=int).reshape(-1, 2)
    first, second = np.repeat(pairs, counts, axis=0).T
    return first, second, np.cumsum([0, *counts])[:-1]


def _share(value: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(value, 0.0), 1.0)
