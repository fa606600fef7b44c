"""What the `servos` commands share: a port that is named, the rig, the servos behind it, tables."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hw.board import Board, without_power
from hw.bus import Bus
from hw.calibration import load_calibration
from hw.rig import Rig
from hw.servos import Servos, open_ports
from hw.stream import opened_port
from ros_free_stack.console import Command, say
from ros_free_stack.errors import LostServo
from ros_free_stack.robots import RobotDescription, load_robot

Row = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class BusCommand(Command):
    """Base of the commands that talk to the servos of one robot."""

    servo: str
    """Serial port, or several with commas between them; "sim" for an emulated bus of its own."""
    robot: str = "op3"
    """Robot whose servo map, baud rate and limits apply."""
    calibration: Path | None = None
    """Servo directions, zeros and ranges (.yaml)."""
    joints: tuple[str, ...] | None = None
    """Only these joints, on a rig that has only these."""

    @contextmanager
    def buses(self) -> Iterator[tuple[Bus, ...]]:
        """The open ports; says at the end which servos raised their alert."""
        robot = load_robot(self.robot)
        with opened_port(self.servo, robot) as path, open_ports(path, self.rig(robot).baud) as buses:
            yield buses
            self.tell_alerts(buses)

    @contextmanager
    def opened(self, *, mute_too: bool = False) -> Iterator[Servos]:
        """The robot's servos, found and checked; `mute_too` takes those that answer pings alone."""
        with self.buses() as buses:
            rig = self.rig(load_robot(self.robot))
            try:
                servos = Servos.find(rig, buses, mute_too=mute_too)
            except LostServo as lost:
                raise without_power(Board.find(rig.board, buses)) or lost from None
            yield servos

    def rig(self, robot: RobotDescription) -> Rig:
        """The rig, calibrated if a calibration is given."""
        calibration = load_calibration(self.calibration, robot) if self.calibration else None
        return Rig.of_robot(robot, calibration=calibration, only=self.joints)

    def tell_alerts(self, buses: tuple[Bus, ...]) -> None:
        """Say which servos raised their alert."""
        for bus in buses:
            for identity in sorted(bus.alerts):
                say(f"warning: servo {identity} on {bus.port} raises its alert: see `servos info`")

    def table(self, title: str, rows: list[Row]) -> None:
        """Print rows as a table, or as JSON with `--json`."""
        if self.json:
            self.report({"rows": rows})
            return
        from rich.console import Console
        from rich.table import Table

        table = Table(title=title)
        for name in rows[0] if rows else ():
            table.add_column(name.replace("_", " "))
        for row in rows:
            table.add_row(*(f"{value:.3f}" if isinstance(value, float) else str(value) for value in row.values()))
        Console().print(table)
