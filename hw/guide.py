"""Guided calibration: a person moves the limp robot, the servos say where it is."""

from collections.abc import Callable

from hw.calibration import Calibration, JointCalibration
from hw.servos import Servos
from hw.units import to_si
from ros_free_stack.errors import InvalidOption, UnsafeCommand

_LEAST_RANGE = 0.2


def calibrate(servos: Servos, ask: Callable[[str], object]) -> Calibration:
    """Measure zero, direction and range of each joint.

    Args:
        servos: the joints, with torque off.
        ask: shows an instruction and returns when the person has done it.

    Raises:
        UnsafeCommand: a servo holds torque.
        InvalidOption: a joint hardly moved between its two ends.
    """
    rig = servos.rig
    for i in range(len(servos)):
        if servos.read(i, "Torque Enable"):
            raise UnsafeCommand(f"{rig.label(i)} holds torque: support the robot, then `servos release`")
    ask(f"Put {rig.robot} in its zero pose (every joint at 0 rad), then press Enter.")
    zeros = [_angle(servos, i) for i in range(len(servos))]
    joints: dict[str, JointCalibration] = {}
    for i, joint in enumerate(rig.joints):
        ask(f"Turn {joint} to the end of its positive range ({rig.upper[i]:+.2f} rad), then press Enter.")
        positive = _angle(servos, i) - zeros[i]
        ask(f"Turn {joint} to the end of its negative range ({rig.lower[i]:+.2f} rad), then press Enter.")
        negative = _angle(servos, i) - zeros[i]
        if abs(positive - negative) < _LEAST_RANGE:
            raise InvalidOption(joint, f"its ends are {abs(positive - negative):.2f} rad apart, expected more")
        direction = 1 if positive > negative else -1
        joints[joint] = JointCalibration(
            id=rig.ids[i],
            direction=direction,
            offset=zeros[i],
            lower=min(direction * negative, direction * positive),
            upper=max(direction * negative, direction * positive),
        )
    return Calibration(rig.robot, joints)


def _angle(servos: Servos, i: int) -> float:
    """Servo angle, rad."""
    return to_si(servos.table(i), "Present Position", servos.read(i, "Present Position"))
