"""A standing pose: the model's keyframe made flat on the floor, or one found with bent knees and hanging arms."""

from collections.abc import Callable

import mujoco
import numpy as np
from scipy.optimize import least_squares

from retarget.describe.anatomy import Anatomy, Limb
from retarget.describe.tree import Tree
from ros_free_stack.couplings import joint_couplings, settle
from ros_free_stack.messages import Floats

LOWERED = 0.96
"""Height of the hips above the ankles, in lengths of the straight leg, where no keyframe says it."""
HANGING = {"left": (np.array([0.05, 0.2, -1.0]), np.array([0.5, 0.05, -1.0]))}
HANGING["right"] = (HANGING["left"][0] * [1, -1, 1], HANGING["left"][1] * [1, -1, 1])
"""Directions of upper and lower arm where no keyframe says it."""
KEEP, KEEP_ARMS = 0.03, 0.05
"""Weight of staying near the start, against lengths of a limb."""


def start_pose(model: mujoco.MjModel) -> tuple[Floats, str | None]:
    """(nq,) the model's keyframe in which the robot stands, and its name; else the model's own pose and None."""
    names = [model.key(k).name for k in range(model.nkey)]
    wanted = next((k for k, name in enumerate(names) if any(w in name.lower() for w in ("stand", "home"))), 0)
    if model.nkey:
        return model.key_qpos[wanted].copy(), names[wanted] or "the first keyframe"
    return model.qpos0.copy(), None


class Stance:
    """Searches joint angles of limbs for a pose, with the base upright where the model has it."""

    def __init__(self, tree: Tree, limits: Floats, start: Floats) -> None:
        """`limits` (njnt, 2) rad; `start` (nq,)."""
        self.tree, self.model, self.limits = tree, tree.model, limits
        self.data = mujoco.MjData(tree.model)
        self.qpos = start.copy()
        self._couplings = joint_couplings(tree.model)
        if tree.free:
            self.qpos[3:7] = [1, 0, 0, 0]
        self._show(self.qpos)

    def stand(self, anatomy: Anatomy, soles: tuple[Floats, Floats], *, keep_height: bool) -> None:
        """Both soles flat, level and parallel under the hips, the centre of mass above their middle.

        Args:
            anatomy: with legs.
            soles: (4, 3) corners of the left and the right one, in the frames of the last bodies of the legs.
            keep_height: keep the hips' height above the soles as it is; else bend the knees.
        """
        legs = anatomy.legs
        if legs is None:
            return
        lengths = [self._length(leg) for leg in legs]
        drops = [
            self._drop(leg) if keep_height else LOWERED * length for leg, length in zip(legs, lengths, strict=True)
        ]

        def residual() -> Floats:
            parts: list[Floats] = []
            places: list[Floats] = []
            for leg, corners, length, drop in zip(legs, soles, lengths, drops, strict=True):
                world = self.at(leg.bodies[-1], corners)
                forward = world[2:].mean(axis=0) - world[:2].mean(axis=0)
                across = world[0] - world[1]
                places.append(world.mean(axis=0))
                parts.append(10 * np.array([forward[2], across[2], forward[1]]) / length)
                hip = self.data.xpos[leg.root]
                parts.append(np.array([places[-1][1] - hip[1], 10 * (self._drop(leg) - drop)]) / length)
                bent = self.data.xpos[leg.middle] - (hip + places[-1]) / 2
                parts.append(np.array([max(0.0, 0.02 - bent[0] / length)]))
            middle = np.mean(places, axis=0)
            com = self.data.subtree_com[self.tree.base]
            level = places[0][2] - places[1][2]
            apart = places[0][0] - places[1][0]
            whole = 10 * level, 10 * apart, 3 * (com[0] - middle[0])
            return np.concatenate([*parts, np.array(whole) / float(np.mean(lengths))])

        self._search([*legs[0].bodies, *legs[1].bodies], residual, KEEP)
        if self.tree.free:
            feet = [self.at(leg.bodies[-1], corners) for leg, corners in zip(legs, soles, strict=True)]
            self.qpos[2] -= float(np.concatenate(feet)[:, 2].min())
            self._show(self.qpos)

    def hang(self, anatomy: Anatomy, tips: dict[str, tuple[int, Floats]]) -> None:
        """Let the arms hang; `tips` are the wrists' bodies and their offsets (3,)."""
        for side, arm in zip(("left", "right"), anatomy.arms or (), strict=False):
            body, offset = tips[side]

            def residual(arm: Limb = arm, side: str = side, body: int = body, offset: Floats = offset) -> Floats:
                places = self.data.xpos[arm.root], self.data.xpos[arm.middle], self.at(body, offset[None])[0]
                bones = (places[1] - places[0], places[2] - places[1])
                return np.concatenate([_unit(b) - _unit(d) for b, d in zip(bones, HANGING[side], strict=True)])

            self._search(list(arm.bodies), residual, KEEP_ARMS)

    def _search(self, bodies: list[int], residual: Callable[[], Floats], keep: float) -> None:
        joints = np.array([joint for body in bodies for joint in self.tree.joints(body)])
        at = self.model.jnt_qposadr[joints]
        low, high = self.limits[joints].T
        margin = 0.02 * np.minimum(high - low, 1.0)
        low, high = low + margin, high - margin
        start = np.clip(self.qpos[at], low + 1e-6, high - 1e-6)

        def cost(values: Floats) -> Floats:
            qpos = self.qpos.copy()
            qpos[at] = values
            self._show(qpos)
            return np.concatenate([residual(), keep * (values - start)])

        # Straight limbs have no direction to bend in: start a little away.
        found = [
            least_squares(cost, np.clip(start + nudge, low + 1e-6, high - 1e-6), bounds=(low, high), max_nfev=60)
            for nudge in (0.0, 0.2, -0.2)
        ]
        best = min(found, key=lambda result: float(result.cost))
        self.qpos[at] = best.x
        self._show(self.qpos)

    def _show(self, qpos: Floats) -> None:
        self.data.qpos[:] = qpos
        settle(self.model, self._couplings, self.data.qpos)
        mujoco.mj_kinematics(self.model, self.data)
        mujoco.mj_comPos(self.model, self.data)

    def at(self, body: int, points: Floats) -> Floats:
        """World positions (N, 3) of points (N, 3) of a body in the pose that was found."""
        return self.data.xpos[body] + points @ self.data.xmat[body].reshape(3, 3).T

    def _length(self, leg: Limb) -> float:
        end = leg.bodies[-1] if leg.end is None else leg.end
        places = self.tree.position[[leg.root, leg.middle, end]]
        return float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())

    def _drop(self, leg: Limb) -> float:
        """Height of the hip above the ankle, m."""
        end = leg.bodies[-1] if leg.end is None else leg.end
        return float(self.data.xpos[leg.root, 2] - self.data.xpos[end, 2])


def _unit(vector: Floats) -> Floats:
    return vector / max(float(np.linalg.norm(vector)), 1e-9)
