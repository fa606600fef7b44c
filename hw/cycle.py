"""One control cycle of all servos of a robot: goals to every port first, then the answers, until one deadline."""

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from hw.bus import Bus
from hw.line import (
    BLOCK,
    CODE,
    MARGIN_S,
    METHODS,
    SINGLES_PER_CYCLE,
    WATCHDOG_TRIPPED,
    Line,
    Method,
    current_register,
    state_addresses,
)
from hw.protocol import ALERT
from hw.rig import Raw
from hw.servos import Servos
from hw.units import scale
from ros_free_stack.errors import BusFault
from ros_free_stack.messages import Bools, Floats

_TRIES = 5


@dataclass(frozen=True)
class Reading:
    """The state of N servos after one cycle; a servo that did not answer keeps its last values.

    Attributes:
        asked, fresh: (N,) which servos were asked in this cycle, and which answered.
        age_s: (N,) s since each servo last answered: 0 where it just did, infinite where it never did.
        alert: (N,) alert bit of the last status packet.
        refusal: (N,) error code of the last status packet (`StatusError`), 0 where the servo obeyed.
        torque: (N,) torque on.
        tripped: (N,) the bus watchdog tripped.
        error: (N,) hardware error bits.
        position: (N,) joint angle, rad.
        velocity: (N,) rad/s.
        current: (N,) A (share of full load where the model measures no current).
        voltage: (N,) V.
        temperature: (N,) deg C.
    """

    asked: Bools
    fresh: Bools
    age_s: Floats
    alert: Bools
    refusal: NDArray[np.uint8]
    torque: Bools
    tripped: Bools
    error: NDArray[np.uint8]
    position: Floats
    velocity: Floats
    current: Floats
    voltage: Floats
    temperature: Floats


class Cycle:
    """Cyclic exchange with the servos of a rig. `method` is how they are read."""

    def __init__(self, servos: Servos) -> None:
        """
        Raises:
            ModelMismatch: servos whose state cannot be gathered in one block.
        """
        self.method: Method = METHODS[0]
        self._servos, rig = servos, servos.rig
        tables = [servos.table(i) for i in range(len(servos))]
        place = np.array(servos.place)
        used = [k for k in range(len(servos.buses)) if (place == k).any()]
        self._members = [np.flatnonzero(place == k) for k in used]
        self._lines = [
            Line(servos.buses[k], tuple(rig.ids[i] for i in members), tuple(tables[i] for i in members))
            for k, members in zip(used, self._members, strict=True)
        ]
        self._data = np.zeros(len(rig.ids), dtype=BLOCK)
        self._status = np.zeros(len(rig.ids), dtype=np.uint8)
        self._answered_s = np.full(len(rig.ids), -np.inf)
        registers = [(current_register(table), "Present Velocity", "Present Input Voltage") for table in tables]
        self._current_unit, self._velocity_unit, self._voltage_unit = np.array(
            [[scale(table, name)[0] for name in names] for table, names in zip(tables, registers, strict=True)]
        ).T
        self._patience_s = max(line.wire_s for line in self._lines) + MARGIN_S
        servos.buses[used[0]].serial.timeout = self._patience_s

    def wire_s(self, bus: Bus) -> float:
        """Time that a whole cycle's bytes take on a port, without waiting, s."""
        return sum(line.wire_s for line in self._lines if line.bus is bus)

    def map_state(self, index: int) -> tuple[int, bytes]:
        """Where the indirect addresses of a servo are, and what they must hold."""
        table = self._servos.table(index)
        return table.indirect_blocks[0].address, state_addresses(table)

    def choose_method(self) -> Method:
        """Find the fastest way of reading that all servos answer.

        Raises:
            BusFault: not even single reads work.
        """
        for self.method in METHODS:
            for _ in range(_TRIES):
                answered = np.zeros(len(self._data), dtype=bool)
                for _ in range(-(-len(answered) // SINGLES_PER_CYCLE) if self.method == METHODS[-1] else 1):
                    answered |= self.exchange(None).fresh
                if answered.all():
                    return self.method
        ports = ", ".join(bus.port for bus in self._servos.buses)
        raise BusFault(f"{ports}: the servos answer pings but no reads of their state")

    def exchange(self, goals: Raw | None) -> Reading:
        """Send goal positions (N,), or none, and read every servo.

        Raises:
            UnsafeCommand: a goal that the register cannot hold.
            PortError: a port went away.
        """
        asked, fresh = np.zeros(len(self._data), dtype=bool), np.zeros(len(self._data), dtype=bool)
        for turn in range(SINGLES_PER_CYCLE if self.method == METHODS[-1] else 1):
            for line, members in zip(self._lines, self._members, strict=True):
                asked[members] |= line.send(self.method, goals[members] if goals is not None and turn == 0 else None)
            deadline = time.perf_counter() + self._patience_s
            for k, (line, members) in enumerate(zip(self._lines, self._members, strict=True)):
                # The first port waits in the kernel; meanwhile the answers of the others gather.
                fresh[members] |= line.receive(self.method, deadline if k else None)
        for line, members in zip(self._lines, self._members, strict=True):
            self._data[members], self._status[members] = line.data, line.status
        return self._reading(asked, fresh)

    def _reading(self, asked: Bools, fresh: Bools) -> Reading:
        data, rig, now = self._data, self._servos.rig, time.perf_counter()
        self._answered_s[fresh] = now
        return Reading(
            asked=asked,
            fresh=fresh,
            age_s=now - self._answered_s,
            alert=(self._status & ALERT) != 0,
            refusal=self._status & np.uint8(CODE),
            torque=data["torque"] != 0,
            tripped=data["watchdog"] == WATCHDOG_TRIPPED,
            error=data["error"].copy(),
            position=rig.to_angles(data["position"].astype(np.int64)),
            velocity=rig.direction * data["velocity"] * self._velocity_unit,
            current=rig.direction * data["current"] * self._current_unit,
            voltage=data["voltage"] * self._voltage_unit,
            temperature=data["temperature"].astype(np.float64),
        )
