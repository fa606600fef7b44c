"""A solved clip, and how it is gathered frame by frame."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from retarget.body.geometry import RobotGeometry
from retarget.plan.targets import Targets
from ros_free_stack.messages import Bools, Floats

if TYPE_CHECKING:
    from retarget.solve.frame_solver import FrameSolver


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


def at_limit(low: Floats, step: Floats, high: Floats) -> Bools:
    """Whether steps are at one of their bounds."""
    return (step <= low + 1e-9) | (step >= high - 1e-9)


class History:
    """Arrays of a clip that is being solved."""

    def __init__(self, count: int, geometry: RobotGeometry) -> None:
        self._dofs = geometry.dof_index
        self._qpos = np.zeros((count, geometry.model.nq))
        self._steps = np.zeros((count, 3, geometry.model.nv))
        self._point_error = np.zeros((count, len(geometry.followed)))
        self._soles = np.zeros((count, len(geometry.feet), 3))
        self._centre_of_mass = np.zeros((count, 3))
        self._released = np.zeros((count, len(geometry.feet)), dtype=bool)

    def record(self, k: int, solver: "FrameSolver", outputs: dict[str, np.ndarray]) -> None:
        self._qpos[k], self._released[k] = solver.qpos, solver.released
        low, high = solver.bounds
        self._steps[k] = low, solver.last, high
        self._point_error[k] = outputs["point_error"][:, 0]
        self._soles[k] = outputs["sole"][:3].T
        self._centre_of_mass[k] = outputs["centre_of_mass"][:, 0]

    def solution(self, targets: Targets) -> Solution:
        low, step, high = self._steps[:, :, self._dofs].swapaxes(0, 1)
        return Solution(
            self._qpos,
            self._point_error,
            np.linalg.norm(self._soles - targets.soles, axis=-1),
            self._centre_of_mass,
            self._released,
            (np.arange(len(step)) > 0)[:, None] & at_limit(low, step, high),
        )
