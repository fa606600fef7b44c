"""Distances between a robot's limbs in many frames at once, and how they change with the configuration."""

from dataclasses import dataclass

import numpy as np

from retarget.body.collision import Collision
from retarget.body.frame_batch import BatchFunction
from retarget.body.geometry import RobotGeometry
from ros_free_stack.messages import Floats

NEAR = 0.06
"""Distance, in lengths of a leg, beyond which two limbs are left alone."""


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

    def __init__(self, geometry: RobotGeometry, collision: Collision) -> None:
        """Distances of `geometry` by the function of `collision`."""
        self._function = BatchFunction(collision.function)
        self._step = np.zeros((1, geometry.model.nv))
        self._margins = collision.margins[None]
        self._near = NEAR * geometry.limb_length

    def __call__(self, qpos: Floats) -> Clearances:
        """Clearances of (N, nq) configurations."""
        inputs = {"step": self._step, "margins": self._margins}
        every = {name: np.broadcast_to(values, (len(qpos), *values.shape)) for name, values in inputs.items()}
        found = self._function({"qpos": qpos[:, None], **every})
        distance, left = found["nearest"][:, 0], found["left"][:, 0]
        near = distance < self._near
        room = np.maximum(left[near], 0.0) + np.minimum(distance[near], 0.0)
        return Clearances(np.nonzero(near)[0], room, found["rows"][near])
