"""A robot as a tree of moving bodies in its model's own pose, and the pairs of limbs that mirror each other."""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np

from ros_free_stack.couplings import joint_couplings
from ros_free_stack.messages import Floats

MIRROR_TOLERANCE = 0.02
"""How far mirrored joints may be from where they should, in sizes of the robot."""


@dataclass(frozen=True)
class Pair:
    """Two chains of moving bodies, left and right, from one body `hub` outward to their ends or first branching."""

    hub: int
    left: tuple[int, ...]
    right: tuple[int, ...]


class Tree:
    """The moving bodies of a model.

    Attributes:
        model: the compiled model.
        base: the body with the free joint, or that the model fixes to the world and everything hangs from.
        free: whether the base is free.
        position: (nbody, 3) m in the model's own pose.
        rotation: (nbody, 3, 3).
        children: moving bodies that follow each moving body, or the base, along the tree.
    """

    def __init__(self, model: mujoco.MjModel, base: int) -> None:
        self.model, self.base = model, base
        self.free = _is_free(model, base)
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        self.position = data.xpos.copy()
        self.rotation = data.xmat.reshape(-1, 3, 3).copy()
        self.axes, self.anchors = data.xaxis.copy(), data.xanchor.copy()
        self.centre = data.xipos.copy()
        followers = {coupling.joint for coupling in joint_couplings(model)}
        self._joints = {
            body: tuple(
                joint
                for joint in range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
                if joint not in followers
            )
            for body in range(model.nbody)
            if body != base
        }
        self.children: dict[int, list[int]] = {base: []}
        for body in range(1, model.nbody):
            if body != base and self._joints[body] and self._hangs_from_base(body):
                self.children[body] = []
                self.children[self.carrier(int(model.body_parentid[body]))].append(body)

    def joints(self, body: int) -> tuple[int, ...]:
        """Ids of a body's own joints, without those that follow others."""
        return self._joints.get(body, ())

    def carrier(self, body: int) -> int:
        """The moving body, or the base, that a body is rigidly part of."""
        while body not in self.children:
            body = int(self.model.body_parentid[body])
        return body

    def part(self, body: int) -> tuple[int, ...]:
        """A moving body and all bodies that are rigidly part of it."""
        return tuple(other for other in self.bodies if self.carrier(other) == body)

    def name(self, body: int) -> str:
        return self.model.body(body).name

    @cached_property
    def bodies(self) -> tuple[int, ...]:
        """All bodies of the robot."""
        return tuple(body for body in range(1, self.model.nbody) if self._hangs_from_base(body))

    @cached_property
    def size(self) -> float:
        """Largest extent of the moving bodies' places, m."""
        places = self.position[list(self.children)]
        return float(np.ptp(places, axis=0).max())

    def pairs(self) -> list[Pair]:
        """Every pair of chains that mirror each other across the plane of the base, from the base outward."""
        found: list[Pair] = []
        waiting = [self.base]
        while waiting:
            hub = waiting.pop(0)
            rest = list(self.children[hub])
            for left in self.children[hub]:
                mirrored = [other for other in rest if other != left and self._mirrors(left, other)]
                if left in rest and mirrored and self.position[left, 1] > self.position[mirrored[0], 1]:
                    rest = [body for body in rest if body not in (left, mirrored[0])]
                    found.append(Pair(hub, self.chain(left), self.chain(mirrored[0])))
            waiting += rest
        return found

    def chain(self, body: int) -> tuple[int, ...]:
        """Moving bodies from one outward, as long as each carries just one other."""
        chain = [body]
        while len(self.children[chain[-1]]) == 1:
            chain += self.children[chain[-1]]
        return tuple(chain)

    def middle_chains(self) -> list[tuple[int, ...]]:
        """Chains on the plane of symmetry from each hub outward: waist, neck, and what else is single."""
        paired = {chain[0] for pair in self.pairs() for chain in (pair.left, pair.right)}
        starts = [
            child
            for body in self._on_plane(paired)
            for child in self.children[body]
            if child not in paired and (body == self.base or len(self.children[body]) > 1)
        ]
        return [self.chain(start) for start in starts]

    def _on_plane(self, paired: set[int]) -> list[int]:
        found = [self.base]
        for body in found:
            found += [child for child in self.children[body] if child not in paired]
        return found

    def _hangs_from_base(self, body: int) -> bool:
        while body:
            if body == self.base:
                return True
            body = int(self.model.body_parentid[body])
        return False

    def _mirrors(self, first: int, second: int) -> bool:
        """Whether two subtrees are mirror images: the same shape, joints in mirrored places."""
        plane = self.position[self.base, 1]
        mirrored = self._place(second) * [1, -1, 1] + [0, 2 * plane, 0]
        near = np.linalg.norm(self._place(first) - mirrored) < MIRROR_TOLERANCE * self.size
        across = abs(self._place(first)[1] - plane) > MIRROR_TOLERANCE * self.size / 2
        mine, theirs = self.children[first], self.children[second]
        if not near or not across or len(mine) != len(theirs) or len(self._joints[first]) != len(self._joints[second]):
            return False
        left = list(theirs)
        for child in mine:
            match = next((other for other in left if self._mirrors(child, other)), None)
            if match is None:
                return False
            left.remove(match)
        return True

    def _place(self, body: int) -> Floats:
        return self.anchors[self._joints[body][0]]


def base_bodies(model: mujoco.MjModel) -> list[int]:
    """Bodies that a robot can hang from: those with a free joint, else children of the world with joints below them."""
    free = [body for body in range(1, model.nbody) if _is_free(model, body)]
    roots = {int(model.body_rootid[model.jnt_bodyid[joint]]) for joint in range(model.njnt)}
    return free or sorted(roots)


def _is_free(model: mujoco.MjModel, body: int) -> bool:
    first = model.body_jntadr[body]
    return first >= 0 and bool(model.jnt_type[first] == mujoco.mjtJoint.mjJNT_FREE)
