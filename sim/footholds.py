"""Footholds beside the planned ones: where feet have come to stand, and how legs stand on them without a quarrel.

A foot that lands beside its foothold stands there. Legs that go on as planned pull such feet together or apart, until
soles tip over their edges. So the plan moves: each leg reaches for where its foot is, and the body goes over from the
one foot's place to the other's as the weight does.
"""

import mujoco
import numpy as np
from scipy.ndimage import gaussian_filter1d

from ros_free_stack.messages import Floats
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription
from sim.plan import Plan

FOLLOW_S = 0.05
"""Time constant with which a lifted foot comes back to its planned place beside the standing one."""

SETTLE_S = 0.06
"""Time in which a foot that has landed comes to rest; where it is then counts until it lifts."""

SMOOTHING_S = 0.03
"""Standard deviation of the filter on the weight's share of each foot."""

GRAVITY = 9.81
_DAMPING = 1e-4
"""Of the inverse of a leg's Jacobian, m^2: a straight leg reaches no further."""


class Footholds:
    """How far feet stand from the plan; call `joints` once a cycle."""

    def __init__(self, model: mujoco.MjModel, robot: RobotDescription, plan: Plan) -> None:
        self._model, self._plan = model, plan
        soles = robot.soles.values()
        self._bodies = [model.body(sole.body).id for sole in soles]
        self._middles = [np.mean(sole.corners, axis=0) for sole in soles]
        self._legs = [_leg(model, body, joint_addresses(model, robot)[1]) for body in self._bodies]
        self._shares = _shares(plan)
        self._moved = np.zeros((len(self._bodies), 2))
        self._stood = np.full(len(self._bodies), SETTLE_S)

    def drifts(self, now: int, believed: mujoco.MjData) -> Floats:
        """(F, 2) m, how far feet are from where they were planned."""
        soles = [
            believed.xpos[body] + believed.xmat[body].reshape(3, 3) @ middle
            for body, middle in zip(self._bodies, self._middles, strict=True)
        ]
        return (np.array(soles) - self._plan.feet[now])[:, :2]

    def drift(self, now: int, believed: mujoco.MjData) -> Floats:
        """(2,) m, how far the plan of the body moves with the feet that bear it."""
        return self._shares[now] @ self.drifts(now, believed)

    def joints(self, now: int, believed: mujoco.MjData) -> Floats:
        """(J,) rad to add to the plan's angles, so that the legs reach where the feet stand."""
        self._follow(now, self.drifts(now, believed))
        added, jacobian = np.zeros(self._plan.joint_pos.shape[1]), np.zeros((6, self._model.nv))
        for body, (places, dofs), away in zip(
            self._bodies, self._legs, self._moved - self._shares[now] @ self._moved, strict=True
        ):
            mujoco.mj_jacBody(self._model, believed, jacobian[:3], jacobian[3:], body)
            leg = jacobian[:, dofs]
            wanted = np.concatenate([away, np.zeros(4)])
            added[places] += leg.T @ np.linalg.solve(leg @ leg.T + _DAMPING * np.eye(6), wanted)
        return added

    def _follow(self, now: int, drifts: Floats) -> None:
        """Take over where a foot has landed beside one that stood before: the state's own drift is the same in both."""
        standing, dt = self._plan.standing[now], self._plan.cycle_s
        settled = np.flatnonzero(standing & (self._stood >= SETTLE_S))
        for foot in np.flatnonzero(standing & (self._stood < SETTLE_S)):
            if len(settled):
                self._moved[foot] = self._moved[settled[0]] + drifts[foot] - drifts[settled[0]]
        self._stood = np.where(standing, self._stood + dt, 0.0)
        back = self._shares[now] @ self._moved - self._moved
        self._moved[~standing] += min(1.0, dt / FOLLOW_S) * back[~standing]


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
