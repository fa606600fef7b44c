"""The controlled stop: hold still, then torque off, each servo asked whether it obeyed; also on a failing bus."""

import time

from hw.cycle import Cycle
from hw.line import WATCHDOG_TRIPPED
from hw.rig import Raw
from hw.servos import Group
from ros_free_stack.errors import BusFault, LostServo, PortError

_SHOTS = 5
_ROUNDS = 3


def hold(cycle: Cycle, goals: Raw, seconds: float, cycle_s: float) -> None:
    """Command the same goals for a while; whatever the bus does."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        try:
            cycle.exchange(goals)
        except PortError:
            return
        time.sleep(cycle_s)


def torque_off(servos: Group, *, recover: bool = False) -> tuple[str, ...]:
    """Switch the torque of every servo off and read back that it is; disarm the watchdogs.

    A watchdog that has tripped stays so, and keeps the servo from moving, unless `recover`.

    Returns:
        Labels of the servos that did not confirm it. Their armed watchdog still stops them.
    """
    left = list(range(len(servos)))
    for _ in range(_ROUNDS):
        for _ in range(_SHOTS):
            try:
                servos.write_together(left, "Torque Enable", 0)
            except PortError:
                # The servos on the other ports were written; who did not hear it shows below.
                break
        left = [i for i in left if not _is_off(servos, i, recover=recover)]
        if not left:
            break
    return tuple(servos.label(i) for i in left)


def disarm(servos: Group) -> tuple[str, ...]:
    """Switch the watchdogs off, so that the servos hold when nobody speaks; return who did not confirm it."""
    left: list[str] = []
    for i in range(len(servos)):
        try:
            servos.write(i, "Bus Watchdog", 0)
        except (LostServo, BusFault, PortError):
            left.append(servos.label(i))
    return tuple(left)


def _is_off(servos: Group, i: int, *, recover: bool) -> bool:
    try:
        if servos.read(i, "Torque Enable"):
            servos.write(i, "Torque Enable", 0)
            return servos.read(i, "Torque Enable") == 0
        if recover or servos.read(i, "Bus Watchdog") != WATCHDOG_TRIPPED:
            servos.write(i, "Bus Watchdog", 0)
    except (LostServo, BusFault, PortError):
        return False
    return True
