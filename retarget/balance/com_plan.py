"""A centre of mass that keeps the robot on its feet: the ZMP inside the support polygon, over the whole clip at once.

With the linear inverted pendulum (Kajita et al. 2003, "Biped walking pattern generation by using preview control of
zero-moment point") the ZMP is z = c - h/g c'' for a centre of mass c at height h. By how much the solved motion's ZMP
differs from that of the centre of mass that was asked for is kept as an offset (the dynamics filter of Yamane and
Nakamura 2003): what limbs add, and where the body does not follow. All this is linear in c, so the smallest correction
of c that holds z inside the polygons is one quadratic program. A few of them, each after the motion was solved again,
learn what the body makes of c (Bristow, Tharayil and Alleyne 2006, "A survey of iterative learning control").
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import piqp
import scipy.sparse as sp
from scipy.ndimage import gaussian_filter1d
from scipy.spatial import ConvexHull

from retarget.balance.dynamics import Dynamics
from retarget.body.geometry import RobotGeometry
from retarget.plan.targets import Targets
from ros_free_stack.errors import SolverFailed
from ros_free_stack.messages import Floats

Sparse = Any
"""A scipy sparse matrix; the stubs do not follow one through arithmetic."""

SHRINK = 0.6
"""Size of the soles, about their centres, that the plan may use: the rest is left to errors and feedback."""
INSIDE_M = 0.001
"""A ZMP that leaves its polygon by less stays inside."""
GRAVITY = 9.81
ACCELERATION_WEIGHT, JERK_WEIGHT = 1e-3, 1e-6
"""Weights of the correction's acceleration (s^4) and of the motion's jerk (s^6) beside its position."""

SLACK_WEIGHT, SLACK_PRICE = 1e3, 1.0
OFFSET_SMOOTHING = 0.7
"""Standard deviation in frames of the filter on offsets: what alternates from frame to frame cannot be answered."""
OFFSET_LIMIT = 0.3
"""Largest offset, as a share of the height of the centre of mass."""

LONGEST_SHIFT = 0.05
"""Lengths of a leg by which one pass moves a body that did not follow farther: where no ankle rolls, it hardly can."""


@dataclass(frozen=True)
class Support:
    """Where the ZMP may be from frame `start` to `end`: `normals` (M, 2) @ z <= `bounds` (M,)."""

    start: int
    end: int
    normals: Floats
    bounds: Floats


def supports(geometry: RobotGeometry, targets: Targets, shrink: float) -> list[Support]:
    """The support polygon of every stretch of frames with the same footholds; none where no foot stands."""
    corners = _sole_corners(geometry, targets, shrink)
    changes = np.any(targets.contacts[1:] != targets.contacts[:-1], axis=1)
    edges = [0, *(np.flatnonzero(changes) + 1).tolist(), len(targets)]
    found: list[Support] = []
    for start, end in pairwise(edges):
        standing = targets.contacts[start]
        if standing.any():
            hull = ConvexHull(corners[start, standing].reshape(-1, 3)[:, :2])
            found.append(Support(start, end, hull.equations[:, :2], -hull.equations[:, 2]))
    return found


def zmp_excess(zmp: Floats, areas: list[Support]) -> Floats:
    """(N,) distance in m by which the ZMP is beyond the polygon's edges; 0 inside and where nothing stands."""
    excess = np.zeros(len(zmp))
    for area in areas:
        beyond = zmp[area.start : area.end] @ area.normals.T - area.bounds
        excess[area.start : area.end] = np.maximum(beyond.max(axis=1), 0)
    return excess


def balanced_com(
    dynamics: Dynamics, wanted: Floats, areas: list[Support], fps: float, asked: Floats | None = None
) -> Floats:
    """(N, 2) centre of mass nearest to `wanted` (N, 2) whose ZMP stays in the polygons.

    Frames without a polygon are flight: there the centre of mass moves at constant velocity over the floor. Where no
    centre of mass keeps the ZMP inside, the least violation is taken. A clip of fewer than four frames is returned as
    it is.

    Args:
        dynamics: of the solved motion, for heights and for the offset of its ZMP.
        wanted: centre of mass over the floor, m.
        areas: from `supports`.
        fps: frames a second.
        asked: (N, 2) centre of mass that the solved motion was to follow; its own by default.

    Raises:
        SolverFailed: the program has no solution.
    """
    count = len(wanted)
    if count < 4:
        return wanted
    curvature = _second_difference(count, fps)
    height = np.maximum(dynamics.centre_of_mass[:, 2], 0.1)
    to_zmp = (sp.eye(count) - sp.diags(height / GRAVITY) @ curvature).tocsr()
    asked = dynamics.centre_of_mass[:, :2] if asked is None else asked
    offset = gaussian_filter1d(dynamics.zmp - to_zmp @ asked, OFFSET_SMOOTHING, axis=0, mode="nearest")
    offset = np.clip(offset, -OFFSET_LIMIT * height[:, None], OFFSET_LIMIT * height[:, None])
    cost, linear = _cost(wanted, curvature, fps)
    rows, bounds = _inside(areas, to_zmp, offset, count)
    fixed = _boundary(areas, curvature, count)
    solver = piqp.SparseSolver()
    solver.settings.verbose = False
    free = np.full(2 * count, np.inf)
    solver.setup(
        cost,
        linear,
        fixed,
        np.zeros(fixed.shape[0]),
        rows,
        np.full(len(bounds), -np.inf),
        bounds,
        np.concatenate([-free, np.zeros(count)]),
        np.concatenate([free, np.full(count, np.inf)]),
    )
    status = solver.solve()
    if status != piqp.PIQP_SOLVED:
        raise SolverFailed("the balance of the centre of mass", f"PIQP {status}")
    return solver.result.x[: 2 * count].reshape(2, count).T.copy()


def nearer(com: Floats, here: Floats, longest: float) -> Floats:
    """(N, 2) `com` (N, 2), or what lies on the way to it from `here` (N, 2), nowhere farther than `longest`, m."""
    farthest = float(np.linalg.norm(com - here, axis=1).max())
    return com if farthest <= longest else here + (com - here) * longest / farthest


def _sole_corners(geometry: RobotGeometry, targets: Targets, shrink: float) -> Floats:
    """(N, F, 4, 3) planned world corners of soles shrunk about their centres."""
    offsets = np.stack([(foot.corners - foot.centre) * shrink for foot in geometry.feet])
    return targets.soles[:, :, None] + np.einsum("nfij,fcj->nfci", targets.sole_rotations, offsets)


def _second_difference(count: int, fps: float) -> Sparse:
    """(N, N) second derivative in time, zero at the ends, where the motion rests."""
    inner = np.arange(1, count - 1)
    rows = np.tile(inner, 3)
    columns = np.concatenate([inner - 1, inner, inner + 1])
    values = np.repeat([1.0, -2.0, 1.0], count - 2) * fps**2
    return sp.csr_matrix((values, (rows, columns)), shape=(count, count))


def _cost(wanted: Floats, curvature: Sparse, fps: float) -> tuple[Sparse, Floats]:
    """Quadratic and linear cost of (x, y, slack), N each."""
    count = len(wanted)
    jerk = (curvature[2:-1] - curvature[1:-2]) * fps
    follow = sp.eye(count) + ACCELERATION_WEIGHT * (curvature.T @ curvature)
    quadratic = follow + JERK_WEIGHT * (jerk.T @ jerk)
    linear = -(follow @ wanted)
    return (
        sp.block_diag([quadratic, quadratic, SLACK_WEIGHT * sp.eye(count)], format="csc"),
        np.concatenate([linear[:, 0], linear[:, 1], np.full(count, SLACK_PRICE)]),
    )


def _inside(areas: list[Support], to_zmp: Sparse, offset: Floats, count: int) -> tuple[Sparse, Floats]:
    """Rows and upper bounds that keep the ZMP inside every polygon, but for the slack of the frame."""
    blocks: list[Sparse] = []
    bounds: list[Floats] = []
    slack: Sparse = sp.eye(count, format="csr")
    for area in areas:
        frames = slice(area.start, area.end)
        for normal, bound in zip(area.normals, area.bounds, strict=True):
            blocks.append(
                sp.hstack([normal[0] * to_zmp[frames], normal[1] * to_zmp[frames], -slack[frames]], format="csr")
            )
            bounds.append(bound - offset[frames] @ normal)
    return sp.vstack(blocks, format="csc"), np.concatenate(bounds)


def _boundary(areas: list[Support], curvature: Sparse, count: int) -> Sparse:
    """Rows that are zero: speed at both ends, acceleration in flight."""
    ends = sp.csr_matrix(([1.0, -1.0, 1.0, -1.0], ([0, 0, 1, 1], [0, 1, count - 2, count - 1])), shape=(2, count))
    supported = np.zeros(count, dtype=bool)
    for area in areas:
        supported[area.start : area.end] = True
    axis: Sparse = sp.vstack([ends, curvature[np.flatnonzero(~supported)] / abs(curvature).max()])
    nothing = sp.csr_matrix((axis.shape[0], count))
    return sp.bmat([[axis, nothing, nothing], [nothing, axis, nothing]], format="csc")
