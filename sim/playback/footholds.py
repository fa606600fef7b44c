"""Footholds beside the planned ones: where feet have come to stand, and how legs stand on them without a quarrel.

A foot that lands beside its foothold stands there. Legs that go on as planned pull such feet together or apart, until
soles tip over their edges. So the plan moves: each leg reaches for where its foot is, and the body goes over from the
one foot's place to the other's as the weight does.
"""

from typing import Final

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription
from sim.playback.linear import solve_definite
from sim.playback.plan import Plan

FOLLOW_S = 0.05
"""Time constant with which a lifted foot comes back to its planned place beside the standing one."""

SETTLE_S = 0.06
"""Time in which a foot that has landed comes to rest; where it is then counts until it lifts."""

SMOOTHING_S = 0.03
"""Standard deviation of the filter on the weight's share of each foot."""

GRAVITY = 9.81
_DAMPED: Final = 1e-4 * np.eye(6)
"""Damping of the inverse of a leg's Jacobian, m^2: a straight leg reaches no further."""


class Footholds:
    """How far feet stand from the plan; call `follow` once a cycle."""

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription, plan: Plan) -> None:
        self._model, self._plan = model, plan
        soles = robot.soles.values()
        self._bodies = np.array([model.body(sole.body).id for sole in soles], dtype=int)
        self._middles = np.array([np.mean(sole.corners, axis=0) for sole in soles]).reshape(-1, 3, 1)
        self._legs = [_leg(model, body, joint_addresses(model, robot)[1]) for body in self._bodies.tolist()]
        self._shares = _shares(plan)
        self._moved = np.zeros((len(self._bodies), 2))
        self._stood = np.full(len(self._bodies), SETTLE_S)

    def follow(self, now: int, believed: mujoco.MjData) -> tuple[Floats, Floats]:
        """How the plan changes with the feet.

        Returns:
            (2,) m by which the body goes along with the feet that bear it, and (J,) rad to add to the plan's angles, so
            that the legs reach where the feet stand.
        """
        soles = believed.xpos[self._bodies] + (believed.xmat[self._bodies].reshape(-1, 3, 3) @ self._middles)[..., 0]
        drifts = (soles - self._plan.feet[now])[:, :2]
        self._take_over(now, drifts)
        return self._shares[now] @ drifts, self._joints(now, believed)

    def _take_over(self, now: int, drifts: Floats) -> None:
        """Note where a foot has landed beside one that stood before: the state's own drift is the same in both."""
        standing, dt = self._plan.standing[now], self._plan.cycle_s
        if standing.all() and self._stood.min() >= SETTLE_S:
            return
        landing = standing & (self._stood < SETTLE_S)
        if landing.any() and (standing & ~landing).any():
            settled = np.flatnonzero(standing & ~landing)[0]
            self._moved[landing] = self._moved[settled] + drifts[landing] - drifts[settled]
        self._stood = np.where(standing, self._stood + dt, 0.0)
        if not standing.all():
            back = self._shares[now] @ self._moved - self._moved
            self._moved[~standing] += min(1.0, dt / FOLLOW_S) * back[~standing]

    def _joints(self, now: int, believed: mujoco.MjData) -> Floats:
        """(J,) rad to add to the plan's angles."""
        added, jacobian = np.zeros(self._plan.joint_pos.shape[1]), np.zeros((6, self._model.nv))
        if not self._moved.any():
            return added
        wanted = np.zeros((len(self._bodies), 6))
        wanted[:, :2] = self._moved - self._shares[now] @ self._moved
        for body, (places, dofs), away in zip(self._bodies.tolist(), self._legs, wanted, strict=True):
            mujoco.mj_jacBody(self._model, believed, jacobian[:3], jacobian[3:], body)
            leg = jacobian[:, dofs]
            added[places] += leg.T @ solve_definite(leg @ leg.T + _DAMPED, away)
        return added


def _leg(model: mujoco.MjModel, body: int, dofs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Places in the description, and degrees of freedom, of the joints between a body and the root."""
    bodies = set[int]()
    while body:
        bodies.add(body)
        body = int(model.body_parentid[body])
    places = np.array([place for place, dof in enumerate(dofs) if int(model.dof_bodyid[dof]) in bodies])
    return places, dofs[places]


def _shares(plan: Plan) -> Floats:
    """(K, F) share of the weight that each standing foot should bear; 0 in flight.

    Between two feet the zero moment point of the plan's pendulum, c - c'' h / g, divides the weight.
    """
    shares = plan.standing / np.maximum(plan.standing.sum(axis=1, keepdims=True), 1)
    if shares.shape[1] == 2:
        zmp = plan.com[:, :2] - plan.com_acc[:, :2] * plan.com[:, 2:] / GRAVITY
        first, between = plan.feet[:, 0, :2], plan.feet[:, 1, :2] - plan.feet[:, 0, :2]
        way = np.einsum("kd,kd->k", zmp - first, between) / np.maximum(np.einsum("kd,kd->k", between, between), 1e-9)
        both, second = plan.standing.all(axis=1), np.clip(way, 0.0, 1.0)
        shares[both] = np.stack([1 - second, second], axis=1)[both]
    shares = gaussian_filter1d(shares, SMOOTHING_S / plan.cycle_s, axis=0, mode="nearest") * plan.standing
    return shares / np.maximum(shares.sum(axis=1, keepdims=True), 1e-9)
