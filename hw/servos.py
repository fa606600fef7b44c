"""The servos of a rig, on one serial port or several, addressed by their place in the rig."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from hw.bus import Bus
from hw.registers import ControlTable
from hw.rig import Rig
from hw.roll_call import Answer, roll_call
from ros_free_stack.errors import BusFault, InvalidOption, LostServo, ModelMismatch, PortError, UnsafeCommand


def split_ports(ports: str) -> tuple[str, ...]:
    """The ports of "/dev/ttyUSB0,/dev/ttyUSB1"; InvalidOption where one is empty or named twice."""
    names = tuple(name.strip() for name in ports.split(","))
    if not all(names) or len(set(names)) < len(names):
        raise InvalidOption("--servo", f"expected distinct ports with commas between them, found {ports!r}")
    return names


@contextmanager
def open_ports(ports: str, baud: int) -> Iterator[tuple[Bus, ...]]:
    """Open the port, or all of several with commas between them; errors as `Bus`."""
    with ExitStack() as stack:
        yield tuple(stack.enter_context(Bus(port, baud)) for port in split_ports(ports))


@dataclass(frozen=True)
class Unit:
    """One servo that answers: the port that it is on, its id, its control table, and its name for people."""

    bus: Bus
    id: int
    table: ControlTable
    label: str


class Group:
    """Servos by index, each behind the port that it answered on."""

    def __init__(self, units: Iterable[Unit]) -> None:
        self.units = tuple(units)

    def __len__(self) -> int:
        return len(self.units)

    def bus(self, index: int) -> Bus:
        """The port of a servo."""
        return self.units[index].bus

    def table(self, index: int) -> ControlTable:
        """The control table of a servo: of its model and firmware."""
        return self.units[index].table

    def label(self, index: int) -> str:
        """A servo's name for people."""
        return self.units[index].label

    def ping(self, index: int) -> bool:
        """Whether a servo answers."""
        return self.bus(index).ping(self.units[index].id) is not None

    def read(self, index: int, register: str) -> int:
        """Raw value of a register; errors as `Bus.read`."""
        return self.bus(index).read(self.units[index].id, self.table(index), register)

    def write(self, index: int, register: str, value: int) -> None:
        """Write a raw value to a register; errors as `Bus.write`."""
        self.bus(index).write(self.units[index].id, self.table(index), register, value)

    def write_together(self, indices: Iterable[int], register: str, value: int) -> None:
        """Write one raw value to several servos without waiting for answers; a lost port does not keep the others back.

        Raises:
            PortError: a port went away; the others were written.
        """
        groups: dict[tuple[str, int, int], list[int]] = {}
        for i in indices:
            item = self.table(i)[register]
            groups.setdefault((self.bus(i).port, item.address, item.size), []).append(i)
        lost: PortError | None = None
        for members in groups.values():
            try:
                identities = [self.units[i].id for i in members]
                self.bus(members[0]).write_together(identities, self.table(members[0]), register, value)
            except PortError as error:
                lost = error
        if lost is not None:
            raise lost


class Servos(Group):
    """All servos of a rig, in its order.

    Attributes:
        rig: joints and servos.
        buses: the open ports.
        place: index of each servo's port in `buses`.
        mute: indices of the servos that answer pings and nothing else, so that their registers cannot be read.
    """

    def __init__(
        self,
        rig: Rig,
        buses: tuple[Bus, ...],
        place: tuple[int, ...],
        *,
        tables: tuple[ControlTable, ...] | None = None,
        mute: Iterable[int] = (),
    ) -> None:
        self.rig, self.buses, self.place, self.mute = rig, buses, place, frozenset(mute)
        tables = rig.tables if tables is None else tables
        super().__init__(Unit(buses[k], rig.ids[i], tables[i], rig.label(i)) for i, k in enumerate(place))

    @classmethod
    def find(
        cls,
        rig: Rig,
        buses: tuple[Bus, ...],
        check: Callable[[], None] = lambda: None,
        *,
        mute_too: bool = False,
    ) -> "Servos":
        """Find every servo of the rig and check its model.

        Args:
            rig: joints and servos.
            buses: the open ports.
            check: called before each servo; may raise to give up.
            mute_too: take also servos that answer pings alone, for who can mend that.

        Raises:
            LostServo: servos that answer on no port; names all of them.
            ModelMismatch: a servo is not the model that the robot's servo map says, or answers on two ports.
            BusFault: two servos have one id.
            UnsafeCommand: a servo answers pings alone.
        """
        answers = roll_call(rig, buses, check)
        for answer in answers:
            _refuse(rig, buses, answer, mute_too=mute_too)
        if silent := [rig.label(answer.index) for answer in answers if not answer.places]:
            ports = ", ".join(bus.port for bus in buses)
            raise LostServo(
                silent, f"to a ping at {rig.baud} baud on {ports}; on a rig without them, name the others with --joints"
            )
        return cls(
            rig,
            buses,
            tuple(answer.places[0] for answer in answers),
            tables=tuple(answer.table or rig.tables[answer.index] for answer in answers),
            mute=(answer.index for answer in answers if answer.mute),
        )


def _refuse(rig: Rig, buses: tuple[Bus, ...], answer: Answer, *, mute_too: bool) -> None:
    """Raise what keeps a servo that answers from being used."""
    label = rig.label(answer.index)
    if len(answer.places) > 1:
        ports = " and ".join(buses[k].port for k in answer.places)
        raise ModelMismatch(f"{label} answers on {ports}: ids must be distinct")
    if answer.device is not None and answer.device.model != rig.tables[answer.index].model:
        raise ModelMismatch(
            f"{label} is an {answer.device.model}, the servo map of {rig.robot} says {rig.tables[answer.index].model}"
        )
    if answer.damaged:
        raise BusFault(f"{label}: {answer.damaged}")
    if answer.mute and not mute_too:
        raise UnsafeCommand(f"{label} answers pings only, its status return level is 0: run `servos configure --write`")
