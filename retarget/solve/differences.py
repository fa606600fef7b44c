"""Steps and changes of step of a trajectory, and how they depend on a stretch of its frames."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.spatial.transform import Rotation

from ros_free_stack.messages import Floats

Sparse = Any
"""A scipy sparse matrix; the stubs do not follow one through arithmetic."""


def moved(qpos: Floats, increments: Floats) -> Floats:
    """(N, nq) configurations of a free root and joints after tangent increments (N, nv), as MuJoCo integrates them."""
    turned = _turns(qpos) * Rotation.from_rotvec(increments[:, 3:6])
    quaternions = turned.as_quat(scalar_first=True)
    return np.hstack([qpos[:, :3] + increments[:, :3], quaternions, qpos[:, 7:] + increments[:, 6:]])


def steps(qpos: Floats) -> Floats:
    """(N - 1, nv) tangent steps from each configuration to the next."""
    turns = _turns(qpos)
    rotation = (turns[:-1].inv() * turns[1:]).as_rotvec()
    return np.hstack([np.diff(qpos[:, :3], axis=0), rotation, np.diff(qpos[:, 7:], axis=0)])


def _turns(qpos: Floats) -> Rotation:
    return Rotation.from_quat(qpos[:, 3:7], scalar_first=True)


@dataclass(frozen=True)
class Stretch:
    """Frames `start` to `end` of a clip of `total` frames that are being moved, while the others stay.

    Differences are those of the stretch with two frames on either side; before its first and after its last frame a
    clip rests.
    """

    start: int
    end: int
    total: int

    def __len__(self) -> int:
        return self.end - self.start

    @property
    def frames(self) -> slice:
        """To index arrays of the whole clip."""
        return slice(self.start, self.end)

    def around(self, clip: Floats, qpos: Floats) -> Floats:
        """(n + 4, nq) the stretch at (n, nq) with its neighbours in the whole clip (N, nq)."""
        places = self._places()
        found = clip[places]
        inside = (places >= self.start) & (places < self.end)
        found[inside] = qpos[places[inside] - self.start]
        return found

    def operators(self) -> tuple[Sparse, Sparse]:
        """(n + 3, n) and (n + 2, n): what increments of the n frames add to steps and to changes of step."""
        count, places = len(self), self._places() - self.start
        inside = np.flatnonzero((places >= 0) & (places < count))
        moves: Sparse = sp.csr_matrix((np.ones(len(inside)), (inside, places[inside])), shape=(count + 4, count))
        first = moves[1:] - moves[:-1]
        first.eliminate_zeros()
        second = first[1:] - first[:-1]
        second.eliminate_zeros()
        return first, second

    def _places(self) -> np.ndarray:
        return np.clip(np.arange(self.start - 2, self.end + 2), 0, self.total - 1)
