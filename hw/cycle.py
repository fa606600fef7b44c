"""One control cycle on the bus: goals out with a Sync Write, the state of every servo back in one packet.

Indirect addresses gather what is read into one block of 16 bytes a servo, so that one Fast Sync Read brings torque,
hardware error, watchdog, current, velocity, position, voltage and temperature. Where the firmware lacks Fast Sync
Read, a Sync Read does it; where it lacks that too, a few servos are read in each cycle. The SDK's own group reads
drop the error byte of each servo, so packets are built and read here, and sent through the SDK's port.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from hw.bus import Bus
from hw.protocol import ALERT, BROADCAST, HEADER, Instruction, Packet, PacketReader, crc16, encode
from hw.rig import Raw, Rig
from hw.units import scale
from ros_free_stack.errors import BusFault, UnsafeCommand
from ros_free_stack.messages import Bools, Floats

Method = Literal["fast sync read", "sync read", "single reads"]
METHODS: tuple[Method, ...] = ("fast sync read", "sync read", "single reads")

_WATCHDOG_TRIPPED = 0xFF
_CODE = 0x7F
_BLOCK = (
    ("torque", "Torque Enable", "u1"),
    ("error", "Hardware Error Status", "u1"),
    ("watchdog", "Bus Watchdog", "u1"),
    ("current", "Present Current", "<i2"),
    ("velocity", "Present Velocity", "<i4"),
    ("position", "Present Position", "<i4"),
    ("voltage", "Present Input Voltage", "<u2"),
    ("temperature", "Present Temperature", "u1"),
)
_DATA = np.dtype([(name, kind) for name, _, kind in _BLOCK])
_FAST = np.dtype([("status", "u1"), ("id", "u1"), ("data", _DATA), ("crc", "<u2")])
_FAST_HEAD = 8
_STATUS_OVERHEAD = 11
_TRIES = 5
_MARGIN_S = 4e-3
_SINGLES_PER_CYCLE = 3


@dataclass(frozen=True)
class Reading:
    """The state of N servos after one cycle; a servo that did not answer keeps its last values.

    Attributes:
        asked, fresh: (N,) which servos were asked in this cycle, and which answered.
        alert: (N,) alert bit of the status packet.
        torque: (N,) torque on.
        tripped: (N,) the bus watchdog tripped.
        error: (N,) hardware error bits.
        position: (N,) joint angle, rad.
        velocity: (N,) rad/s.
        current: (N,) A (share of the maximal load where the model measures no current).
        voltage: (N,) V.
        temperature: (N,) deg C.
    """

    asked: Bools
    fresh: Bools
    alert: Bools
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

    def __init__(self, bus: Bus, rig: Rig) -> None:
        self.method: Method = METHODS[0]
        self._bus, self._rig, self._serial = bus, rig, bus.serial
        self._index = {identity: i for i, identity in enumerate(rig.ids)}
        self._data = np.zeros(len(rig.ids), dtype=_DATA)
        self._status = np.zeros(len(rig.ids), dtype=np.uint8)
        self._next_single = 0
        table = rig.table
        self._current_name = "Present Current" if "Present Current" in table else "Present Load"
        self._units = {
            "current": scale(table, self._current_name)[0],
            "velocity": scale(table, "Present Velocity")[0],
            "voltage": scale(table, "Present Input Voltage")[0],
        }
        block = table.indirect_blocks[0] if table.indirect_blocks else None
        if block is None or block.count < _DATA.itemsize:
            raise BusFault(f"{table.model} has no {_DATA.itemsize} indirect addresses to gather its state with")
        self._mapping_address = block.address
        goal = table["Goal Position"]
        self._goal_head = goal.address.to_bytes(2, "little") + goal.size.to_bytes(2, "little")
        self._goals = np.zeros(len(rig.ids), dtype=[("id", "u1"), ("goal", "<i4")])
        self._goals["id"] = rig.ids
        self._span = block.data.to_bytes(2, "little") + _DATA.itemsize.to_bytes(2, "little")
        ids = bytes(rig.ids)
        self._fast_request = encode(Packet(BROADCAST, Instruction.FAST_SYNC_READ, self._span + ids))
        self._sync_request = encode(Packet(BROADCAST, Instruction.SYNC_READ, self._span + ids))
        self._fast_size = _FAST_HEAD + len(ids) * _FAST.itemsize
        self._fast_start = HEADER + bytes((BROADCAST,)) + (self._fast_size - 7).to_bytes(2, "little") + b"\x55"
        wire_s = 10 / bus.baud * (len(self._fast_request) + self._fast_size + len(ids) * 5 + 14)
        self._serial.timeout = wire_s + _MARGIN_S

    @property
    def mapping(self) -> tuple[int, bytes]:
        """Where the indirect addresses go, and what they must hold."""
        table = self._rig.table
        names = (self._current_name if name == "Present Current" else name for _, name, _ in _BLOCK)
        addresses = [a for name in names for a in range(table[name].address, table[name].end)]
        return self._mapping_address, b"".join(a.to_bytes(2, "little") for a in addresses)

    def choose_method(self) -> Method:
        """Find the fastest way of reading that all servos answer.

        Raises:
            BusFault: not even single reads work.
        """
        for self.method in METHODS:
            for _ in range(_TRIES):
                answered = np.zeros(len(self._rig.ids), dtype=bool)
                for _ in range(-(-len(answered) // _SINGLES_PER_CYCLE) if self.method == METHODS[-1] else 1):
                    answered |= self.exchange(None).fresh
                if answered.all():
                    return self.method
        raise BusFault(f"{self._bus.port}: the servos answer pings but no reads of their state")

    def exchange(self, goals: Raw | None) -> Reading:
        """Send goal positions (N,), or none, and read every servo.

        Raises:
            UnsafeCommand: a goal that the register cannot hold.
            PortError: the port went away.
        """
        command = b"" if goals is None else self._goal_packet(goals)
        with self._bus.guarded():
            self._serial.reset_input_buffer()
            if self.method == "fast sync read":
                self._serial.write(command + self._fast_request)
                asked = np.ones(len(self._index), dtype=bool)
                fresh = self._receive_fast()
            elif self.method == "sync read":
                self._serial.write(command + self._sync_request)
                asked = np.ones(len(self._index), dtype=bool)
                fresh = self._receive(len(self._index))
            else:
                asked, fresh = self._single_reads(command)
        return self._reading(asked, fresh)

    def _goal_packet(self, goals: Raw) -> bytes:
        if (np.abs(goals) > np.iinfo(np.int32).max).any():
            raise UnsafeCommand("a goal position does not fit its register")
        self._goals["goal"] = goals
        return encode(Packet(BROADCAST, Instruction.SYNC_WRITE, self._goal_head + self._goals.tobytes()))

    def _receive_fast(self) -> Bools:
        data = self._serial.read(self._fast_size)
        start = data.find(self._fast_start)
        if start > 0:
            data = data[start:] + self._serial.read(start)
        fresh = np.zeros(len(self._index), dtype=bool)
        if start < 0:
            return fresh
        count = self._intact(data)
        blocks = np.frombuffer(data, dtype=_FAST, count=count, offset=_FAST_HEAD)
        if not np.array_equal(blocks["id"], self._goals["id"][:count]):
            return fresh
        self._data[:count] = blocks["data"]
        self._status[:count] = blocks["status"]
        fresh[:count] = (blocks["status"] & _CODE) == 0
        return fresh

    def _intact(self, data: bytes) -> int:
        """How many servos' blocks arrived: each block's CRC covers all bytes before it."""
        if len(data) == self._fast_size and crc16(data[:-2]) == int.from_bytes(data[-2:], "little"):
            return len(self._index)
        count = 0
        for end in range(_FAST_HEAD + _FAST.itemsize, len(data) + 1, _FAST.itemsize):
            if crc16(data[: end - 2]) != int.from_bytes(data[end - 2 : end], "little"):
                break
            count += 1
        return count

    def _single_reads(self, command: bytes) -> tuple[Bools, Bools]:
        """Goals to all, then reads of the next few servos in turn."""
        count = len(self._index)
        asked, fresh = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        for _ in range(min(_SINGLES_PER_CYCLE, count)):
            i = self._next_single
            self._next_single = (i + 1) % count
            self._serial.write(command + encode(Packet(self._rig.ids[i], Instruction.READ, self._span)))
            command = b""
            asked[i] = True
            fresh |= self._receive(1)
        return asked, fresh

    def _receive(self, count: int) -> Bools:
        """Take up to `count` status packets, each with one servo's block."""
        reader, seen = PacketReader(), 0
        fresh = np.zeros(len(self._index), dtype=bool)
        wanted = count * (_DATA.itemsize + _STATUS_OVERHEAD)
        while seen < count:
            data = self._serial.read(max(wanted, 1))
            if not data:
                break
            wanted -= len(data)
            for packet in reader.feed(data):
                i = self._index.get(packet.id)
                whole = len(packet.parameters) == 1 + _DATA.itemsize and packet.instruction == Instruction.STATUS
                if i is not None and whole:
                    seen += 1
                    self._status[i] = packet.parameters[0]
                    self._data[i] = np.frombuffer(packet.parameters, dtype=_DATA, offset=1)[0]
                    fresh[i] = packet.parameters[0] & _CODE == 0
        return fresh

    def _reading(self, asked: Bools, fresh: Bools) -> Reading:
        data, rig, units = self._data, self._rig, self._units
        return Reading(
            asked=asked,
            fresh=fresh,
            alert=(self._status & ALERT) != 0,
            torque=data["torque"] != 0,
            tripped=data["watchdog"] == _WATCHDOG_TRIPPED,
            error=data["error"].copy(),
            position=rig.to_angles(data["position"].astype(np.int64)),
            velocity=rig.direction * data["velocity"] * units["velocity"],
            current=rig.direction * data["current"] * units["current"],
            voltage=data["voltage"] * units["voltage"],
            temperature=data["temperature"].astype(np.float64),
        )
