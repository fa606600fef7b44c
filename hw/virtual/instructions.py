"""What the servos of one bus answer to an instruction packet; pure, without port or clock."""

from collections.abc import Callable, Iterable, Iterator
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
from hw.virtual.servo import Refused, Servo

_CLEAR_MULTI_TURN = b"\x01\x44\x58\x4c\x22"
_BACKUP_STORE, _BACKUP_RESTORE = b"\x01\x43\x54\x52\x4c", b"\x02\x43\x54\x52\x4c"
_REBOOT_S = 0.3
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
    """

    def __init__(self, servos: Iterable[Servo], *, unsupported: Iterable[Instruction] = ()) -> None:
        self.servos = {servo.id: servo for servo in servos}
        self.unsupported = frozenset(unsupported)
        self._backups: dict[int, bytes] = {}
        self._unicast: dict[int, Callable[[Servo, bytes], bytes]] = {
            Instruction.PING: self._ping,
            Instruction.READ: self._read,
            Instruction.WRITE: self._write,
            Instruction.REG_WRITE: self._reg_write,
            Instruction.ACTION: self._action,
            Instruction.FACTORY_RESET: self._factory_reset,
            Instruction.REBOOT: self._reboot,
            Instruction.CLEAR: self._clear,
            Instruction.CONTROL_TABLE_BACKUP: self._backup,
        }
        self._group: dict[int, Callable[[bytes], list[Reply]]] = {
            Instruction.SYNC_READ: self._sync_read,
            Instruction.SYNC_WRITE: self._sync_write,
            Instruction.FAST_SYNC_READ: self._fast_sync_read,
            Instruction.BULK_READ: self._bulk_read,
            Instruction.BULK_WRITE: self._bulk_write,
            Instruction.FAST_BULK_READ: self._fast_bulk_read,
        }

    def advance(self, dt: float) -> None:
        """Let `dt` s pass for every servo."""
        for servo in self.servos.values():
            servo.advance(dt)

    def handle(self, packet: Packet) -> list[Reply]:
        """The answers to a packet, in the order in which they appear on the bus."""
        for servo in self.servos.values():
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
        return [] if servo is None or not servo.answering else self._single(servo, packet)

    def _broadcast(self, packet: Packet) -> list[Reply]:
        """A ping is answered in the order of the ids; anything else is done in silence."""
        everything_reset = packet.instruction == Instruction.FACTORY_RESET and packet.parameters == b"\xff"
        if packet.instruction not in self._unicast or everything_reset:
            return []
        replies: list[Reply] = []
        for _, servo in sorted(self.servos.items()):
            if servo.answering:
                replies += self._single(servo, packet)
        return replies if packet.instruction == Instruction.PING else []

    def _single(self, servo: Servo, packet: Packet) -> list[Reply]:
        """Do one instruction and answer as the status return level wants it."""
        identity, level = servo.id, servo.get("Status Return Level")
        delay = servo.return_delay_s
        error, data = StatusError.NONE, b""
        try:
            handler = self._unicast.get(packet.instruction)
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

    # One servo.

    def _ping(self, servo: Servo, parameters: bytes) -> bytes:
        return servo.read(0, 2) + bytes((servo.get("Firmware Version"),))

    def _read(self, servo: Servo, parameters: bytes) -> bytes:
        if len(parameters) != 4:
            raise Refused(StatusError.DATA_LENGTH)
        return servo.read(_word(parameters, 0), _word(parameters, 2))

    def _write(self, servo: Servo, parameters: bytes) -> bytes:
        if len(parameters) < 3:
            raise Refused(StatusError.DATA_LENGTH)
        servo.write(_word(parameters, 0), parameters[2:])
        return b""

    def _reg_write(self, servo: Servo, parameters: bytes) -> bytes:
        if len(parameters) < 3:
            raise Refused(StatusError.DATA_LENGTH)
        servo.check_write(_word(parameters, 0), parameters[2:])
        servo.registered = _word(parameters, 0), parameters[2:]
        servo.set("Registered Instruction", 1)
        return b""

    def _action(self, servo: Servo, parameters: bytes) -> bytes:
        if servo.registered is None:
            raise Refused(StatusError.RESULT_FAIL)
        (address, data), servo.registered = servo.registered, None
        servo.set("Registered Instruction", 0)
        servo.write(address, data)
        return b""

    def _factory_reset(self, servo: Servo, parameters: bytes) -> bytes:
        keep = {b"\xff": (), b"\x01": ("ID",), b"\x02": ("ID", "Baud Rate")}.get(parameters)
        if keep is None:
            raise Refused(StatusError.DATA_RANGE)
        servo.power_up(factory=True, keep=keep)
        return b""

    def _reboot(self, servo: Servo, parameters: bytes) -> bytes:
        servo.reboot(_REBOOT_S)
        return b""

    def _clear(self, servo: Servo, parameters: bytes) -> bytes:
        if parameters != _CLEAR_MULTI_TURN:
            raise Refused(StatusError.DATA_RANGE)
        if servo.get("Moving"):
            raise Refused(StatusError.RESULT_FAIL)
        servo.clear_turns()
        return b""

    def _backup(self, servo: Servo, parameters: bytes) -> bytes:
        if servo.torque_on:
            raise Refused(StatusError.RESULT_FAIL)
        if parameters == _BACKUP_STORE:
            self._backups[servo.id] = bytes(servo.memory)
        elif parameters == _BACKUP_RESTORE and servo.id in self._backups:
            servo.restore(self._backups[servo.id])
        else:
            raise Refused(StatusError.DATA_RANGE)
        return b""

    # Several servos.

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
            if servo is None or not servo.answering or servo.get("Status Return Level") < 1:
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
        address, length = _word(parameters, 0), _word(parameters, 2)
        for start in range(4, len(parameters) - length, length + 1):
            self._write_quietly(parameters[start], address, parameters[start + 1 : start + 1 + length])
        return []

    def _bulk_write(self, parameters: bytes) -> list[Reply]:
        start = 0
        while start + 5 < len(parameters):
            address, length = _word(parameters, start + 1), _word(parameters, start + 3)
            data = parameters[start + 5 : start + 5 + length]
            if len(data) == length:
                self._write_quietly(parameters[start], address, data)
            start += 5 + length
        return []

    def _write_quietly(self, identity: int, address: int, data: bytes) -> None:
        servo = self.servos.get(identity)
        if servo is None or not servo.answering:
            return
        try:
            servo.write(address, data)
        except Refused:
            return  # the servo keeps it in its refusals
        self._reindex(identity, servo)


def _word(data: bytes, at: int) -> int:
    return int.from_bytes(data[at : at + 2], "little")


def _alert(servo: Servo) -> int:
    return ALERT if servo.alert else 0


def _sync_requests(parameters: bytes) -> Iterator[tuple[int, int, int]]:
    """Id, address, length of each servo that a sync read names."""
    address, length = _word(parameters, 0), _word(parameters, 2)
    for identity in parameters[4:]:
        yield identity, address, length


def _bulk_requests(parameters: bytes) -> Iterator[tuple[int, int, int]]:
    for start in range(0, len(parameters) - 4, 5):
        yield parameters[start], _word(parameters, start + 1), _word(parameters, start + 3)
