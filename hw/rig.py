"""Which servo moves which joint, and how joint angles become goal positions."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hw.calibration import Calibration
from hw.registers import ControlTable, control_table
from ros_free_stack.errors import InvalidOption, UnknownName, UnsafeCommand
from ros_free_stack.messages import Floats
from ros_free_stack.robots import RobotDescription

Raw = NDArray[np.int64]


@dataclass(frozen=True)
class Rig:
    """N joints and their servos, in the same order.

    Attributes:
        robot: name of the robot.
        joints: names.
        ids: servo ids.
        table: control table of the servo model.
        baud: bits a second.
        cycle_s: control cycle.
        direction: (N,) 1 or -1: sense of the servo against the joint.
        offset: (N,) servo angle at joint angle 0, rad.
        lower, upper: (N,) joint range, rad.
        velocity, acceleration: (N,) joint limits, rad/s and rad/s^2.
    """

    robot: str
    joints: tuple[str, ...]
    ids: tuple[int, ...]
    table: ControlTable
    baud: int
    cycle_s: float
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
            InvalidOption: the robot has no servos.
            UnknownName: a joint that has none.
        """
        servos = robot.servos
        if servos is None:
            raise InvalidOption("--robot", f"{robot.name} has no Dynamixel servos in its description")
        wanted = tuple(only) if only is not None else tuple(joint for joint in robot.joints if joint in servos.ids)
        for joint in wanted:
            if joint not in servos.ids:
                raise UnknownName(f"joint of {robot.name}", joint, servos.ids)
        limits = [robot.joints[joint] for joint in wanted]
        known = (calibration or Calibration.neutral(robot)).joints
        return cls(
            robot=robot.name,
            joints=wanted,
            ids=tuple(servos.ids[joint] for joint in wanted),
            table=control_table(servos.model),
            baud=servos.baud,
            cycle_s=servos.cycle_s,
            direction=np.array([float(known[joint].direction) for joint in wanted]),
            offset=np.array([known[joint].offset for joint in wanted]),
            lower=np.array([max(item.lower, known[j].lower) for item, j in zip(limits, wanted, strict=True)]),
            upper=np.array([min(item.upper, known[j].upper) for item, j in zip(limits, wanted, strict=True)]),
            velocity=np.array([item.velocity for item in limits]),
            acceleration=np.array([item.acceleration for item in limits]),
        )

    def label(self, index: int) -> str:
        """Joint and servo id, for messages."""
        return f"{self.joints[index]} (servo {self.ids[index]})"

    def to_raw(self, angles: Floats) -> Raw:
        """Joint angles (..., N) to goal positions (..., N); the last line before the bus.

        Raises:
            UnsafeCommand: not finite, or outside the joint's range.
        """
        bad = ~((angles >= self.lower - self._tick) & (angles <= self.upper + self._tick))
        if bad.any():
            where = tuple(int(i) for i in np.argwhere(bad)[0])
            joint = where[-1]
            raise UnsafeCommand(
                f"goal of {self.label(joint)}: {float(angles[where]):.3f} rad is outside "
                f"{self.lower[joint]:.3f} to {self.upper[joint]:.3f} rad"
            )
        servo = self.direction * angles + self.offset
        return np.rint(servo / self.table.rad_per_tick).astype(np.int64) + self.table.zero_position

    def to_angles(self, raw: Raw) -> Floats:
        """Present positions (..., N) to joint angles (..., N)."""
        return self.direction * ((raw - self.table.zero_position) * self.table.rad_per_tick - self.offset)

    @property
    def _tick(self) -> float:
        """A measured angle may round to half a tick beyond its range."""
        return self.table.rad_per_tick
