"""Distances between a robot's limbs in many frames at once, and how they change with the configuration."""

from dataclasses import dataclass

import numpy as np

from retarget.collision import Collision, capsule_pairs, proximity
from retarget.compiled import compiled
from retarget.frame_batch import BatchFunction
from retarget.geometry import RobotGeometry
from ros_free_stack.messages import Floats

NEAR = 0.25
"""Distance, in lengths of a limb, beyond which two limbs are left alone."""


@dataclass(frozen=True)
class Clearances:
    """R pairs of limbs that are near each other, sorted by frame: the nearest capsules of each two.

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
        self._first, self._second, self._limbs = capsule_pairs(geometry)
        function = proximity(geometry)
        self._function = BatchFunction(compiled(function) if machine_code else function)
        self._margins = Collision(geometry, machine_code=machine_code).margins
        self._near = NEAR * geometry.limb_length
        self._counts = np.diff(np.append(self._limbs, len(self._first)))

    def __call__(self, qpos: Floats) -> Clearances:
        """Clearances of (N, nq) configurations."""
        found = self._function({"qpos": qpos[:, None]})
        distance = found["distances"][:, 0]
        nearest = np.minimum.reduceat(distance, self._limbs, axis=1) if len(self._limbs) else distance
        frame, pair = np.nonzero((distance < self._near) & (distance == np.repeat(nearest, self._counts, axis=1)))
        distance = distance[frame, pair]
        room = np.maximum(distance - self._margins[pair], 0.0) + np.minimum(distance, 0.0)
        lines = found["lines"][frame, pair]
        velocities = found["jacobians"].reshape(len(qpos), -1, 6, found["jacobians"].shape[2])
        between = velocities[frame, self._first[pair]] - velocities[frame, self._second[pair]]
        # A pair parts at the speed of its line against its first limb less that against its second.
        return Clearances(frame, room, np.einsum("ri,rij->rj", lines, between))
