"""Physics playback: the robot tries the trajectory with its own servos, on the floor, under gravity.

The controller meets the robot as it would on the bench: it reads once a bus cycle, what it decides arrives a cycle
later, and servos act on whole encoder steps (`sim.playback.actuation`). It starts at rest in the first pose and holds
the last.
"""

import copy
from collections import deque
from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.linalg import solve_banded
from scipy.ndimage import uniform_filter1d

from ros_free_stack.messages import Bools, ControllerName, Floats, Mount, StateName
from ros_free_stack.robot_model import joint_addresses
from ros_free_stack.robots import RobotDescription, ServoMotor
from sim.model import judging_model
from sim.playback.actuation import AT_LIMIT, Servos, read_servos
from sim.playback.controllers import Controller, make_controller
from sim.playback.estimation import EncodersAndImu, SensorNoise, TrueState
from sim.playback.plan import Plan, make_plan
from sim.reference import Reference

AFTERMATH_S = 0.6
"""How long a fall is watched before the simulation ends."""

LATENCY_CYCLES = 1
"""Cycles from reading the robot to goals that answer to it."""


@dataclass(frozen=True)
class Playback:
    """What happened, sampled at the trajectory's frames; N < T frames where a fall ended it early.

    "Greatest" values are those since the frame before; the first frame's include the hold before the motion and the
    last frame's all that came after it.

    Attributes:
        qpos: (N, nq) simulated poses.
        body_pos: (N, B, 3) m, world.
        body_rot: (N, B, 3, 3) world from body.
        joint_pos: (N, J) rad.
        joint_vel: (N, J) rad/s.
        torque: (N, J) N m, applied: the greatest magnitude.
        needed: (N, J) N m, feedforward torque of the reference: the greatest magnitude.
        saturated: (N, J) share of the time at the torque limit.
        contact_force: (N, F) N, normal force of the floor on each foot.
        pressure: (N, 2) m, where the floor's forces act (their centre of pressure); NaN where nothing touches it.
        height_error: (N,) m, of the torso body against the reference, greatest.
        orientation_error: (N,) difference of gravity along the torso's z axis, 0 to 2, greatest.
        power: (N,) W that all servos draw together over 0.1 s, greatest; 0 where the motor's figures are not known.
        heating: (N, J) K by which servos have warmed; 0 where the motor's figures are not known.
        unsolved: control cycles in which the controller's own program had no solution, and the plan stood in for it.
        fell_at_s: when the robot fell, from the motion's start (beyond its end if in the final hold), or None.
        controller: what moved the robot.
    """

    qpos: Floats
    body_pos: Floats
    body_rot: Floats
    joint_pos: Floats
    joint_vel: Floats
    torque: Floats
    needed: Floats
    saturated: Floats
    contact_force: Floats
    pressure: Floats
    height_error: Floats
    orientation_error: Floats
    power: Floats
    heating: Floats
    fell_at_s: float | None
    unsolved: int
    controller: ControllerName

    @property
    def frames(self) -> int:
        return len(self.qpos)


@dataclass(frozen=True)
class FallLimits:
    """Errors of the torso that count as a fall: of its height in m, and of gravity along its z axis (0 to 2)."""

    height: float
    orientation: float


@dataclass(frozen=True)
class Disturbance:
    """What makes one run differ from the nominal one.

    Attributes:
        mass: (B,) factors on the mass and inertia of each body.
        friction: factor on the floor's friction.
        late_cycles: bus cycles by which goals come later than planned.
        push: (3,) m/s by which a push changes the velocity of the whole robot, spread over 0.1 s.
        push_at: when, as a share of the playback.
        noise: of the sensors.
        seed: of the sensor noise.
    """

    mass: Floats
    friction: float
    late_cycles: int
    push: Floats
    push_at: float
    noise: SensorNoise
    seed: int


@dataclass(frozen=True)
class Stage:
    """A reference made ready for playbacks.

    Attributes:
        reference: the trajectory's kinematics.
        model: what is simulated, and what controllers take the robot to be.
        servos: of that model.
        plan: the reference at every control cycle.
    """

    reference: Reference
    model: mujoco.MjModel
    servos: Servos
    plan: Plan


@dataclass(frozen=True)
class _Log:
    """The simulation at every physics step; errors and recorded contacts by control cycle."""

    qpos: Floats
    qvel: Floats
    force: Floats
    errors: Floats
    contacts: dict[int, tuple[Floats, Floats]]
    fell_at_cycle: int | None
    unsolved: int


PUSH_S = 0.1

SUPPLY_WINDOW_S = 0.1
"""A power supply's capacitors carry peaks that are shorter."""


def set_stage(reference: Reference, *, mount: Mount = "free") -> Stage:
    """Work out what every playback of a trajectory needs.

    Args:
        reference: the trajectory's kinematics.
        mount: `free`, or `fixed` for a robot held in the air by its root.

    Raises:
        InvalidFile: a joint of the robot's model has no actuator.
    """
    model = reference.model if mount == "free" else judging_model(reference.robot, mount="fixed")
    servos = read_servos(model, reference.robot)
    return Stage(reference, model, servos, make_plan(reference, model, servos))


def play(
    stage: Stage,
    fall: FallLimits,
    *,
    controller: ControllerName = "default",
    state: StateName = "true",
    disturbance: Disturbance | None = None,
) -> Playback:
    """Simulate a trajectory at 500 Hz from rest in its first pose.

    Args:
        stage: the trajectory, from `set_stage`.
        fall: what counts as a fall; a robot with a held root never falls.
        controller: what moves the robot.
        state: what the controller reads: the simulation's `true` state, or the one `estimated` from encoders and IMU.
        disturbance: how this run differs from the nominal one; the controller knows nothing of it.
    """
    robot, plan = stage.reference.robot, stage.plan
    noise = disturbance.noise if disturbance else SensorNoise()
    if state == "true":
        estimator = TrueState(stage.model)
    else:
        rng = np.random.default_rng(disturbance.seed if disturbance else 0)
        estimator = EncodersAndImu(stage.model, robot, stage.servos, plan, noise, rng)
    mover = make_controller(controller, stage.model, robot, stage.servos, plan)
    model = _disturbed(stage.model, disturbance)
    times = stage.plan.hold_s + np.arange(len(stage.reference.qpos)) * stage.reference.dt
    frame_steps = np.rint(times / model.opt.timestep)
    at_step = np.maximum(frame_steps.astype(int) - 1, 0)
    log = _simulate(stage, model, estimator, mover, fall, disturbance, frozenset(at_step.tolist()))
    return _sample(stage, log, at_step[at_step < len(log.qpos)], controller)


def _disturbed(model: mujoco.MjModel, disturbance: Disturbance | None) -> mujoco.MjModel:
    if disturbance is None:
        return model
    model = copy.copy(model)
    model.body_mass[:] *= disturbance.mass
    model.body_inertia[:] *= disturbance.mass[:, None]
    model.geom_friction[:, 0] *= disturbance.friction
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _simulate(
    stage: Stage,
    model: mujoco.MjModel,
    estimator: TrueState | EncodersAndImu,
    mover: Controller,
    fall: FallLimits,
    disturbance: Disturbance | None,
    record: frozenset[int],
) -> _Log:
    """Step through the plan; stop a moment after a fall."""
    robot, plan, servos = stage.reference.robot, stage.plan, stage.servos
    data = mujoco.MjData(model)
    data.qpos[:] = plan.qpos[0]
    mujoco.mj_forward(model, data)
    root, torso = model.body(robot.root_body).id, model.body(robot.torso_body).id
    feet = [model.body(sole.body).id for sole in robot.soles.values()]
    floats = model.nv > len(robot.joints)
    each = servos.cycle_steps
    steps = plan.cycles * each
    qpos, qvel = np.empty((steps, model.nq)), np.empty((steps, model.nv))
    force = np.empty((steps, len(servos.kp)))
    errors = np.zeros((plan.cycles, 2))
    contacts: dict[int, tuple[Floats, Floats]] = {}
    late = LATENCY_CYCLES + (disturbance.late_cycles if disturbance else 0)
    first = servos.rounded(mover.goals(0, 0, estimator.believe(0, data)))
    waiting = deque([first] * late)
    fell: int | None = None
    last = plan.cycles
    for cycle in range(plan.cycles):
        then = min(cycle + LATENCY_CYCLES, plan.cycles - 1)
        waiting.append(servos.rounded(mover.goals(cycle, then, estimator.believe(cycle, data))))
        data.ctrl[servos.actuators] = waiting.popleft()
        if disturbance is not None and floats:
            data.xfrc_applied[root, :3] = _push(disturbance, cycle, plan, model)
        for step in range(cycle * each, (cycle + 1) * each):
            mujoco.mj_step(model, data)
            qpos[step], qvel[step] = data.qpos, data.qvel
            force[step] = data.actuator_force[servos.actuators]
            if step in record:
                contacts[step] = _floor_contact(model, data, feet)
        if floats:
            errors[cycle] = (
                abs(data.xpos[torso, 2] - plan.torso_height[cycle]),
                abs(data.xmat[torso, 8] - plan.torso_up[cycle]),
            )
            if fell is None and (errors[cycle, 0] > fall.height or errors[cycle, 1] > fall.orientation):
                fell, last = cycle, min(plan.cycles, cycle + round(AFTERMATH_S / plan.cycle_s))
        if cycle + 1 >= last:
            break
    done = last * each
    return _Log(qpos[:done], qvel[:done], force[:done], errors[:last], contacts, fell, mover.unsolved)


def _push(disturbance: Disturbance, cycle: int, plan: Plan, model: mujoco.MjModel) -> Floats:
    since = cycle * plan.cycle_s - disturbance.push_at * plan.cycles * plan.cycle_s
    return disturbance.push * model.body_subtreemass[0] / PUSH_S if 0 <= since < PUSH_S else np.zeros(3)


def _floor_contact(model: mujoco.MjModel, data: mujoco.MjData, feet: list[int]) -> tuple[Floats, Floats]:
    """(F,) N with which the floor presses on each foot, and (2,) m the centre of pressure of all it presses on."""
    forces, moment, total = np.zeros(len(feet)), np.zeros(2), 0.0
    wrench = np.zeros(6)
    touching, places = model.geom_bodyid[data.contact.geom].tolist(), data.contact.pos
    for index, bodies in enumerate(touching):
        if 0 in bodies:
            mujoco.mj_contactForce(model, data, index, wrench)
            total += wrench[0]
            moment += wrench[0] * places[index, :2]
            for foot, body in enumerate(feet):
                forces[foot] += wrench[0] * (body in bodies)
    return forces, moment / total if total > 0 else np.full(2, np.nan)


def _sample(stage: Stage, log: _Log, at_step: np.ndarray, controller: ControllerName) -> Playback:
    """Reduce the log to the trajectory's frames."""
    model, robot, plan = stage.model, stage.reference.robot, stage.plan
    each = stage.servos.cycle_steps
    addresses, dofs = joint_addresses(model, robot)
    limited: Bools = np.abs(log.force) >= AT_LIMIT * robot.effort
    starts = np.concatenate([[0], at_step[:-1] + 1])

    def greatest(values: Floats) -> Floats:
        return np.maximum.reduceat(values, starts, axis=0)

    counts = np.diff(np.append(starts, len(log.qpos)))
    body_pos = np.empty((len(at_step), model.nbody, 3))
    body_rot = np.empty((len(at_step), model.nbody, 3, 3))
    data = mujoco.MjData(model)
    for frame, step in enumerate(at_step):
        data.qpos[:] = log.qpos[step]
        mujoco.mj_kinematics(model, data)
        body_pos[frame], body_rot[frame] = data.xpos, data.xmat.reshape(-1, 3, 3)
    power, heating = _electric(model, robot, log.force, log.qvel[:, dofs])
    by_step = np.repeat(np.arange(len(log.errors)), each)
    return Playback(
        qpos=log.qpos[at_step],
        body_pos=body_pos,
        body_rot=body_rot,
        joint_pos=log.qpos[at_step][:, addresses],
        joint_vel=log.qvel[at_step][:, dofs],
        torque=greatest(np.abs(log.force)),
        needed=greatest(np.abs(plan.torque[by_step])),
        saturated=np.add.reduceat(limited.astype(float), starts, axis=0) / counts[:, None],
        contact_force=np.stack([log.contacts[int(step)][0] for step in at_step]),
        pressure=np.stack([log.contacts[int(step)][1] for step in at_step]),
        height_error=greatest(log.errors[by_step, 0]),
        orientation_error=greatest(log.errors[by_step, 1]),
        power=greatest(power),
        heating=greatest(heating),
        unsolved=log.unsolved,
        fell_at_s=None if log.fell_at_cycle is None else (log.fell_at_cycle + 1) * plan.cycle_s - plan.hold_s,
        controller=controller,
    )


def _electric(model: mujoco.MjModel, robot: RobotDescription, force: Floats, speed: Floats) -> tuple[Floats, Floats]:
    """(S,) W drawn by all servos, and (S, J) K by which each has warmed, at every physics step.

    The force limit and the damping of joints stand for a motor's speed-torque line, so force over stall torque is the
    share of the supply's voltage, and what is left at the joint after damping over stall torque the share of the stall
    current. The winding turns I^2 R into heat, which the servo's mass takes up and its surface gives off:
    C dT/dt = I^2 R - T / R_th. A servo that brakes gives nothing back to the supply.
    """
    motor: ServoMotor | None = robot.servos.motor if robot.servos else None
    if motor is None:
        return np.zeros(len(force)), np.zeros_like(force)
    _, dofs = joint_addresses(model, robot)
    current = motor.stall_current * (force - model.dof_damping[dofs] * speed) / robot.effort
    dt = model.opt.timestep
    drawn = np.maximum(motor.voltage * force / robot.effort * current, 0.0).sum(axis=1)
    drawn = uniform_filter1d(drawn, round(SUPPLY_WINDOW_S / dt), mode="nearest")
    keep = np.exp(-dt / (motor.heat_capacity * motor.thermal_resistance))
    heat = motor.resistance * current**2 * motor.thermal_resistance * (1 - keep)
    # warmth[k] - keep * warmth[k - 1] = heat[k]
    band = np.array([np.ones(len(heat)), np.full(len(heat), -keep)])
    return drawn, np.asarray(solve_banded((1, 0), band, heat, check_finite=False))
