"""What the servos of one bus answer to an instruction packet; pure, without port or clock."""

import math
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import reduce
from operator import and_

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
from hw.virtual.board import Board
from hw.virtual.instructions import SINGLE, word
from hw.virtual.memory import Refused
from hw.virtual.servo import STEP_S, Servo
from hw.virtual.world import World, move_together

_NO_ID = 253
_READS, _ALL = 1, 2
_ANSWERED_FROM: dict[int, int] = {Instruction.PING: 0, Instruction.READ: _READS}
"""Lowest status return level at which an instruction is answered; 2 for all others."""


@dataclass(frozen=True)
class Reply:
    """One stretch of bytes from one servo (or, for a fast read, from several)."""

    data: bytes
    delay_s: float


Block = tuple[Servo | Board, int, bytes]
"""Who was read, its error byte, its data."""


class Network:
    """The servos on one bus, by id.

    `unsupported` holds instructions that the firmware does not know, as older firmware does not know the fast reads.
    Several servos may have one id, and then speak at once. A `board` between battery and servos answers to its own.
    In a `world` the servos' torques move one mechanism; else each horn turns alone. Where a `rate` (bits a second) is
    set, only the servos that are set to it hear.
    """

    def __init__(
        self,
        servos: Iterable[Servo],
        *,
        unsupported: Iterable[Instruction] = (),
        world: World | None = None,
        board: Board | None = None,
    ) -> None:
        self._servos, self.board = list(servos), board
        self._index()
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

    @property
    def servos(self) -> dict[int, Servo]:
        """Id to servo; of several with one id the first."""
        return {identity: nodes[0] for identity, nodes in self._nodes.items() if isinstance(nodes[0], Servo)}

    @property
    def all_servos(self) -> tuple[Servo, ...]:
        """Every servo, also those that share an id."""
        return tuple(self._servos)

    def add(self, servo: Servo) -> None:
        """Put one more servo on the bus, whatever its id."""
        self._servos.append(servo)
        self._index()

    def _index(self) -> None:
        """Who answers to which id."""
        self._nodes: dict[int, list[Servo | Board]] = {}
        for node in (*self._servos, *([self.board] if self.board else [])):
            self._nodes.setdefault(node.id, []).append(node)

    def _at(self, identity: int) -> list[Servo | Board]:
        """Who hears an instruction for an id."""
        return [node for node in self._nodes.get(identity, ()) if self._hears(node)]

    def advance(self, dt: float) -> None:
        """Let `dt` s pass for every servo, alone or in the world."""
        servos = self._servos
        if self.board is not None:
            self.board.advance(dt, servos)
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
        for servo in self._servos:
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
        replies = _collide([self._single(node, packet) for node in self._at(packet.id)])
        for follower in self._followers(packet.id):
            self._follow(follower, packet)
        return replies

    def complain(self, identity: int) -> list[Reply]:
        """The answer to a packet for one servo whose CRC was wrong."""
        nodes = [node for node in self._at(identity) if node.level >= _ALL]
        return _collide(
            [[Reply(encode_status(identity, StatusError.CRC | _alert(node)), node.return_delay_s)] for node in nodes]
        )

    def _hears(self, node: Servo | Board) -> bool:
        return node.answering and (self.rate is None or node.baud == self.rate)

    def _followers(self, identity: int) -> list[Servo]:
        """The servos that have this for their secondary id; their own id comes first."""
        if identity >= _NO_ID:
            return []
        servos = [servo for servo in self._servos if servo.id != identity and self._hears(servo)]
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
        for identity in sorted(self._nodes):
            nodes = self._at(identity)
            # Only a ping is for the board too: on a real one nothing else may be told to all.
            told = nodes if packet.instruction == Instruction.PING else [n for n in nodes if isinstance(n, Servo)]
            replies += _collide([self._single(node, packet) for node in told])
        return replies if packet.instruction == Instruction.PING else []

    def _single(self, node: Servo | Board, packet: Packet) -> list[Reply]:
        """Do one instruction and answer as the status return level wants it."""
        identity, level = node.id, node.level
        delay = node.return_delay_s
        error, data = StatusError.NONE, b""
        try:
            if packet.instruction in self.unsupported:
                raise Refused(StatusError.INSTRUCTION)
            data = self._do(node, packet)
        except Refused as refusal:
            error = refusal.code
        self._reindex(identity, node)
        if level < _ANSWERED_FROM.get(packet.instruction, _ALL):
            return []
        return [Reply(encode_status(identity, error | _alert(node), data), delay)]

    def _do(self, node: Servo | Board, packet: Packet) -> bytes:
        if isinstance(node, Board):
            return node.do(packet, self._servos)
        handler = SINGLE.get(packet.instruction)
        if handler is None:
            raise Refused(StatusError.INSTRUCTION)
        return handler(node, packet.parameters)

    def _reindex(self, identity: int, node: Servo | Board) -> None:
        if node.id != identity:
            self._index()

    def _sync_read(self, parameters: bytes) -> list[Reply]:
        return self._statuses(_sync_requests(parameters))

    def _bulk_read(self, parameters: bytes) -> list[Reply]:
        return self._statuses(_bulk_requests(parameters))

    def _fast_sync_read(self, parameters: bytes) -> list[Reply]:
        return self._one_status(list(_sync_requests(parameters)))

    def _fast_bulk_read(self, parameters: bytes) -> list[Reply]:
        return self._one_status(list(_bulk_requests(parameters)))

    def _blocks(self, requests: Iterable[tuple[int, int, int]]) -> Iterator[list[Block]]:
        """What each request finds. Each waits for the one before it: a silent servo ends it."""
        for identity, address, length in requests:
            nodes = [node for node in self._at(identity) if node.level >= _READS]
            if not nodes:
                return
            yield [_block(node, address, length) for node in nodes]

    def _statuses(self, requests: Iterable[tuple[int, int, int]]) -> list[Reply]:
        return [
            reply
            for blocks in self._blocks(requests)
            for reply in _collide(
                [[Reply(encode_status(node.id, error, data), node.return_delay_s)] for node, error, data in blocks]
            )
        ]

    def _one_status(self, requests: list[tuple[int, int, int]]) -> list[Reply]:
        """One status packet to which each servo adds error, id, data and the CRC of everything up to there."""
        length = 1 + sum(4 + size for _, _, size in requests)
        blocks = list(self._blocks(requests))
        if not blocks or length > MAX_LENGTH:
            return []
        packet = bytearray(HEADER + bytes((BROADCAST,)) + length.to_bytes(2, "little") + bytes((Instruction.STATUS,)))
        crc, done = 0, 0
        for group in blocks:
            voices: list[bytes] = []
            for node, error, data in group:
                spoken = bytes((error, node.id)) + data
                voices.append(spoken + crc16(bytes(packet[done:]) + spoken, crc).to_bytes(2, "little"))
            packet += _together(voices)
            crc = crc16(bytes(packet[done:-2]), crc)
            done = len(packet) - 2
        return [Reply(bytes(packet), blocks[0][0][0].return_delay_s)]

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
        for node in self._at(identity):
            with suppress(Refused):  # the servo keeps it in its refusals
                if isinstance(node, Board):
                    node.write(address, data, self._servos)
                else:
                    node.write(address, data)
            self._reindex(identity, node)


def _alert(node: Servo | Board) -> int:
    return ALERT if node.alert else 0


def _block(node: Servo | Board, address: int, length: int) -> Block:
    """What a group read finds at one servo."""
    try:
        return node, _alert(node), node.read(address, length)
    except Refused as refusal:
        return node, refusal.code | _alert(node), bytes(min(length, MAX_LENGTH))


def _collide(answers: list[list[Reply]]) -> list[Reply]:
    """What is on the wire when servos of one id answer at once; equal answers fall together unnoticed."""
    spoken = [replies[0] for replies in answers if replies]
    if len(spoken) < 2:
        return spoken
    return [Reply(_together([reply.data for reply in spoken]), max(reply.delay_s for reply in spoken))]


def _together(voices: list[bytes]) -> bytes:
    """Bytes of speakers at once: a line that one of them pulls low is low."""
    length = max(map(len, voices))
    return bytes(reduce(and_, column) for column in zip(*(v.ljust(length, b"\xff") for v in voices), strict=True))


def _sync_requests(parameters: bytes) -> Iterator[tuple[int, int, int]]:
    """Id, address, length of each servo that a sync read names."""
    address, length = word(parameters, 0), word(parameters, 2)
    for identity in parameters[4:]:
        yield identity, address, length


def _bulk_requests(parameters: bytes) -> Iterator[tuple[int, int, int]]:
    for start in range(0, len(parameters) - 4, 5):
        yield parameters[start], word(parameters, start + 1), word(parameters, start + 3)
