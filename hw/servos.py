"""The servos of a rig, on one serial port or several: found, checked and addressed by their place in the rig."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import ExitStack, contextmanager

from hw.bus import Bus
from hw.registers import ControlTable
from hw.rig import Rig
from ros_free_stack.errors import InvalidOption, LostServo, ModelMismatch, PortError


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


class Servos:
    """The servos of a rig by index, each behind the port that it answered on.

    Attributes:
        rig: joints and servos.
        buses: the open ports.
        place: index of each servo's port in `buses`.
    """

    def __init__(self, rig: Rig, buses: tuple[Bus, ...], place: tuple[int, ...]) -> None:
        self.rig, self.buses, self.place = rig, buses, place

    @classmethod
    def find(cls, rig: Rig, buses: tuple[Bus, ...], check: Callable[[], None] = lambda: None) -> "Servos":
        """Find every servo of the rig and check its model.

        Args:
            rig: joints and servos.
            buses: the open ports.
            check: called before each servo; may raise to give up.

        Raises:
            LostServo: servos that answer on no port; names all of them.
            ModelMismatch: a servo is not the model that the robot's servo map says, or answers on two ports.
        """
        heard = [{device.id for device in bus.scan()} for bus in buses] if len(buses) > 1 else [set[int]()]
        place: list[int] = []
        silent: list[str] = []
        for i, identity in enumerate(rig.ids):
            check()
            where = [k for k, ids in enumerate(heard) if identity in ids]
            if len(where) > 1:
                ports = " and ".join(buses[k].port for k in where)
                raise ModelMismatch(f"{rig.label(i)} answers on {ports}: ids must be distinct")
            # A reply to the broadcast may have been lost: ask by name on every port.
            found = {k: model for k in (where or range(len(buses))) if (model := buses[k].ping(identity)) is not None}
            if not found:
                silent.append(rig.label(i))
                continue
            k, model = next(iter(found.items()))
            if model != rig.tables[i].model:
                raise ModelMismatch(
                    f"{rig.label(i)} is an {model}, the servo map of {rig.robot} says {rig.tables[i].model}"
                )
            place.append(k)
        if silent:
            ports = ", ".join(bus.port for bus in buses)
            raise LostServo(
                silent, f"to a ping at {rig.baud} baud on {ports}; on a rig without them, name the others with --joints"
            )
        return cls(rig, buses, tuple(place))

    def __len__(self) -> int:
        return len(self.rig.ids)

    def bus(self, index: int) -> Bus:
        """The port of a servo."""
        return self.buses[self.place[index]]

    def table(self, index: int) -> ControlTable:
        """The control table of a servo."""
        return self.rig.tables[index]

    def ping(self, index: int) -> bool:
        """Whether a servo answers."""
        return self.bus(index).ping(self.rig.ids[index]) is not None

    def read(self, index: int, register: str) -> int:
        """Raw value of a register; errors as `Bus.read`."""
        return self.bus(index).read(self.rig.ids[index], self.table(index), register)

    def write(self, index: int, register: str, value: int) -> None:
        """Write a raw value to a register; errors as `Bus.write`."""
        self.bus(index).write(self.rig.ids[index], self.table(index), register, value)

    def write_together(self, indices: Iterable[int], register: str, value: int) -> None:
        """Write one raw value to several servos without waiting for answers; a lost port does not keep the others back.

        Raises:
            PortError: a port went away; the others were written.
        """
        groups: dict[tuple[int, int, int], list[int]] = {}
        for i in indices:
            item = self.table(i)[register]
            groups.setdefault((self.place[i], item.address, item.size), []).append(i)
        lost: PortError | None = None
        for (place, _, _), members in groups.items():
            try:
                identities = [self.rig.ids[i] for i in members]
                self.buses[place].write_together(identities, self.table(members[0]), register, value)
            except PortError as error:
                lost = error
        if lost is not None:
            raise lost
