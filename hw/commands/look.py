"""`servos scan`, `info` and `read`: look at what is on a port."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from hw.bus import BAUD_RATES, Bus, Device
from hw.commands.base import BusCommand, Row
from hw.commands.present import Present, PresentCommand
from hw.line import WATCHDOG_TRIPPED
from hw.registers import control_table, is_driven
from hw.rig import Rig
from hw.roll_call import voice
from hw.safety import hardware_errors
from hw.servos import open_ports
from hw.stream import opened_port
from hw.units import scale, to_si
from ros_free_stack.console import say
from ros_free_stack.errors import BusFault, HardwareFault, LostServo
from ros_free_stack.robots import load_robot


@dataclass(frozen=True, kw_only=True)
class ServosScan(BusCommand):
    """Find servos: ids, models, firmware; with --all-bauds at every baud rate."""

    all_bauds: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Try every baud rate of the X series, 9600 to 4.5 Mbps; takes about a second each."""

    def run(self) -> int:
        robot = load_robot(self.robot)
        rig = self.rig(robot)
        names = dict(zip(rig.ids, rig.joints, strict=True))
        if rig.board is not None:
            names[rig.board.id] = rig.board.name
        rows: list[Row] = []
        bauds = BAUD_RATES if self.all_bauds else (rig.baud,)
        with opened_port(self.servo, robot) as path:
            for baud in bauds:
                with open_ports(path, baud) as buses:
                    rows += [
                        {
                            "id": found.id,
                            "model": _model(rig, found),
                            "firmware": found.firmware,
                            "baud": baud,
                            "port": bus.port,
                            "joint": names.get(found.id, ""),
                            "problem": _problem(bus, found),
                        }
                        for bus in buses
                        for found in bus.scan()
                    ]
        self.table(f"servos on {self.servo}", rows)
        if rig.board is not None and rows and all(row["id"] == rig.board.id for row in rows):
            say(f"only the {rig.board.name} answers: `servos power on` gives the servos their power")
        return 0 if rows else HardwareFault.exit_code


def _model(rig: Rig, found: Device) -> str:
    """The servo's model, or the name of the robot's board."""
    return rig.board.name if rig.board is not None and found.id == rig.board.id else found.model


def _problem(bus: Bus, found: Device) -> str:
    """What keeps a servo that answers from being used."""
    damaged, mute = voice(bus, found)
    if damaged:
        return "answers come damaged: two servos with this id?"
    return "answers pings only: status return level 0" if mute else ""


@dataclass(frozen=True, kw_only=True)
class ServosInfo(PresentCommand):
    """The state of every servo that answers, and who does not."""

    def run(self) -> int:
        rig = self.rig(load_robot(self.robot))
        with self.present() as present:
            rows = [_row(present, i, several=len(present.buses) > 1) for i in range(len(present.group))]
            silent: list[Row] = [{"joint": label, "error": problem} for label, problem in present.rest]
            blank: Row = dict.fromkeys(rows[0], "") if rows else {}
            self.table(f"{rig.robot} on {self.servo}", rows + [blank | row for row in silent])
            if present.board is not None:
                state = present.board.state()
                say(f"{present.board.label}: power {'on' if state.power else 'off'}, {state.voltage:.1f} V")
            present.tell_rest()
        return HardwareFault.exit_code if present.rest else 0


def _row(present: Present, i: int, *, several: bool) -> Row:
    """What one servo says of itself, as far as it can be read."""
    group, table = present.group, present.group.table(i)
    row: Row = {"id": group.units[i].id, "joint": present.joints[i], "model": table.model}
    row |= {"port": group.bus(i).port} if several else {}
    shown = ("Operating Mode", "Torque Enable", "Present Position", "Present Temperature", "Present Input Voltage",
             "Bus Watchdog", "Hardware Error Status")  # fmt: skip
    value: dict[str, int] = {}
    problems: list[str] = []
    try:
        value = {name: group.read(i, name) for name in shown if name in table}
    except (LostServo, BusFault) as error:
        problems.append(str(error))
    if bits := value.get("Hardware Error Status"):
        problems.append(hardware_errors(bits) if is_driven(table.model) else f"code {bits}")
    if value.get("Bus Watchdog") == WATCHDOG_TRIPPED:
        problems.append("watchdog tripped")
    position, voltage = value.get("Present Position"), value.get("Present Input Voltage")
    return row | {
        "mode": value.get("Operating Mode", ""),
        "torque": bool(value["Torque Enable"]) if "Torque Enable" in value else "",
        "position_rad": "" if position is None else to_si(table, "Present Position", position),
        "temperature_c": value.get("Present Temperature", ""),
        "voltage_v": "" if voltage is None else to_si(table, "Present Input Voltage", voltage),
        "error": ", ".join(problems),
    }


@dataclass(frozen=True, kw_only=True)
class ServosRead(BusCommand):
    """Read the control table of one servo, or one register of it by name."""

    id: Annotated[int, tyro.conf.Positional]
    """Servo id."""
    register: Annotated[str | None, tyro.conf.Positional] = None
    """Register name as in the e-Manual, e.g. "Present Position"; all where it is left out."""

    def run(self) -> int:
        with self.buses() as buses:
            bus, found = next(
                ((bus, found) for bus in buses if (found := bus.find(self.id)) is not None), (buses[0], None)
            )
            if found is None:
                raise LostServo([f"servo {self.id}"], f"to a ping on {', '.join(bus.port for bus in buses)}")
            table = control_table(found.model, found.firmware)
            names = [self.register] if self.register else [n for n in table.registers if not n.startswith("Indirect")]
            rows: list[Row] = []
            for name in names:
                raw = bus.read(self.id, table, name)
                value = to_si(table, name, raw)
                unit = scale(table, name)[2]
                rows.append(
                    {"address": table[name].address, "register": name, "raw": raw,
                     "value": value if unit != "raw" else raw, "unit": unit if unit != "raw" else ""}
                )  # fmt: skip
            self.table(f"servo {self.id}: {table.model}", rows)
        return 0
