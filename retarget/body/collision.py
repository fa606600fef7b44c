"""Distances between a robot's limbs, and how far they may shrink in one frame.

Limbs are capsules: the distance of two is that of two segments less their radii. Limbs approach each other ever more
slowly, as with the velocity damper of Faverjon and Tournassoud 1987, "A local based approach for path planning of
manipulators with a high number of degrees of freedom": joints of limited acceleration cannot stop at once.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import casadi as ca
import numpy as np

from retarget.body.compiled import BufferedFunction, compiled
from retarget.body.geometry import RobotGeometry
from retarget.body.kinematics import Kinematics
from ros_free_stack.messages import Floats

APPROACH_RATE = 12.0
"""Share of the distance left by which two limbs may approach each other, a second."""
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
    """A robot's M pairs of capsules on L pairs of limbs.

    Attributes:
        function: see `proximity`, compiled.
        margins: (M,) distances to keep, m.
    """

    def __init__(self, geometry: RobotGeometry, *, machine_code: bool = True) -> None:
        """Build and compile the distances of `geometry`; `machine_code=False` stays in the CasADi virtual machine."""
        function = proximity(geometry)
        self.function = compiled(function) if machine_code else function
        self._function = BufferedFunction(self.function)
        inputs, outputs = self._function.inputs, self._function.outputs
        self._qpos, self._step = inputs["qpos"][:, 0], inputs["step"][:, 0]
        self._left, self._ahead = outputs["left"][:, 0], outputs["ahead"][:, 0]
        self._rows = outputs["rows"].T
        # Capsules that overlap in the standing pose are rounder there than what they stand for.
        self.margins = np.minimum(MARGIN * geometry.limb_length, self.distances(geometry.standing))
        inputs["margins"][:, 0] = self.margins

    def distances(self, qpos: Floats) -> Floats:
        """(M,) distances in m at a configuration (nq,); negative where capsules overlap."""
        self._qpos[:] = qpos
        return self._function()["distances"][:, 0].copy()

    def approach(self, qpos: Floats, frame_s: float, most: int, step: Floats, free: Sequence[int] = ()) -> Approach:
        """How near limbs may come to each other in a frame of `frame_s` seconds that starts at `qpos` (nq,).

        The distance that is left above the margin, or missing, shrinks by at most, or at least, the same share. Of
        each two limbs those capsules count that will be nearest in `AHEAD` more of the last `step` (nv,), and of all
        limbs the `most` that will be nearest then: hands that are about to meet come before feet side by side. Pairs of
        limbs that are `free`, by their indices in the description, may come as near as they will.
        """
        self._qpos[:] = qpos
        np.multiply(step, AHEAD, out=self._step)
        self._function()
        for pair in free:
            self._ahead[pair] = self._left[pair] = np.inf
        if len(self._ahead) > most:
            near = self._ahead.argpartition(most - 1)[:most]
            # In order, so that each pair mostly stays in its row, and a solver's active set remains what it was.
            near.sort()
            return Approach(self._rows[near], math.expm1(-APPROACH_RATE * frame_s) * self._left[near])
        return Approach(self._rows, math.expm1(-APPROACH_RATE * frame_s) * self._left)


def proximity(geometry: RobotGeometry) -> ca.Function:
    """Build the function of M pairs of capsules on L pairs of limbs, with tangent dimension nv.

    Inputs: `qpos` (nq); a `step` (nv) to come; `margins` (M) m. Outputs: `distances` (M) m; and of the capsules of each
    two limbs that will be nearest after the step, beyond their margins, `ahead` (L) m the distance beyond the margin
    then and `left` (L) m now, `nearest` (L) m the distance now and `rows` (nv, L) its derivative.
    """
    kinematics, robot = Kinematics(geometry.model), geometry.robot
    names, every = list(robot.capsules), [(name, item) for name, items in robot.capsules.items() for item in items]
    bodies = {name: geometry.model.body(name).id for name in names}
    pairs = [
        (i, k)
        for a, b in robot.collision_pairs
        for i, k in product(*([n for n, (name, _) in enumerate(every) if name == limb] for limb in (a, b)))
    ]
    limbs = capsule_limbs(geometry)
    margins, step = ca.SX.sym("margins", len(pairs)), ca.SX.sym("step", geometry.model.nv)
    twists = {name: kinematics.twist_jacobian(body) for name, body in bodies.items()}
    speeds = {name: twist @ step for name, twist in twists.items()}
    starts, ends = (
        ca.horzcat(ca.SX(3, 0), *[kinematics.position(bodies[name], getattr(item, end)) for name, item in every])
        for end in ("start", "end")
    )
    first, second = ([pair[k] for pair in pairs] for k in range(2))
    nearest, other = nearest_points(starts[:, first], ends[:, first], starts[:, second], ends[:, second])
    between = nearest - other
    length = ca.sqrt(_dot(between, between) + _TINY**2)
    distances = length - ca.DM([[every[i][1].radius + every[k][1].radius for i, k in pairs]])
    # The unit lines between capsules, and their moments about the origin: capsules part at the speed of their line.
    lines = ca.vertcat(between, _cross(nearest, between)) / ca.repmat(length, 6, 1)
    parting = ca.horzcat(ca.SX(6, 0), *[speeds[every[i][0]] - speeds[every[k][0]] for i, k in pairs])
    left = distances - margins.T
    found = ca.vertcat(left + _dot(lines, parting), left, distances, lines)
    chosen: list[ca.SX] = []
    rows: list[ca.SX] = []
    for i, (a, b) in enumerate(robot.collision_pairs):
        best, *others = (found[:, int(pair)] for pair in np.flatnonzero(limbs == i))
        for candidate in others:
            best = ca.if_else(candidate[0] < best[0], candidate, best)
        chosen.append(best[:3])
        rows.append((twists[a] - twists[b]).T @ best[3:])
    ahead, left, nearest = ca.vertsplit(ca.horzcat(ca.SX(3, 0), *chosen))
    outputs = {
        "distances": distances.T,
        "ahead": ahead.T,
        "left": left.T,
        "nearest": nearest.T,
        "rows": ca.horzcat(ca.SX(geometry.model.nv, 0), *rows),
    }
    inputs = {"qpos": kinematics.qpos, "step": step, "margins": margins}
    dense = [ca.densify(value) for value in outputs.values()]
    return ca.Function("proximity", list(inputs.values()), dense, list(inputs), list(outputs))


def nearest_points(a: ca.SX, b: ca.SX, c: ca.SX, d: ca.SX) -> tuple[ca.SX, ca.SX]:
    """The points (3, M) nearest to each other on M segments from a to b (3, M) and as many from c to d.

    Ericson 2005, "Real-Time Collision Detection", 5.1.9. Of parallel segments any nearest points.
    """
    u, v, w = b - a, d - c, a - c
    # Of a segment that is a point any share is right: zero.
    uu, vv, uv = _dot(u, u) + _TINY, _dot(v, v) + _TINY, _dot(u, v)
    uw, vw = _dot(u, w), _dot(v, w)
    s = _share((uv * vw - uw * vv) / ca.fmax(uu * vv - uv * uv, _TINY**2))
    t = _share((uv * s + vw) / vv)
    s = _share((uv * t - uw) / uu)
    return a + ca.repmat(s, 3, 1) * u, c + ca.repmat(t, 3, 1) * v


def capsule_limbs(geometry: RobotGeometry) -> np.ndarray:
    """(M,) which two limbs, as an index into the description's pairs, each pair of capsules belongs to."""
    robot = geometry.robot
    counts = [len(robot.capsules[a]) * len(robot.capsules[b]) for a, b in robot.collision_pairs]
    return np.repeat(np.arange(len(counts)), counts)


def _dot(a: ca.SX, b: ca.SX) -> ca.SX:
    """(1, M) products of columns (N, M)."""
    return ca.sum1(a * b)


def _cross(a: ca.SX, b: ca.SX) -> ca.SX:
    """(3, M) cross products of columns (3, M)."""
    return ca.vertcat(*[a[i, :] * b[j, :] - a[j, :] * b[i, :] for i, j in ((1, 2), (2, 0), (0, 1))])


def _share(value: ca.SX) -> ca.SX:
    return ca.fmin(ca.fmax(value, 0.0), 1.0)
