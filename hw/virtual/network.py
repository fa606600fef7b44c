"""What the servos of one bus answer to an instruction packet; pure, without port or clock."""

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass

from hw.protocol import (
    ALERT,
    BROADCAST,
    HEADER,
    MAX_LENGTH,
    Instruction,
    Packet,
    StatusError,
    crc16,
    encode_status,
)
from hw.virtual.instructions import SINGLE, word
from hw.virtual.memory import Refused
from hw.virtual.servo import STEP_S, Servo
from hw.virtual.world import World, move_together

_NO_ID = 253
_ANSWERED_FROM: dict[int, int] = {Instruction.PING: 0, Instruction.READ: 1}
"""Lowest status return level at which an instruction is answered; 2 for all others."""


@dataclass(frozen=True)
class Reply:
    """One stretch of bytes from one servo (or, for a fast read, from several)."""

    data: bytes
    delay_s: float


class Network:
    """The servos on one bus, by id.

    `unsupported` holds instructions that the firmware does not know, as older firmware does not know the fast reads.
    In a `world` the servos' torques move one mechanism; else each horn turns alone. Where a `rate` (bits a second) is
    set, only the servos that are set to it hear.
    """

    def __init__(
        self, servos: Iterable[Servo], *, unsupported: Iterable[Instruction] = (), world: World | None = None
    ) -> None:
        self.servos = {servo.id: servo for servo in servos}
        self.unsupported = frozenset(unsupported)
        self.world = world
        self.rate: int | None = None
        self._group: dict[int, Callable[[bytes], list[Reply]]] = {
            Instruction.SYNC_READ: self._sync_read,
            Instruction.SYNC_WRITE: self._sync_write,
            Instruction.FAST_SYNC_READ: self._fast_sync_read,
            Instruction.BULK_READ: self._bulk_read,
            Instruction.BULK_WRITE: self._bulk_write,
            Instruction.FAST_BULK_READ: self._fast_bulk_read,
        }

    def advance(self, dt: float) -> None:
        """Let `dt` s pass for every servo, alone or in the world."""
        servos = list(self.servos.values())
        if self.world is None:
            for servo in servos:
                servo.advance(dt)
            return
        for servo in servos:
            servo.pass_time(dt)
        steps = math.ceil(dt / STEP_S - 1e-9)
        for _ in range(steps):
            move_together(servos, self.world, dt / steps)
        for servo in servos:
            servo.sense(dt)

    def handle(self, packet: Packet) -> list[Reply]:
        """The answers to a packet, in the order in which they appear on the bus."""
        for servo in self.servos.values():
            if self._hears(servo):
                servo.hear()
        if packet.instruction == Instruction.STATUS:
            return []
        if packet.instruction in self._group and packet.id == BROADCAST:
            if packet.instruction in self.unsupported:
                return []
            return self._group[packet.instruction](packet.parameters)
        if packet.id == BROADCAST:
            return self._broadcast(packet)
        servo = self.servos.get(packet.id)
        replies = [] if servo is None or not self._hears(servo) else self._single(servo, packet)
        for follower in self._followers(packet.id):
            self._follow(follower, packet)
        return replies

    def complain(self, identity: int) -> list[Reply]:
        """The answer to a packet for one servo whose CRC was wrong."""
        servo = self.servos.get(identity)
        if servo is None or not self._hears(servo) or servo.get("Status Return Level") < 2:
            return []
        return [Reply(encode_status(identity, StatusError.CRC | _alert(servo)), servo.return_delay_s)]

    def _hears(self, servo: Servo) -> bool:
        return servo.answering and (self.rate is None or servo.baud == self.rate)

    def _followers(self, identity: int) -> list[Servo]:
        """The servos that have this for their secondary id; their own id comes first."""
        if identity >= _NO_ID:
            return []
        servos = [servo for servo in self.servos.values() if servo.id != identity and self._hears(servo)]
        name = "Secondary(Shadow) ID"
        return [servo for servo in servos if name in servo.table and servo.get(name) == identity]

    def _follow(self, servo: Servo, packet: Packet) -> None:
        """What a secondary id may do: write to RAM, in silence."""
        if packet.instruction == Instruction.WRITE and len(packet.parameters) >= 3:
            with suppress(Refused):
                servo.write(word(packet.parameters, 0), packet.parameters[2:], ram_only=True)

    def _broadcast(self, packet: Packet) -> list[Reply]:
        """A ping is answered in the order of the ids; anything else is done in silence."""
        everything_reset = packet.instruction == Instruction.FACTORY_RESET and packet.parameters == b"\xff"
        if packet.instruction not in SINGLE or everything_reset:
            return []
        replies: list[Reply] = []
        for _, servo in sorted(self.servos.items()):
            if self._hears(servo):
                replies += self._single(servo, packet)
        return replies if packet.instruction == Instruction.PING else []

    def _single(self, servo: Servo, packet: Packet) -> list[Reply]:
        """Do one instruction and answer as the status return level wants it."""
        identity, level = servo.id, servo.get("Status Return Level")
        delay = servo.return_delay_s
        error, data = StatusError.NONE, b""
        try:
            handler = SINGLE.get(packet.instruction)
            if handler is None or packet.instruction in self.unsupported:
                raise Refused(StatusError.INSTRUCTION)
            data = handler(servo, packet.parameters)
        except Refused as refusal:
            error = refusal.code
        self._reindex(identity, servo)
        if level < _ANSWERED_FROM.get(packet.instruction, 2):
            return []
        return [Reply(encode_status(identity, error | _alert(servo), data), delay)]

    def _reindex(self, identity: int, servo: Servo) -> None:
        if servo.id != identity:
            del self.servos[identity]
            self.servos[servo.id] = servo

    def _sync_read(self, parameters: bytes) -> list[Reply]:
        return self._statuses(_sync_requests(parameters))

    def _bulk_read(self, parameters: bytes) -> list[Reply]:
        return self._statuses(_bulk_requests(parameters))

    def _fast_sync_read(self, parameters: bytes) -> list[Reply]:
        return self._one_status(list(_sync_requests(parameters)))

    def _fast_bulk_read(self, parameters: bytes) -> list[Reply]:
        return self._one_status(list(_bulk_requests(parameters)))

    def _blocks(self, requests: Iterable[tuple[int, int, int]]) -> Iterator[tuple[Servo, int, bytes]]:
        """Servo, error byte and data of each request. Each waits for the one before it: a silent servo ends it."""
        for identity, address, length in requests:
            servo = self.servos.get(identity)
            if servo is None or not self._hears(servo) or servo.get("Status Return Level") < 1:
                return
            try:
                yield servo, _alert(servo), servo.read(address, length)
            except Refused as refusal:
                yield servo, refusal.code | _alert(servo), bytes(min(length, MAX_LENGTH))

    def _statuses(self, requests: Iterable[tuple[int, int, int]]) -> list[Reply]:
        return [
            Reply(encode_status(servo.id, error, data), servo.return_delay_s)
            for servo, error, data in self._blocks(requests)
        ]

    def _one_status(self, requests: list[tuple[int, int, int]]) -> list[Reply]:
        """One status packet to which each servo adds error, id, data and the CRC of everything up to there."""
        length = 1 + sum(4 + size for _, _, size in requests)
        blocks = list(self._blocks(requests))
        if not blocks or length > MAX_LENGTH:
            return []
        packet = bytearray(HEADER + bytes((BROADCAST,)) + length.to_bytes(2, "little") + bytes((Instruction.STATUS,)))
        crc, done = 0, 0
        for servo, error, data in blocks:
            packet += bytes((error, servo.id)) + data
            crc = crc16(bytes(packet[done:]), crc)
            done = len(packet)
            packet += crc.to_bytes(2, "little")
        return [Reply(bytes(packet), blocks[0][0].return_delay_s)]

    def _sync_write(self, parameters: bytes) -> list[Reply]:
        if len(parameters) < 5:
            return []
        address, length = word(parameters, 0), word(parameters, 2)
        for start in range(4, len(parameters) - length, length + 1):
            self._write_quietly(parameters[start], address, parameters[start + 1 : start + 1 + length])
        return []

    def _bulk_write(self, parameters: bytes) -> list[Reply]:
        start = 0
        while start + 5 < len(parameters):
            address, length = word(parameters, start + 1), word(parameters, start + 3)
            data = parameters[start + 5 : start + 5 + length]
            if len(data) == length:
                self._write_quietly(parameters[start], address, data)
            start += 5 + length
        return []

    def _write_quietly(self, identity: int, address: int, data: bytes) -> None:
        servo = self.servos.get(identity)
        if servo is None or not self._hears(servo):
            return
        with suppress(Refused):  # the servo keeps it in its refusals
            servo.write(address, data)
        self._reindex(identity, servo)


def _alert(servo: Servo) -> int:
    return ALERT if servo.alert else 0


def _sync_requests(parameters: bytes) -> Iterator[tuple[int, int, int]]:
    """Id, address, length of each servo that a sync read names."""
    address, length = word(parameters, 0), word(parameters, 2)
    for identity in parameters[4:]:
        yield identity, address, length


def _bulk_requests(parameters: bytes) -> Iterator[tuple[int, int, int]]:
    for start in range(0, len(parameters) - 4, 5):
        yield parameters[start], word(parameters, start + 1), word(parameters, start + 3)
