"""Whoever answers, for commands that must do what they can: the others are named, and why."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from hw.board import Board
from hw.bus import Bus
from hw.commands.base import BusCommand
from hw.rig import Rig
from hw.roll_call import known_table, roll_call
from hw.servos import Group, Unit, split_ports
from hw.stream import opened_port
from ros_free_stack.console import say
from ros_free_stack.errors import PortError
from ros_free_stack.robots import load_robot


@dataclass(frozen=True)
class Present:
    """The servos of a port, or several, as far as they answer.

    Attributes:
        group: those that answer, whatever their model, also those that the robot's servo map does not know.
        joints: what each of them moves; empty where the map does not know it.
        rest: label of every other servo of the map, and every port that cannot be used, with what is wrong.
        buses: the open ports.
        board: what gives the servos their power, where it answers.
    """

    group: Group
    joints: tuple[str, ...]
    rest: tuple[tuple[str, str], ...]
    buses: tuple[Bus, ...]
    board: Board | None

    def tell_rest(self) -> None:
        """Say who is missing."""
        for label, problem in self.rest:
            say(f"warning: {label}: {problem}")


@dataclass(frozen=True, kw_only=True)
class PresentCommand(BusCommand):
    """Base of the commands that do what they can for every servo that answers."""

    @contextmanager
    def present(self) -> Iterator[Present]:
        """Whoever answers on the ports that can be opened.

        Raises:
            PortError: none can.
        """
        robot = load_robot(self.robot)
        rig = self.rig(robot)
        with opened_port(self.servo, robot) as ports, ExitStack() as stack:
            buses: list[Bus] = []
            lost: list[PortError] = []
            for port in split_ports(ports):
                try:
                    buses.append(stack.enter_context(Bus(port, rig.baud)))
                except PortError as error:
                    lost.append(error)
            if not buses:
                raise lost[0]
            yield _present(rig, tuple(buses), lost, strangers=self.joints is None)
            self.tell_alerts(tuple(buses))


def _present(rig: Rig, buses: tuple[Bus, ...], lost: list[PortError], *, strangers: bool) -> Present:
    units: list[Unit] = []
    joints: list[str] = []
    rest = [(f"port {error.port}", str(error).removeprefix(f"port {error.port}: ")) for error in lost]
    ports = ", ".join(bus.port for bus in buses)
    for answer in roll_call(rig, buses):
        label = rig.label(answer.index)
        if not answer.places:
            rest.append((label, f"no answer to a ping at {rig.baud} baud on {ports}"))
        elif answer.table is None or answer.device is None:
            rest.append((label, f"is of {answer.device.model if answer.device else 'an unknown model'}"))
        for k in answer.places if answer.table is not None else ():
            # Of another model: by the table of what it is, not of what it ought to be.
            units.append(Unit(buses[k], rig.ids[answer.index], answer.table or rig.tables[answer.index], label))
            joints.append(rig.joints[answer.index])
    known = {*rig.ids, *([rig.board.id] if rig.board else [])}
    for bus in buses if strangers else ():
        for device in bus.scan():
            table = known_table(device)
            if device.id not in known and table is not None and "Torque Enable" in table:
                units.append(Unit(bus, device.id, table, f"servo {device.id}"))
                joints.append("")
    return Present(Group(units), tuple(joints), tuple(rest), buses, Board.find(rig.board, buses))
