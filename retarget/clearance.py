"""Distances between a robot's limbs in many frames at once, and how they change with the configuration."""

from dataclasses import dataclass

import numpy as np

from retarget.collision import Collision, proximity
from retarget.compiled import compiled
from retarget.frame_batch import BatchFunction
from retarget.geometry import RobotGeometry
from ros_free_stack.messages import Floats

TOUCH_M = 0.001
"""Depth of limbs in each other that is left alone: capsules are rounder than limbs."""
NEAR = 0.12
"""Distance, in lengths of a limb, beyond which two limbs are left alone."""


@dataclass(frozen=True)
class Clearances:
    """R pairs of limbs that are near each other, sorted by frame.

    Attributes:
        frame: (R,) frame of each pair.
        room: (R,) m by which they may come nearer: down to the distance to keep, or not at all once they are nearer;
            negative where they are in each other and have to part.
        jacobian: (R, nv) derivative of the distance.
    """

    frame: np.ndarray
    room: Floats
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
        distance = found["distances"][:, 0]
        frame, pair = np.nonzero(distance < self._near)
        distance = distance[frame, pair]
        room = np.maximum(distance - self._margins[pair], 0.0) + np.minimum(distance + TOUCH_M, 0.0)
        lines = found["lines"][frame, pair]
        velocities = found["jacobians"].reshape(len(qpos), -1, 6, found["jacobians"].shape[2])
        between = velocities[frame, self._first[pair]] - velocities[frame, self._second[pair]]
        # A pair parts at the speed of its line against its first limb less that against its second.
        return Clearances(frame, room, np.einsum("ri,rij->rj", lines, between))
