"""The board between a robot's battery and its servos: their power switch, its buttons and its voltage.

Source: ROBOTIS's firmware of the OpenCR in the OP3, which answers on the servos' own bus.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from hw.protocol import Instruction, Packet, StatusError
from hw.virtual.memory import Refused
from hw.virtual.servo import Servo
from ros_free_stack.robots import ServoBoard

_SIZE = 128
_FIRMWARE, _ID = 6, 7


@dataclass
class Board:
    """An emulated board.

    Attributes:
        settings: its registers.
        baud: bits a second.
        dead: it neither hears nor answers.
        voltage: V of the battery.
        powered: whether the servos have power.
    """

    settings: ServoBoard
    baud: int
    dead: bool = False
    voltage: float = 12.0
    powered: bool = False
    memory: bytearray = field(default_factory=lambda: bytearray(_SIZE))

    level = 2
    alert = False
    return_delay_s = 0.0

    def __post_init__(self) -> None:
        self.memory[0:2] = self.settings.model_number.to_bytes(2, "little")
        self.memory[_FIRMWARE], self.memory[_ID] = 1, self.settings.id
        self.memory[self.settings.power] = self.powered
        self._sense()

    @property
    def id(self) -> int:
        return self.settings.id

    @property
    def answering(self) -> bool:
        return not self.dead

    def press(self, *names: str) -> None:
        """Hold these buttons down, and no others."""
        self.memory[self.settings.buttons] = sum(1 << self.settings.button_names.index(name) for name in names)

    def advance(self, dt: float, servos: Iterable[Servo]) -> None:
        """Measure; servos without power stay without."""
        self._sense()
        self.switch(servos)

    def do(self, packet: Packet, servos: Iterable[Servo]) -> bytes:
        """Do one instruction for the board alone; Refused where it cannot."""
        data = packet.parameters
        if packet.instruction == Instruction.PING:
            return self.read(0, 2) + self.read(_FIRMWARE, 1)
        if packet.instruction == Instruction.READ and len(data) == 4:
            return self.read(int.from_bytes(data[:2], "little"), int.from_bytes(data[2:], "little"))
        if packet.instruction == Instruction.WRITE and len(data) >= 3:
            self.write(int.from_bytes(data[:2], "little"), data[2:], servos)
            return b""
        raise Refused(StatusError.INSTRUCTION)

    def read(self, address: int, length: int) -> bytes:
        """Read bytes; Refused beyond the table."""
        if address + length > _SIZE:
            raise Refused(StatusError.ACCESS)
        return bytes(self.memory[address : address + length])

    def write(self, address: int, data: bytes, servos: Iterable[Servo]) -> None:
        """Write the switch; nothing else that is told here can be written."""
        if address != self.settings.power or len(data) != 1:
            raise Refused(StatusError.ACCESS)
        if data[0] > 1:
            raise Refused(StatusError.DATA_RANGE)
        self.memory[address] = data[0]
        self.powered = data[0] == self.settings.on
        self.switch(servos)

    def switch(self, servos: Iterable[Servo]) -> None:
        """Give the servos power, or take it."""
        for servo in servos:
            if servo.powered != self.powered:
                servo.switch_power(on=self.powered)

    def _sense(self) -> None:
        self.memory[self.settings.voltage] = round(self.voltage / self.settings.volt)
