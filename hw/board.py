"""The board between the battery and the servos: their power switch, its buttons, the battery's voltage."""

import time
from dataclasses import dataclass

from hw.bus import Bus
from hw.protocol import Instruction, Packet, PacketReader, encode
from ros_free_stack.console import say
from ros_free_stack.errors import BusFault, HardwareFault, LostServo, PortError, ServoFault
from ros_free_stack.robots import ServoBoard

_GLANCE_S = 4e-3
"""How long a look within the servo cycle may wait for its answer."""
_STATUS_OVERHEAD = 11


@dataclass(frozen=True)
class BoardState:
    """What the board says: whether the servos have power, the buttons that are pressed, V of the battery."""

    power: bool
    pressed: tuple[str, ...]
    voltage: float


class Board:
    """A robot's board, on the port that it answers on.

    Attributes:
        settings: its registers.
        bus: the port.
        lowest_v: lowest voltage so far, V.
    """

    def __init__(self, settings: ServoBoard, bus: Bus) -> None:
        self.settings, self.bus = settings, bus
        self.lowest_v = float("inf")
        places = settings.power, settings.buttons, settings.voltage
        self._start = min(places)
        self._span = max(places) + 1 - self._start

    @classmethod
    def find(cls, settings: ServoBoard | None, buses: tuple[Bus, ...]) -> "Board | None":
        """The board, or None where the robot has none or it does not answer."""
        for bus in buses if settings is not None else ():
            if settings is not None and bus.find(settings.id) is not None:
                return cls(settings, bus)
        return None

    @property
    def label(self) -> str:
        """Its name for people."""
        return f"{self.settings.name} (id {self.settings.id} on {self.bus.port})"

    def state(self) -> BoardState:
        """Ask it.

        Raises:
            LostServo, BusFault, PortError: it does not answer as it should.
        """
        return self._state(self.bus.read_bytes(self.settings.id, self._start, self._span))

    def switch(self, *, on: bool) -> None:
        """Give the servos power, or take it, and read back that it is so; returns when they have started.

        Raises:
            LostServo, PortError: it does not answer.
            BusFault: the switch did not move.
        """
        value = self.settings.on if on else 0
        self.bus.write_bytes(self.settings.id, self.settings.power, bytes((value,)), "the power switch")
        if self.state().power != on:
            raise BusFault(f"{self.label}: the servos' power is still {'off' if on else 'on'}")
        if on:
            time.sleep(self.settings.wait_s)

    def power_up(self) -> BoardState:
        """Switch the servos' power on where it is off, and say so; warn of a low battery. Errors as `switch`."""
        if not self.state().power:
            self.switch(on=True)
            say(f"{self.label}: switched the servos' power on")
        state = self.state()
        if state.voltage < self.settings.low_voltage:
            say(f"warning: {self.label}: {state.voltage:.1f} V, low below {self.settings.low_voltage:g} V: charge it")
        return state

    def cut(self) -> bool:
        """Take the servos' power, whatever the bus does; return whether that is certain."""
        for _ in range(3):
            try:
                self.switch(on=False)
            except (LostServo, BusFault, PortError):
                continue
            return True
        return False

    def glance(self) -> BoardState | None:
        """Ask once within a servo cycle; None where no intact answer came in time.

        Raises:
            PortError: the port went away.
        """
        parameters = self._start.to_bytes(2, "little") + self._span.to_bytes(2, "little")
        wanted, reader = self._span + _STATUS_OVERHEAD, PacketReader()
        end = time.perf_counter() + _GLANCE_S
        with self.bus.guarded():
            self.bus.serial.reset_input_buffer()
            self.bus.serial.write(encode(Packet(self.settings.id, Instruction.READ, parameters)))
            while time.perf_counter() < end:
                for packet in reader.feed(self.bus.serial.read(wanted)):
                    if packet.id == self.settings.id and len(packet.parameters) == 1 + self._span:
                        return self._state(packet.parameters[1:])
        return None

    def _state(self, data: bytes) -> BoardState:
        settings, start = self.settings, self._start
        bits, voltage = data[settings.buttons - start], data[settings.voltage - start] * settings.volt
        self.lowest_v = min(self.lowest_v, voltage)
        return BoardState(
            power=data[settings.power - start] == settings.on,
            pressed=tuple(name for i, name in enumerate(settings.button_names) if bits >> i & 1),
            voltage=voltage,
        )


class BoardWatch:
    """Looks at the board every few cycles of a stream; `EVERY` cycles, so that the servos keep their time."""

    EVERY = 8

    def __init__(self, board: Board | None, lost_after: int) -> None:
        self.board = board
        self._lost_after, self._cycle, self._missed = lost_after, 0, 0

    def check(self) -> None:
        """Look, if it is time.

        Raises:
            ServoFault: a button is pressed, or the servos' power went off.
            LostServo: the board missed too many looks in a row.
            PortError: the port went away.
        """
        self._cycle += 1
        if self.board is None or self._cycle % self.EVERY:
            return
        state = self.board.glance()
        if state is None:
            self._missed += 1
            if self._missed >= self._lost_after:
                raise LostServo([self.board.label], f"for {self._missed} looks")
            return
        self._missed = 0
        judge(self.board, state)


def judge(board: Board, state: BoardState) -> None:
    """ServoFault where the board says that the robot must not move."""
    if state.pressed:
        raise ServoFault(board.label, f"button {' and '.join(state.pressed)} is pressed, which stops the robot")
    if not state.power:
        raise ServoFault(board.label, "the servos' power went off")


def without_power(board: Board | None) -> HardwareFault | None:
    """Why servos may be silent: their power is off; None where that is not so, or nobody can tell."""
    if board is None:
        return None
    try:
        on = board.state().power
    except (LostServo, BusFault, PortError):
        return None
    return None if on else ServoFault(board.label, "the servos' power is off: `servos power on` gives it")
