"""One port's share of the control cycle: goals out with a Sync Write, the state of every servo back.

Indirect addresses gather what is read into one block of 16 bytes a servo, so that one Fast Sync Read brings torque,
hardware error, watchdog, current, velocity, position, voltage and temperature. Where the firmware lacks Fast Sync
Read, a Sync Read does it; where it lacks that too, a few servos are read in each cycle. The SDK's own group reads
drop the error byte of each servo, so packets are built and read here, and sent through the SDK's port.
"""

import time
from typing import Literal

import numpy as np

from hw.bus import Bus
from hw.protocol import BROADCAST, HEADER, Instruction, Packet, PacketReader, crc16, encode
from hw.registers import ControlTable
from hw.rig import Raw
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import Bools

Method = Literal["fast sync read", "sync read", "single reads"]
METHODS: tuple[Method, ...] = ("fast sync read", "sync read", "single reads")

SINGLES_PER_CYCLE = 3
CODE = 0x7F
"""Bits of a status packet's error byte that say why an instruction was refused."""
WATCHDOG_TRIPPED = 0xFF
"""What the Bus Watchdog register holds once it has stopped the servo."""
MARGIN_S = 4e-3
"""How much longer than the wire takes an answer may take."""

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
BLOCK = np.dtype([(name, kind) for name, _, kind in _BLOCK])
_FAST = np.dtype([("status", "u1"), ("id", "u1"), ("data", BLOCK), ("crc", "<u2")])
_FAST_HEAD = len(HEADER) + 4
_STATUS_OVERHEAD = 11
_POLL_S = 5e-5


def state_addresses(table: ControlTable) -> bytes:
    """What the first indirect addresses of a servo must hold, so that its state is one block.

    Raises:
        ModelMismatch: the model has no room for it, or not these registers.
    """
    blocks = table.indirect_blocks
    names = (current_register(table) if name == "Present Current" else name for _, name, _ in _BLOCK)
    if not blocks or blocks[0].count < BLOCK.itemsize:
        raise ModelMismatch(f"{table.model} has no {BLOCK.itemsize} indirect addresses to gather its state with")
    addresses = [address for name in names for address in range(table[name].address, table[name].end)]
    return b"".join(address.to_bytes(2, "little") for address in addresses)


def current_register(table: ControlTable) -> str:
    """Where a model says how hard its motor works: current, or else the share of full load."""
    return "Present Current" if "Present Current" in table else "Present Load"


class Line:
    """Cyclic exchange with the servos of one port, which may be of several models with one layout.

    Attributes:
        bus: the port.
        data: (n,) the last block of each servo.
        status: (n,) the error byte of each servo's last status packet.
        wire_s: time that a whole cycle's bytes take.
    """

    def __init__(self, bus: Bus, ids: tuple[int, ...], tables: tuple[ControlTable, ...]) -> None:
        """
        Raises:
            ModelMismatch: a model whose layout does not fit the block, or that of the others.
        """
        self.bus, self._serial, self._ids = bus, bus.serial, ids
        self._index = {identity: i for i, identity in enumerate(ids)}
        self.data = np.zeros(len(ids), dtype=BLOCK)
        self.status = np.zeros(len(ids), dtype=np.uint8)
        self._next_single = 0
        self._asked: list[int] = []
        goal, block = _layout(tables)
        self._goal_head = goal[0].to_bytes(2, "little") + goal[1].to_bytes(2, "little")
        self._goals = np.zeros(len(ids), dtype=[("id", "u1"), ("goal", "<i4")])
        self._goals["id"] = ids
        self._span = block.to_bytes(2, "little") + BLOCK.itemsize.to_bytes(2, "little")
        self._fast_request = encode(Packet(BROADCAST, Instruction.FAST_SYNC_READ, self._span + bytes(ids)))
        self._sync_request = encode(Packet(BROADCAST, Instruction.SYNC_READ, self._span + bytes(ids)))
        self._fast_size = _FAST_HEAD + len(ids) * _FAST.itemsize
        self._fast_start = HEADER + bytes((BROADCAST,)) + (self._fast_size - 7).to_bytes(2, "little") + b"\x55"
        self.wire_s = 10 / bus.baud * (len(self._fast_request) + self._fast_size + len(ids) * 5 + 14)

    def send(self, method: Method, goals: Raw | None) -> Bools:
        """Send goal positions (n,), or none, and ask for states; return (n,) who was asked."""
        command = b"" if goals is None else self._goal_packet(goals)
        asked = np.ones(len(self._ids), dtype=bool)
        if method == "fast sync read":
            request = self._fast_request
        elif method == "sync read":
            request = self._sync_request
        else:
            i = self._next_single
            self._next_single = (i + 1) % len(self._ids)
            request = encode(Packet(self._ids[i], Instruction.READ, self._span))
            asked[:] = False
            asked[i] = True
        with self.bus.guarded():
            self._serial.reset_input_buffer()
            self._serial.write(command + request)
        return asked

    def receive(self, method: Method, deadline: float | None) -> Bools:
        """Take the answers to `send`; return (n,) who answered.

        `deadline` is a time of `perf_counter`; None waits for as long as the port is set to.
        """
        with self.bus.guarded():
            if method == "fast sync read":
                return self._receive_fast(deadline)
            return self._receive(len(self._ids) if method == "sync read" else 1, deadline)

    def _goal_packet(self, goals: Raw) -> bytes:
        if (np.abs(goals) > np.iinfo(np.int32).max).any():
            raise UnsafeCommand("a goal position does not fit its register")
        self._goals["goal"] = goals
        return encode(Packet(BROADCAST, Instruction.SYNC_WRITE, self._goal_head + self._goals.tobytes()))

    def _read(self, count: int, deadline: float | None) -> bytes:
        if deadline is not None:
            while self._serial.in_waiting < count and time.perf_counter() < deadline:
                time.sleep(_POLL_S)
            count = min(count, self._serial.in_waiting)
        return self._serial.read(count)

    def _receive_fast(self, deadline: float | None) -> Bools:
        data = self._read(self._fast_size, deadline)
        start = data.find(self._fast_start)
        if start > 0:
            data = data[start:] + self._read(start, deadline)
        fresh = np.zeros(len(self._ids), dtype=bool)
        if start < 0:
            return fresh
        count = self._intact(data)
        blocks = np.frombuffer(data, dtype=_FAST, count=count, offset=_FAST_HEAD)
        if not np.array_equal(blocks["id"], self._goals["id"][:count]):
            return fresh
        self.status[:count] = blocks["status"]
        fresh[:count] = (blocks["status"] & CODE) == 0
        self.data[fresh] = blocks["data"][fresh[:count]]
        return fresh

    def _intact(self, data: bytes) -> int:
        """How many servos' blocks arrived: each block's CRC covers all bytes before it."""
        if len(data) == self._fast_size and crc16(data[:-2]) == int.from_bytes(data[-2:], "little"):
            return len(self._ids)
        count = 0
        for end in range(_FAST_HEAD + _FAST.itemsize, len(data) + 1, _FAST.itemsize):
            if crc16(data[: end - 2]) != int.from_bytes(data[end - 2 : end], "little"):
                break
            count += 1
        return count

    def _receive(self, count: int, deadline: float | None) -> Bools:
        """Take up to `count` status packets, each with one servo's block, or with an error code and none."""
        reader, seen = PacketReader(), 0
        fresh = np.zeros(len(self._ids), dtype=bool)
        wanted = count * (BLOCK.itemsize + _STATUS_OVERHEAD)
        while seen < count:
            data = self._read(max(wanted, 1), deadline)
            if not data:
                break
            wanted -= len(data)
            for packet in reader.feed(data):
                i = self._index.get(packet.id)
                if i is None or packet.instruction != Instruction.STATUS or not packet.parameters:
                    continue
                seen += 1
                self.status[i] = packet.parameters[0]
                if packet.parameters[0] & CODE == 0 and len(packet.parameters) == 1 + BLOCK.itemsize:
                    self.data[i] = np.frombuffer(packet.parameters, dtype=BLOCK, offset=1)[0]
                    fresh[i] = True
        return fresh


def _layout(tables: tuple[ControlTable, ...]) -> tuple[tuple[int, int], int]:
    """Address and size of the goal position, and where the block begins: the same for all servos of a port."""
    found: dict[tuple[tuple[int, int], int], str] = {}
    for table in tables:
        state_addresses(table)
        goal = table["Goal Position"]
        found.setdefault(((goal.address, goal.size), table.indirect_blocks[0].data), table.model)
    if len(found) > 1:
        raise ModelMismatch(f"{' and '.join(found.values())} have different layouts: give each a port of its own")
    return next(iter(found))
