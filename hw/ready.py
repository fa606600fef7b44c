"""What must hold before a stream: the one list of checks, for dry runs as for real ones. Nothing is written."""

from collections.abc import Callable

import numpy as np

from hw.configure import MODES, NO_SECONDARY_ID, SECONDARY_ID, pose_settings
from hw.cycle import Cycle
from hw.line import WATCHDOG_TRIPPED
from hw.safety import hardware_errors
from hw.servos import Servos
from hw.units import to_si
from ros_free_stack.errors import ServoFault, UnsafeCommand
from ros_free_stack.messages import Floats

SLACK = 0.1
"""rad that a joint may stand outside its range; it is brought back slowly."""
CURE = "run `servos configure --write`"
_ALL_ANSWERED = 2


def check_ready(servos: Servos, cycle: Cycle, min_voltage: Floats, check: Callable[[], None]) -> None:
    """Check every servo of a rig, and that they can be read within the cycle.

    Args:
        servos: found.
        cycle: finds out how they are read.
        min_voltage: (N,) V.
        check: called before each servo; may raise to give up.

    Raises:
        ServoFault: a hardware error, a tripped watchdog, heat, or too low a voltage.
        UnsafeCommand: a setting that the robot must not have, or a joint outside its range.
        BusFault: the servos answer pings but no reads of their state.
    """
    for i in range(len(servos)):
        check()
        _check_state(servos, i, float(min_voltage[i]))
        _check_settings(servos, i)
        _check_pose(servos, i)
        _check_mapping(servos, cycle, i)
    cycle.choose_method()
    _check_delays(servos, cycle)


def _check_state(servos: Servos, i: int, min_voltage: float) -> None:
    label, safety = servos.label(i), servos.rig.safety
    if error := servos.read(i, "Hardware Error Status"):
        raise ServoFault(label, f"hardware error: {hardware_errors(error)}; run `servos reboot`")
    if servos.read(i, "Bus Watchdog") == WATCHDOG_TRIPPED:
        raise ServoFault(
            label, "its bus watchdog tripped: a stream before this one died; run `servos release` to recover it"
        )
    if (heat := servos.read(i, "Present Temperature")) > safety.temperature:
        raise ServoFault(label, f"{heat} deg C, limit {safety.temperature:g} deg C")
    volts = to_si(servos.table(i), "Present Input Voltage", servos.read(i, "Present Input Voltage"))
    if volts < min_voltage:
        raise ServoFault(label, f"{volts:.1f} V, minimum {min_voltage:.1f} V")


def _check_settings(servos: Servos, i: int) -> None:
    rig, label = servos.rig, servos.label(i)
    level = servos.read(i, "Status Return Level")
    if level != _ALL_ANSWERED:
        raise UnsafeCommand(f"{label} has status return level {level} and confirms no command: {CURE}")
    if SECONDARY_ID in servos.table(i) and (second := servos.read(i, SECONDARY_ID)) < NO_SECONDARY_ID:
        raise UnsafeCommand(f"{label} has secondary id {second} and moves with servo {second} too: {CURE}")
    for register, value in pose_settings(rig).items():
        if (found := servos.read(i, register)) != value:
            words = f" ({rig.settings.mode})" if value == MODES[rig.settings.mode] else ""
            raise UnsafeCommand(f"{label} has {register} {found}, {rig.robot} needs {value}{words}: {CURE}")


def _check_pose(servos: Servos, i: int) -> None:
    rig = servos.rig
    angle = float(rig.to_angles(np.full(len(servos), servos.read(i, "Present Position")))[i])
    if not rig.lower[i] - SLACK <= angle <= rig.upper[i] + SLACK:
        raise UnsafeCommand(
            f"{servos.label(i)} stands at {angle:.3f} rad, outside its range {rig.lower[i]:.3f} to "
            f"{rig.upper[i]:.3f} rad: move it by hand or calibrate"
        )


def _check_mapping(servos: Servos, cycle: Cycle, i: int) -> None:
    """The driver points the indirect addresses at the state; they are locked while the torque is on."""
    address, mapping = cycle.map_state(i)
    found = servos.bus(i).read_bytes(servos.units[i].id, address, len(mapping))
    if found != mapping and servos.read(i, "Torque Enable"):
        raise UnsafeCommand(f"{servos.label(i)} already holds torque: support the robot, then `servos release`")


def _check_delays(servos: Servos, cycle: Cycle) -> None:
    """Each servo waits for its return delay before it answers; together they may be slower than the cycle."""
    rig = servos.rig
    delays = [
        to_si(servos.table(i), "Return Delay Time", servos.read(i, "Return Delay Time")) for i in range(len(rig.ids))
    ]
    for bus in servos.buses:
        waits = [delays[i] for i in range(len(rig.ids)) if servos.bus(i) is bus]
        # One answer of all servos waits once.
        needed = cycle.wire_s(bus) + (max(waits, default=0.0) if cycle.method == "fast sync read" else sum(waits))
        if cycle.method != "single reads" and needed > rig.cycle_s:
            slowest = int(np.argmax(delays))
            raise UnsafeCommand(
                f"reading all servos on {bus.port} by {cycle.method} takes {1e3 * needed:.1f} ms, the cycle has "
                f"{1e3 * rig.cycle_s:g} ms; {servos.label(slowest)} has return delay "
                f"{1e6 * delays[slowest]:.0f} us: {CURE}"
            )
