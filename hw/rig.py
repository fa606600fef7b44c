"""Which servo moves which joint, and how joint angles become goal positions."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from hw.calibration import Calibration
from hw.registers import ControlTable, control_table, is_driven
from ros_free_stack.errors import InvalidOption, ModelMismatch, UnknownName, UnsafeCommand
from ros_free_stack.messages import Bools, Floats
from ros_free_stack.robots import RobotDescription, ServoBoard, ServoSafety, ServoSettings

Raw = NDArray[np.int64]


@dataclass(frozen=True)
class Rig:
    """N joints and their servos, in the same order.

    Attributes:
        robot: name of the robot.
        joints: names.
        skipped: joints of the robot's servo map that this rig does not have.
        ids: servo ids.
        tables: control table of each servo's model, of its newest firmware; `Servos` knows each one's own.
        baud: bits a second.
        cycle_s: control cycle.
        settings: how the servos are set up.
        safety: what stops a stream.
        board: what gives the servos their power, if that is a device on their bus.
        direction: (N,) 1 or -1: sense of the servo against the joint.
        offset: (N,) servo angle at joint angle 0, rad.
        lower, upper: (N,) joint range, rad.
        velocity, acceleration: (N,) joint limits, rad/s and rad/s^2.
    """

    robot: str
    joints: tuple[str, ...]
    skipped: tuple[str, ...]
    ids: tuple[int, ...]
    tables: tuple[ControlTable, ...]
    baud: int
    cycle_s: float
    settings: ServoSettings
    safety: ServoSafety
    board: ServoBoard | None
    direction: Floats
    offset: Floats
    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats

    @classmethod
    def of_robot(
        cls, robot: RobotDescription, *, calibration: Calibration | None = None, only: Iterable[str] | None = None
    ) -> "Rig":
        """The rig of a robot's servo map; with `only`, of these joints alone.

        Raises:
            InvalidOption: the robot has no servos, or no joint is left.
            UnknownName: a joint that has none, or a servo model without a control table.
            ModelMismatch: a joint that the calibration does not cover, or a model of a family that is not driven.
        """
        servos = robot.servos
        if servos is None:
            raise InvalidOption("--robot", f"{robot.name} has no Dynamixel servos in its description")
        wanted = tuple(dict.fromkeys(only)) if only is not None else tuple(j for j in robot.joints if j in servos.ids)
        for joint in wanted:
            if joint not in servos.ids:
                raise UnknownName(f"joint of {robot.name}", joint, servos.ids)
        if not wanted:
            raise InvalidOption("--joints", f"names no joint; {robot.name} has {', '.join(servos.ids)}")
        known = (calibration or Calibration.neutral(robot)).joints
        if missing := [joint for joint in wanted if joint not in known]:
            raise ModelMismatch(f"the calibration of {robot.name} lacks {', '.join(missing)}: run `servos calibrate`")
        limits = [robot.joints[joint] for joint in wanted]
        return cls(
            robot=robot.name,
            joints=wanted,
            skipped=tuple(joint for joint in robot.joints if joint in servos.ids and joint not in wanted),
            ids=tuple(servos.ids[joint] for joint in wanted),
            tables=tuple(_driven(joint, servos.model_of(joint)) for joint in wanted),
            baud=servos.baud,
            cycle_s=servos.cycle_s,
            settings=servos.settings,
            safety=servos.safety,
            board=servos.board,
            direction=np.array([float(known[joint].direction) for joint in wanted]),
            offset=np.array([known[joint].offset for joint in wanted]),
            lower=np.array([max(item.lower, known[j].lower) for item, j in zip(limits, wanted, strict=True)]),
            upper=np.array([min(item.upper, known[j].upper) for item, j in zip(limits, wanted, strict=True)]),
            velocity=np.array([item.velocity for item in limits]),
            acceleration=np.array([item.acceleration for item in limits]),
        )

    @cached_property
    def tick(self) -> Floats:
        """(N,) rad of one position unit. A measured angle may round to half of it beyond its range."""
        return np.array([table.rad_per_tick for table in self.tables])

    @cached_property
    def zero(self) -> Raw:
        """(N,) raw position of servo angle 0."""
        return np.array([table.zero_position for table in self.tables], dtype=np.int64)

    @cached_property
    def measures_current(self) -> Bools:
        """(N,) whether the model measures current; the others report the share of full load."""
        return np.array(["Present Current" in table for table in self.tables])

    def label(self, index: int) -> str:
        """Joint and servo id, for messages."""
        return f"{self.joints[index]} (servo {self.ids[index]})"

    def to_raw(self, angles: Floats) -> Raw:
        """Joint angles (..., N) to goal positions (..., N); the last line before the bus.

        Raises:
            UnsafeCommand: not finite, or outside the joint's range.
        """
        bad = ~((angles >= self.lower - self.tick) & (angles <= self.upper + self.tick))
        if bad.any():
            where = tuple(int(i) for i in np.argwhere(bad)[0])
            joint = where[-1]
            raise UnsafeCommand(
                f"goal of {self.label(joint)}: {float(angles[where]):.3f} rad is outside "
                f"{self.lower[joint]:.3f} to {self.upper[joint]:.3f} rad"
            )
        servo = self.direction * angles + self.offset
        return np.rint(servo / self.tick).astype(np.int64) + self.zero

    def to_angles(self, raw: Raw) -> Floats:
        """Present positions (..., N) to joint angles (..., N), whole turns included."""
        return self.direction * ((raw - self.zero) * self.tick - self.offset)

    def check_steps(self, start: Floats, goals: Floats) -> None:
        """Refuse goals (K, N), one a cycle from `start` (N,), that are further apart than the joints may move.

        Raises:
            UnsafeCommand: names the worst step.
        """
        speed = np.abs(np.diff(np.vstack([start, goals]), axis=0)) / self.cycle_s
        ratio = speed / self.velocity
        k, joint = np.unravel_index(int(ratio.argmax()), ratio.shape)
        if ratio[k, joint] > 1 + _ROUNDING:
            raise UnsafeCommand(
                f"goal {k} of {self.label(int(joint))} asks for {speed[k, joint]:.2f} rad/s, "
                f"limit {self.velocity[joint]:.2f} rad/s"
            )


def _driven(joint: str, model: str) -> ControlTable:
    table = control_table(model)
    if not is_driven(model):
        raise ModelMismatch(
            f"{joint} has a servo {model}, whose registers mean other things; driven are the X series (but not XL320) "
            "and MX with Protocol 2.0"
        )
    return table


_ROUNDING = 1e-3
"""Relative excess over a limit that is rounding and no fault."""
