"""Dynamixel Protocol 2.0 packets: build, stuff, check, and find them in a stream of bytes.

A packet is `FF FF FD 00 | id | length (2) | instruction | parameters | CRC-16 (2)`, little endian; `length` counts
what follows it. `FF FF FD` inside the parameters is stuffed to `FF FF FD FD`, so that the header stays unique.
Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0".
"""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cache

import numpy as np
from numpy.typing import NDArray

HEADER = b"\xff\xff\xfd\x00"
BROADCAST = 0xFE
ALERT = 0x80
"""Bit of a status packet's error byte: the servo's hardware error status is not zero."""
HEADER_SIZE = 7
MAX_LENGTH = 1024
_STUFFED = b"\xff\xff\xfd"
_CHUNK = 512


class Instruction(IntEnum):
    """Instruction byte."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    CONTROL_TABLE_BACKUP = 0x20
    STATUS = 0x55
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93
    FAST_BULK_READ = 0x9A


class StatusError(IntEnum):
    """Low seven bits of a status packet's error byte."""

    NONE = 0
    RESULT_FAIL = 1
    INSTRUCTION = 2
    CRC = 3
    DATA_RANGE = 4
    DATA_LENGTH = 5
    DATA_LIMIT = 6
    ACCESS = 7


@dataclass(frozen=True)
class Packet:
    """One packet without header, stuffing and CRC; a status packet's first parameter is its error byte."""

    id: int
    instruction: int
    parameters: bytes = b""


@cache
def _crc_table() -> tuple[NDArray[np.uint16], NDArray[np.intp]]:
    """Contribution of each byte value at each distance from the end of a message to its CRC, and where to look.

    Returns:
        (512 * 256,) contributions, and (512,) the offset of each distance, the farthest first.

    The CRC (polynomial 0x8005, initial value 0, most significant bit first) is linear over GF(2), so the CRC of a
    message is the exclusive or of its bytes' contributions: one numpy gather in place of a loop over bytes.
    """
    row = np.arange(256, dtype=np.uint32) << 8
    for _ in range(8):
        row = ((row << 1) ^ np.where(row & 0x8000, 0x8005, 0)) & 0xFFFF
    table = np.empty((_CHUNK, 256), dtype=np.uint16)
    table[0] = row
    for distance in range(1, _CHUNK):
        previous = table[distance - 1].astype(np.uint32)
        table[distance] = ((previous << 8) & 0xFFFF) ^ row[previous >> 8]
    return table.ravel(), np.arange(_CHUNK - 1, -1, -1) * 256


def crc16(data: bytes | bytearray | memoryview, initial: int = 0) -> int:
    """CRC-16 of `data`, continuing from `initial`."""
    values = np.frombuffer(data, dtype=np.uint8)
    contributions, offsets = _crc_table()
    crc = initial
    for start in range(0, len(values), _CHUNK):
        chunk = values[start : start + _CHUNK]
        n = len(chunk)
        if crc:
            # The running CRC acts as if it were added to the first two bytes that follow.
            head = np.array([crc >> 8, crc & 0xFF], dtype=np.uint8)[:n]
            chunk = chunk.copy()
            chunk[: len(head)] ^= head
            rest = (crc << 8) & 0xFFFF if n == 1 else 0
        else:
            rest = 0
        crc = int(np.bitwise_xor.reduce(contributions.take(offsets[_CHUNK - n :] + chunk))) ^ rest
    return crc


def stuff(body: bytes) -> bytes:
    """Insert `FD` after each `FF FF FD` of the instruction and its parameters."""
    return body.replace(_STUFFED, _STUFFED + b"\xfd")


def unstuff(body: bytes) -> bytes:
    """Inverse of `stuff`."""
    return body.replace(_STUFFED + b"\xfd", _STUFFED)


def with_crc(data: bytes) -> bytes:
    """Append the CRC, low byte first."""
    return data + crc16(data).to_bytes(2, "little")


def encode(packet: Packet) -> bytes:
    """The bytes of a packet on the wire."""
    body = stuff(bytes((packet.instruction,)) + packet.parameters)
    return with_crc(HEADER + bytes((packet.id,)) + (len(body) + 2).to_bytes(2, "little") + body)


def encode_status(servo_id: int, error: int, data: bytes = b"") -> bytes:
    """The bytes of a status packet."""
    return encode(Packet(servo_id, Instruction.STATUS, bytes((error,)) + data))


class PacketReader:
    """Finds packets in a stream that may be cut anywhere and hold noise.

    `bad_crc` counts the packets that had to be thrown away for their CRC.
    """

    def __init__(self) -> None:
        self._buffer = bytearray()
        self.bad_crc = 0

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Take more bytes and yield every packet that they complete."""
        self._buffer += data
        while True:
            packet, used = self._next()
            del self._buffer[:used]
            if packet is not None:
                yield packet
            elif not used:
                return

    def _next(self) -> tuple[Packet | None, int]:
        """The packet at the front, if complete, and how many bytes are done with (0: wait for more)."""
        buffer = self._buffer
        start = buffer.find(HEADER)
        if start != 0:
            # Skip what comes before a header, or all but a tail that may be the beginning of one.
            return None, start if start > 0 else max(0, len(buffer) - len(HEADER) + 1)
        length = int.from_bytes(buffer[5:7], "little") if len(buffer) >= HEADER_SIZE else 3
        end = HEADER_SIZE + length
        if not 3 <= length <= MAX_LENGTH:
            return None, len(HEADER)
        if len(buffer) < end:
            return None, 0
        if crc16(bytes(buffer[: end - 2])) != int.from_bytes(buffer[end - 2 : end], "little"):
            # A wrong length would swallow what follows: look again just after this header.
            self.bad_crc += 1
            return None, len(HEADER)
        body = unstuff(bytes(buffer[HEADER_SIZE : end - 2]))
        return Packet(buffer[4], body[0], body[1:]), end
