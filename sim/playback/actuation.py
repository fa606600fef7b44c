"""The actuators as a controller meets them: position servos on a bus that it reaches once a cycle.

A servo pulls with kp (goal - q) - kd v up to its torque limit, in its own loop that runs at the rate of the physics.
The controller reads angles and writes goals once a bus cycle. What it decides from one reading reaches the servos with
the next cycle's goals: a latency of one cycle. Goals and readings are whole steps of the encoder where that is known.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from ros_free_stack.errors import InvalidFile
from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription

CYCLE_S = 0.002
"""Cycle of robots without a servo bus of their own in the description: the 500 Hz of Unitree's low-level interface
(unitree_sdk2, whose examples write commands every 2 ms)."""

AT_LIMIT = 0.999
"""A torque of this share of the limit counts as saturated."""


@dataclass(frozen=True)
class Servos:
    """Position servos in the description's joint order.

    Attributes:
        actuators: (J,) indices into MuJoCo's controls.
        kp: (J,) N m/rad.
        kd: (J,) N m s/rad of the servo itself; the damping of joints is not in it.
        resolution: rad of one encoder step; 0 where it is not known.
        cycle_steps: physics steps in a bus cycle.
    """

    actuators: np.ndarray
    kp: Floats
    kd: Floats
    resolution: float
    cycle_steps: int

    def goals(self, position: Floats, velocity: Floats, torque: Floats) -> Floats:
        """Goals (..., J) in rad with which servos at these angles (rad) and speeds (rad/s) give a torque (N m)."""
        return position + (torque + self.kd * velocity) / self.kp

    def rounded(self, angles: Floats) -> Floats:
        """Angles in rad to whole encoder steps."""
        return np.rint(angles / self.resolution) * self.resolution if self.resolution else angles


def read_servos(model: mujoco.MjModel, robot: RobotDescription) -> Servos:
    """The servos of a judging model.

    Raises:
        InvalidFile: a joint has none.
    """
    joints = model.actuator_trnid[:, 0].tolist()
    actuators: list[int] = []
    for name in robot.joint_names:
        joint = model.joint(name).id
        if joint not in joints or not _is_servo(model, joints.index(joint)):
            raise InvalidFile(robot.model_path, f"joint {name} has no position actuator or motor to move it")
        actuators.append(joints.index(joint))
    index = np.array(actuators)
    cycle = robot.servos.cycle_s if robot.servos else CYCLE_S
    motor = robot.servos.motor if robot.servos else None
    return Servos(
        actuators=index,
        kp=model.actuator_gainprm[index, 0],
        kd=-model.actuator_biasprm[index, 2],
        resolution=2 * np.pi / motor.encoder_steps if motor else 0.0,
        cycle_steps=max(1, round(cycle / model.opt.timestep)),
    )


def _is_servo(model: mujoco.MjModel, actuator: int) -> bool:
    gain = model.actuator_gainprm[actuator, 0]
    return bool(gain > 0 and model.actuator_biasprm[actuator, 1] == -gain)
