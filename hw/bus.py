"""One serial port with Dynamixel servos, through the official SDK: ping, read and write by register name, reboot."""

import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import serial
from dynamixel_sdk import COMM_RX_CORRUPT, COMM_SUCCESS, PortHandler, Protocol2PacketHandler
from dynamixel_sdk.protocol2_packet_handler import PKT_ID, PKT_INSTRUCTION, PKT_LENGTH_L, PKT_PARAMETER0

from hw.port import claimed, keep_out_others, lower_latency, unopened
from hw.protocol import ALERT, BROADCAST, Instruction, Packet, StatusError, encode
from hw.registers import ControlTable, model_name
from ros_free_stack.errors import BusFault, InvalidOption, LostServo, PortError, UnknownName

# pyserial lets TypeError out where the descriptor was closed, and termios.error where the device hung up.
_PORT_ERRORS: tuple[type[Exception], ...] = (serial.SerialException, OSError, TypeError)
if sys.platform != "win32":
    import termios

    _PORT_ERRORS = (*_PORT_ERRORS, termios.error)

_RETRIES = 3
_PING_ANSWER = 14
_PATIENCE_S = 2e-3
BAUD_RATES = (9_600, 57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
"""Bits a second that an X-series servo can be set to, by the value of its register."""


class DamagedAnswers(BusFault):
    """Every answer of one servo comes damaged, as when two servos with one id speak at once."""

    def __init__(self, identity: int, port: str) -> None:
        super().__init__(
            f"port {port}: every answer of servo {identity} comes damaged: two servos with this id, or a bad cable; "
            "take all but one of them off the bus and give it an id of its own"
        )


@dataclass(frozen=True)
class Device:
    """A servo that answered a ping."""

    id: int
    model: str
    firmware: int


class Bus:
    """An open port. Every call raises PortError where the port goes away.

    Attributes:
        port: path.
        baud: bits a second.
        latency: what became of the port's latency timer.
        alerts: ids of the servos whose last answer to a read, write or reboot had the alert bit set.
    """

    def __init__(self, port: str, baud: int) -> None:
        """Open the port, for this program alone.

        Raises:
            PortError: it cannot be opened, or another program has it.
            InvalidOption: no servo has that baud rate.
        """
        self.port, self.baud = port, baud
        self.handler = PortHandler(port)
        self.packets = Protocol2PacketHandler()
        if baud not in BAUD_RATES and self.handler.getCFlagBaud(baud) <= 0:
            raise InvalidOption(
                "--baud", f"{baud} is not a rate of Dynamixel servos: {', '.join(map(str, BAUD_RATES))}"
            )
        with ExitStack() as stack:
            stack.enter_context(claimed(port))
            try:
                # Its own table of rates lacks 4.5 Mbps, which the port takes all the same.
                self.handler.baudrate = baud
                self.handler.setupPort(baud)
            except (serial.SerialException, OSError, ValueError) as error:
                raise unopened(port, error) from None
            keep_out_others(self.serial, port)
            self._claim = stack.pop_all()
        # Wait in the kernel for a whole packet instead of polling for each byte.
        self.serial.timeout = _PATIENCE_S
        self.latency = lower_latency(port)
        self.alerts: set[int] = set()

    @property
    def serial(self) -> serial.Serial:
        """The SDK's serial port."""
        port = self.handler.ser
        assert isinstance(port, serial.Serial)
        return port

    def close(self) -> None:
        """Close the port, whatever state it is in."""
        try:
            self.handler.closePort()
        except _PORT_ERRORS:
            self.handler.is_open = False
        finally:
            self._claim.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    @contextmanager
    def guarded(self) -> Iterator[None]:
        """Turn the failures of a vanished port into PortError."""
        try:
            yield
        except _PORT_ERRORS as error:
            self.handler.is_using = False
            raise PortError(self.port, f"went away ({error})") from None

    def ping(self, identity: int) -> str | None:
        """The model of a servo, or None where nothing answers."""
        found = self.find(identity)
        return None if found is None else found.model

    def find(self, identity: int) -> Device | None:
        """What answers a ping, or None where nothing does."""
        for _ in range(_RETRIES):
            request = [0] * 10
            request[PKT_ID], request[PKT_LENGTH_L], request[PKT_INSTRUCTION] = identity, 3, Instruction.PING
            with self.guarded():
                answer, result, _ = self.packets.txRxPacket(self.handler, request)
            if result == COMM_SUCCESS and answer is not None and len(answer) == _PING_ANSWER:
                low, high, firmware = answer[PKT_PARAMETER0 + 1 : PKT_PARAMETER0 + 4]
                return Device(identity, _model(high << 8 | low), firmware)
        return None

    def scan(self) -> tuple[Device, ...]:
        """All servos that answer a broadcast ping, by id; takes about a second."""
        with self.guarded():
            found, _ = self.packets.broadcastPing(self.handler)
        return tuple(Device(i, _model(number), firmware) for i, (number, firmware) in sorted(found.items()))

    def read(self, identity: int, table: ControlTable, register: str) -> int:
        """Raw value of a register.

        Raises:
            LostServo: no intact exchange in three tries.
            BusFault: the servo refuses, or all of its answers come damaged.
        """
        item = table[register]
        return item.unpack(self.read_bytes(identity, item.address, item.size))

    def read_bytes(self, identity: int, address: int, length: int) -> bytes:
        """Bytes from the control table; errors as in `read`."""
        damaged = 0
        for _ in range(_RETRIES):
            with self.guarded():
                data, result, error = self.packets.readTxRx(self.handler, identity, address, length)
            damaged += result == COMM_RX_CORRUPT
            if result == COMM_SUCCESS and error & ~ALERT == StatusError.CRC:
                continue  # the instruction was damaged on its way
            if result == COMM_SUCCESS and len(data) == length:
                self._refuse(identity, error, f"reading {length} bytes at {address}")
                return bytes(data)
        if damaged == _RETRIES:
            raise DamagedAnswers(identity, self.port)
        raise LostServo([f"servo {identity}"], f"to a read of address {address}")

    def write(self, identity: int, table: ControlTable, register: str, value: int) -> None:
        """Write a raw value to a register; errors as in `read`."""
        item = table[register]
        self.write_bytes(identity, item.address, item.pack(value), f"{register} = {value}")

    def write_bytes(self, identity: int, address: int, data: bytes, what: str = "") -> None:
        """Write bytes to the control table; errors as in `read`."""
        for _ in range(_RETRIES):
            with self.guarded():
                result, error = self.packets.writeTxRx(self.handler, identity, address, len(data), list(data))
            if result == COMM_SUCCESS and error & ~ALERT != StatusError.CRC:
                self._refuse(identity, error, f"writing {what or address}")
                return
        raise LostServo([f"servo {identity}"], f"to a write of {what or f'address {address}'}")

    def write_together(self, identities: Iterable[int], table: ControlTable, register: str, value: int) -> None:
        """Sync Write one raw value to several servos; nobody answers."""
        item = table[register]
        head = item.address.to_bytes(2, "little") + item.size.to_bytes(2, "little")
        body = b"".join(bytes((identity,)) + item.pack(value) for identity in identities)
        with self.guarded():
            self.serial.reset_input_buffer()
            self.serial.write(encode(Packet(BROADCAST, Instruction.SYNC_WRITE, head + body)))

    def reboot(self, identity: int) -> None:
        """Restart a servo: clears its hardware error, loses its RAM and its torque."""
        with self.guarded():
            result, error = self.packets.reboot(self.handler, identity)
        if result != COMM_SUCCESS:
            raise LostServo([f"servo {identity}"], "to a reboot")
        self._refuse(identity, error, "reboot")

    def _refuse(self, identity: int, error: int, what: str) -> None:
        (self.alerts.add if error & ALERT else self.alerts.discard)(identity)
        if code := error & ~ALERT:
            raise BusFault(f"servo {identity} refuses {what}: {error_name(code)}")


def _model(number: int) -> str:
    """Name of a model, also of one that the SDK does not know: a scan must show it all the same."""
    try:
        return model_name(number)
    except UnknownName:
        return f"unknown model {number}"


def error_name(code: int) -> str:
    """The error code of a status packet in words."""
    known = code in StatusError._value2member_map_
    return StatusError(code).name.lower().replace("_", " ") if known else f"code {code}"
