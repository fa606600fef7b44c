"""`servos release`, `reboot` and `power`: make servos safe, as many as answer, and name the rest."""

from dataclasses import dataclass
from typing import Annotated, Literal

import tyro

from hw.board import Board
from hw.commands.base import BusCommand
from hw.commands.present import PresentCommand
from hw.stop import torque_off
from ros_free_stack.console import say
from ros_free_stack.errors import BusFault, HardwareFault, InvalidOption, LostServo, PortError
from ros_free_stack.robots import load_robot


@dataclass(frozen=True, kw_only=True)
class ServosRelease(PresentCommand):
    """Switch the torque of every servo off and recover tripped watchdogs: the robot goes limp, so support it.

    Servos of the bus that the robot does not have are released too, unless --joints says which. Where one does not
    confirm it and the robot's board can take the servos' power, it does.
    """

    def run(self) -> int:
        with self.present() as present:
            unconfirmed = torque_off(present.group, recover=True)
            released = len(present.group) - len(unconfirmed)
            words = f"torque off on {released} servos on {', '.join(bus.port for bus in present.buses)}"
            if not unconfirmed and not present.rest:
                self.report({"released": [unit.id for unit in present.group.units]}, words)
                return 0
            present.tell_rest()
            names = ", ".join((*unconfirmed, *(label for label, _ in present.rest)))
            board = present.board if self.joints is None else None
            if board is not None and board.cut():
                say(f"torque off NOT confirmed for {names}: {board.label} took the power of all servos")
                self.report({"released": [unit.id for unit in present.group.units], "power": "off"}, words)
                return 0
        raise HardwareFault(f"{words}, NOT confirmed for {names}: cut the power")


@dataclass(frozen=True, kw_only=True)
class ServosReboot(PresentCommand):
    """Restart servos: clears a hardware error; they go limp."""

    ids: Annotated[tuple[int, ...], tyro.conf.Positional] = ()
    """Servo ids; all that answer where none are given."""

    def run(self) -> int:
        failed: dict[str, str] = {}
        done: list[int] = []
        with self.present() as present:
            there = {unit.id for unit in present.group.units}
            failed |= {f"servo {identity}": "no answer" for identity in self.ids if identity not in there}
            if not self.ids:
                failed |= dict(present.rest)
            for unit in present.group.units:
                if self.ids and unit.id not in self.ids:
                    continue
                try:
                    unit.bus.reboot(unit.id)
                    done.append(unit.id)
                except (LostServo, BusFault, PortError) as error:
                    failed[unit.label] = str(error)
            ports = ", ".join(bus.port for bus in present.buses)
        words = f"restarted {len(done)} servos on {ports}"
        if failed:
            raise HardwareFault(f"{words}, not: {'; '.join(f'{name} ({why})' for name, why in failed.items())}")
        self.report({"rebooted": done}, words)
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosPower(BusCommand):
    """Show whether the robot's board gives the servos power, give it, or take it: then the robot goes limp.

    Examples:
        python launch.py servos power on --servo /dev/ttyUSB0
        python launch.py servos power off --servo /dev/ttyUSB0
    """

    state: Annotated[Literal["on", "off", "show"], tyro.conf.Positional] = "show"
    """`on`, `off`, or only show."""

    def run(self) -> int:
        settings = self.rig(load_robot(self.robot)).board
        if settings is None:
            raise InvalidOption("--robot", f"the description of {self.robot} names no board with a power switch")
        with self.buses() as buses:
            board = Board.find(settings, buses)
            if board is None:
                ports = ", ".join(bus.port for bus in buses)
                raise LostServo([f"{settings.name} (id {settings.id})"], f"to a ping on {ports}")
            if self.state == "off" and not board.cut():
                raise HardwareFault(f"{board.label}: power off NOT confirmed: pull the plug")
            if self.state == "on":
                board.switch(on=True)
            now = board.state()
        power = "on" if now.power else "off"
        self.report(
            {"power": power, "voltage_v": now.voltage, "pressed": list(now.pressed)},
            f"{board.label}: power {power}, {now.voltage:.1f} V"
            + (f", pressed: {', '.join(now.pressed)}" if now.pressed else ""),
        )
        return 0
