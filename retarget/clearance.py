"""Distances between a robot's limbs in many frames at once, and how they change with the configuration."""

from dataclasses import dataclass

import numpy as np

from retarget.collision import Collision, proximity
from retarget.compiled import compiled
from retarget.frame_batch import BatchFunction
from retarget.geometry import RobotGeometry
from ros_free_stack.messages import Floats

NEAR = 0.12
"""Distance, in lengths of a limb, beyond which two limbs are left alone."""


@dataclass(frozen=True)
class Clearances:
    """R pairs of limbs that are near each other, sorted by frame.

    Attributes:
        frame: (R,) frame of each pair.
        excess: (R,) distance over the one to keep, m; negative where it is not kept.
        jacobian: (R, nv) derivative of the distance.
    """

    frame: np.ndarray
    excess: Floats
    jacobian: Floats


class Clearance:
    """The capsule pairs of a robot's description, evaluated on many frames."""

    def __init__(self, geometry: RobotGeometry, *, machine_code: bool = True) -> None:
        """Compile the distances of `geometry`; `machine_code=False` stays in the CasADi virtual machine."""
        robot, limbs = geometry.robot, list(geometry.robot.capsules)
        pairs = [
            (limbs.index(a), limbs.index(b))
            for a, b in robot.collision_pairs
            for _ in range(len(robot.capsules[a]) * len(robot.capsules[b]))
        ]
        self._first, self._second = np.array(pairs, dtype=int).reshape(-1, 2).T
        function = proximity(geometry)
        self._function = BatchFunction(compiled(function) if machine_code else function)
        self._margins = Collision(geometry, machine_code=machine_code).margins
        self._near = NEAR * geometry.limb_length

    def __call__(self, qpos: Floats) -> Clearances:
        """Clearances of (N, nq) configurations."""
        found = self._function({"qpos": qpos[:, None]})
        excess = found["distances"][:, 0] - self._margins
        frame, pair = np.nonzero(excess < self._near)
        lines = found["lines"][frame, pair]
        velocities = found["jacobians"].reshape(len(qpos), -1, 6, found["jacobians"].shape[2])
        between = velocities[frame, self._first[pair]] - velocities[frame, self._second[pair]]
        # A pair parts at the speed of its line against its first limb less that against its second.
        return Clearances(frame, excess[frame, pair], np.einsum("ri,rij->rj", lines, between))
