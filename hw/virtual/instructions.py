"""What a servo does for an instruction that is for it alone, and the data of its answer.

Source: ROBOTIS e-Manual, "DYNAMIXEL Protocol 2.0", instruction details.
"""

from collections.abc import Callable

from hw.protocol import Instruction, StatusError
from hw.virtual.memory import Refused
from hw.virtual.servo import Servo

_CLEAR_MULTI_TURN = b"\x01\x44\x58\x4c\x22"
_BACKUP_STORE, _BACKUP_RESTORE = b"\x01\x43\x54\x52\x4c", b"\x02\x43\x54\x52\x4c"


def word(data: bytes, at: int) -> int:
    """Two bytes, low one first."""
    return int.from_bytes(data[at : at + 2], "little")


def _ping(servo: Servo, parameters: bytes) -> bytes:
    return servo.read(0, 2) + bytes((servo.get("Firmware Version"),))


def _read(servo: Servo, parameters: bytes) -> bytes:
    if len(parameters) != 4:
        raise Refused(StatusError.DATA_LENGTH)
    return servo.read(word(parameters, 0), word(parameters, 2))


def _write(servo: Servo, parameters: bytes) -> bytes:
    if len(parameters) < 3:
        raise Refused(StatusError.DATA_LENGTH)
    servo.write(word(parameters, 0), parameters[2:])
    return b""


def _reg_write(servo: Servo, parameters: bytes) -> bytes:
    if len(parameters) < 3:
        raise Refused(StatusError.DATA_LENGTH)
    servo.check_write(word(parameters, 0), parameters[2:])
    servo.registered = word(parameters, 0), parameters[2:]
    servo.set("Registered Instruction", 1)
    return b""


def _action(servo: Servo, parameters: bytes) -> bytes:
    if servo.registered is None:
        raise Refused(StatusError.INSTRUCTION)
    (address, data), servo.registered = servo.registered, None
    servo.set("Registered Instruction", 0)
    servo.write(address, data)
    return b""


def _factory_reset(servo: Servo, parameters: bytes) -> bytes:
    keep = {b"\xff": (), b"\x01": ("ID",), b"\x02": ("ID", "Baud Rate")}.get(parameters)
    if keep is None:
        raise Refused(StatusError.DATA_RANGE)
    servo.factory_reset(keep)
    return b""


def _reboot(servo: Servo, parameters: bytes) -> bytes:
    servo.reboot()
    return b""


def _clear(servo: Servo, parameters: bytes) -> bytes:
    if parameters != _CLEAR_MULTI_TURN:
        raise Refused(StatusError.DATA_RANGE)
    servo.clear_turns()
    return b""


def _backup(servo: Servo, parameters: bytes) -> bytes:
    if parameters == _BACKUP_STORE:
        servo.store_backup()
    elif parameters == _BACKUP_RESTORE:
        servo.restore_backup()
    else:
        raise Refused(StatusError.DATA_RANGE)
    return b""


SINGLE: dict[int, Callable[[Servo, bytes], bytes]] = {
    Instruction.PING: _ping,
    Instruction.READ: _read,
    Instruction.WRITE: _write,
    Instruction.REG_WRITE: _reg_write,
    Instruction.ACTION: _action,
    Instruction.FACTORY_RESET: _factory_reset,
    Instruction.REBOOT: _reboot,
    Instruction.CLEAR: _clear,
    Instruction.CONTROL_TABLE_BACKUP: _backup,
}
"""Instruction to what it does with its parameters; returns the data of the answer, or raises Refused."""
