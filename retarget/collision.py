"""Distances between a robot's limbs, and how far they may shrink in one frame.

Limbs are capsules: the distance of two is that of two segments less their radii. Limbs approach each other ever more
slowly, as with the velocity damper of Faverjon and Tournassoud 1987, "A local based approach for path planning of
manipulators with a high number of degrees of freedom": joints of limited acceleration cannot stop at once.
"""

from dataclasses import dataclass
from itertools import product

import mujoco
import numpy as np

from retarget.geometry import RobotGeometry
from ros_free_stack.messages import Floats

APPROACH_RATE = 12.0
"""Share of the distance left by which two limbs may approach each other, a second."""
NEAR_M = 0.08
"""Distance beyond which two limbs are left out of a frame's problem: more than two hands close in one frame."""
MARGIN = 0.005
"""Distance to keep, in lengths of a leg."""

_TINY = 1e-9


@dataclass(frozen=True)
class Approach:
    """Bounds on one frame's increment d (nv,): `jacobian` (R, nv) @ d >= `least` (R,), the least change of distance."""

    jacobian: Floats
    least: Floats


class Collision:
    """A robot's M pairs of capsules.

    Attributes:
        margins: (M,) distances to keep, m.
    """

    def __init__(self, geometry: RobotGeometry) -> None:
        model, robot = geometry.model, geometry.robot
        self._model, self._data = model, mujoco.MjData(model)
        capsules = [(model.body(body).id, item) for body, items in robot.capsules.items() for item in items]
        self._bodies = np.array([body for body, _ in capsules], dtype=int)
        self._ends = np.array([(item.start, item.end) for _, item in capsules]).reshape(-1, 2, 3).swapaxes(1, 2)
        radii = np.array([item.radius for _, item in capsules])
        of_body = {name: np.flatnonzero(self._bodies == model.body(name).id) for name in robot.capsules}
        pairs = [pair for a, b in robot.collision_pairs for pair in product(of_body[a], of_body[b])]
        self._pairs = np.array(pairs, dtype=int).reshape(-1, 2).T
        self._radii = radii[self._pairs].sum(axis=0)
        moved = np.array([_moving_joints(model, int(body)) for body in self._bodies]).reshape(-1, model.njnt)
        # A joint that moves both limbs of a pair does not change their distance.
        self._signs = moved[self._pairs[0]] - moved[self._pairs[1]]
        self._joint_dofs = model.jnt_dofadr
        leg = geometry.length("left_hip", "left_knee", "left_ankle")
        # Capsules that overlap in the standing pose are rounder there than what they stand for.
        self.margins = np.minimum(MARGIN * leg, self.distances(geometry.standing))

    def distances(self, qpos: Floats) -> Floats:
        """(M,) distances in m at a configuration (nq,); negative where capsules overlap."""
        return self._measure(qpos)[0]

    def approach(self, qpos: Floats, frame_s: float) -> Approach:
        """How near limbs may come to each other in a frame of `frame_s` seconds that starts at `qpos` (nq,).

        The distance that is left above the margin, or missing, shrinks by at most, or at least, the same share.
        """
        distances, between, nearest = self._measure(qpos)
        near = np.flatnonzero(distances < NEAR_M)
        normal = between[:, near] / (distances + self._radii)[near]
        # The speed of a point p along n about an axis a through o is n . a x (p - o), the reciprocal product of the
        # axis and the line through both nearest points.
        axes, anchors = self._data.xaxis.T, self._data.xanchor.T
        speeds = _cross(nearest[:, near], normal).T @ axes - normal.T @ _cross(axes, anchors)
        jacobian = np.zeros((len(near), self._model.nv))
        jacobian[:, self._joint_dofs] = self._signs[near] * speeds
        share = np.expm1(-APPROACH_RATE * frame_s)
        return Approach(jacobian, share * (distances - self.margins)[near])

    def _measure(self, qpos: Floats) -> tuple[Floats, Floats, Floats]:
        """Distances (M,), vectors (3, M) between the nearest points of the axes, and those (3, M) of the first."""
        data = self._data
        data.qpos[:] = qpos
        mujoco.mj_kinematics(self._model, data)
        ends = data.xmat[self._bodies].reshape(-1, 3, 3) @ self._ends + data.xpos[self._bodies, :, None]
        (a, b), (c, d) = (ends[capsules].transpose(2, 1, 0) for capsules in self._pairs)
        nearest, other = nearest_points(a, b, c, d)
        between = nearest - other
        return np.sqrt(_dot(between, between) + _TINY**2) - self._radii, between, nearest


def nearest_points(a: Floats, b: Floats, c: Floats, d: Floats) -> tuple[Floats, Floats]:
    """The points (3, M) nearest to each other on segments from a to b and from c to d, (3, M) each.

    Ericson 2005, "Real-Time Collision Detection", 5.1.9. Of parallel segments any nearest points.
    """
    u, v, w = b - a, d - c, a - c
    # Of a segment that is a point any share is right: zero.
    uu, vv, uv = _dot(u, u) + _TINY, _dot(v, v) + _TINY, _dot(u, v)
    uw, vw = _dot(u, w), _dot(v, w)
    s = _share((uv * vw - uw * vv) / np.maximum(uu * vv - uv * uv, _TINY**2))
    t = _share((uv * s + vw) / vv)
    s = _share((uv * t - uw) / uu)
    return a + s * u, c + t * v


def _dot(a: Floats, b: Floats) -> Floats:
    return np.einsum("im,im->m", a, b)


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross products of columns; `numpy.cross` takes several times longer on few."""
    return np.stack([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def _share(values: Floats) -> Floats:
    return np.minimum(np.maximum(values, 0.0), 1.0)


def _moving_joints(model: mujoco.MjModel, body: int) -> Floats:
    """(njnt,) 1 for every joint that moves a body, else 0."""
    moving = np.zeros(model.njnt)
    while body:
        first = model.body_jntadr[body]
        moving[first : first + model.body_jntnum[body]] = 1
        body = int(model.body_parentid[body])
    return moving
