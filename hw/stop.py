"""The controlled stop: hold still, then torque off, each servo asked whether it obeyed; also on a failing bus."""

import time

from hw.bus import Bus
from hw.cycle import Cycle
from hw.rig import Raw, Rig
from ros_free_stack.errors import BusFault, LostServo, PortError

_SHOTS = 5
_ROUNDS = 3


def hold(cycle: Cycle, rig: Rig, goals: Raw, seconds: float) -> None:
    """Command the same goals for a while; whatever the bus does."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        try:
            cycle.exchange(goals)
        except PortError:
            return
        time.sleep(rig.cycle_s)


def torque_off(bus: Bus, rig: Rig) -> tuple[str, ...]:
    """Switch the torque of every servo off and read back that it is; disarm the watchdogs.

    Returns:
        Labels of the servos that did not confirm it. Their armed watchdog still stops them.
    """
    open_servos = dict(enumerate(rig.ids))
    for _ in range(_ROUNDS):
        try:
            for _ in range(_SHOTS):
                bus.write_together(open_servos.values(), rig.table, "Torque Enable", 0)
        except PortError:
            break
        open_servos = {i: identity for i, identity in open_servos.items() if not _is_off(bus, rig, identity)}
        if not open_servos:
            break
    return tuple(rig.label(i) for i in open_servos)


def _is_off(bus: Bus, rig: Rig, identity: int) -> bool:
    try:
        if bus.read(identity, rig.table, "Torque Enable"):
            bus.write(identity, rig.table, "Torque Enable", 0)
            return bus.read(identity, rig.table, "Torque Enable") == 0
        bus.write(identity, rig.table, "Bus Watchdog", 0)
    except (LostServo, BusFault, PortError):
        return False
    return True
