"""Command line of the servo room: stream a trajectory; scan, read, set up and calibrate servos."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from hw.bus import BAUD_RATES, Bus
from hw.calibration import load_calibration
from hw.rig import Rig
from hw.servos import Servos, open_ports
from hw.stream import WayCheck, opened_port, stream
from ros_free_stack.console import Command, say
from ros_free_stack.errors import HardwareFault, InvalidOption, LostServo, UnknownName
from ros_free_stack.files import load_trajectory, load_verdict
from ros_free_stack.robots import RobotDescription, load_robot

Row = dict[str, Any]


@dataclass(frozen=True, kw_only=True)
class Stream(Command):
    """Play a trajectory with a passing verdict on servos, real or emulated."""

    trajectory: Annotated[Path, tyro.conf.Positional]
    """Trajectory (.npz)."""
    verdict: Annotated[Path, tyro.conf.Positional]
    """Its verdict (.json)."""
    servo: str = "sim"
    """Serial port, several with commas between them, or "sim" for an emulated bus."""
    telemetry: Path | None = None
    """Record what was commanded and measured (.npz)."""
    calibration: Path | None = None
    """Servo directions, zeros and ranges (.yaml), as `servos calibrate` writes it."""
    joints: tuple[str, ...] | None = None
    """Move only these joints, on a rig that has only these; the others are skipped."""
    mount: Literal["free", "fixed"] = "free"
    """`fixed` for a robot held by its root, which may play what was judged so."""
    at_end: Literal["off", "hold"] = "off"
    """Whether the servos go limp or hold the last pose."""
    dry_run: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Check everything and read the servos, but write nothing to them."""

    def run(self) -> int:
        trajectory, verdict = load_trajectory(self.trajectory), load_verdict(self.verdict)
        robot = load_robot(trajectory.robot)
        report = stream(
            trajectory,
            verdict,
            robot,
            port=self.servo,
            telemetry=self.telemetry,
            dry_run=self.dry_run,
            calibration=self.calibration,
            joints=self.joints,
            mount=self.mount,
            at_end=self.at_end,
            check_way=self._way_check(robot),
        )
        result = report.as_dict()
        if report.skipped:
            say(f"skipped, not on this rig: {', '.join(report.skipped)}")
        if self.dry_run:
            self.report(result, f"dry run: {report.joints} servos on {report.port} are ready, nothing was written")
            return 0
        self.report(
            result,
            f"{report.joints} servos on {report.port}: {report.cycles} cycles at {result['rate_hz']:.1f} Hz, "
            f"jitter p99 {report.jitter_p99_ms:.2f} ms, read by {report.method}",
            f"following error {report.following_error_rad:.3f} rad at most, {report.following_error_rms_rad:.4f} rms",
            *(f"note: {problem}" for problem in report.errors),
        )
        return 0

    def _way_check(self, robot: RobotDescription) -> WayCheck | None:
        """Who looks at the way to the first pose; the servo room alone knows no bodies."""
        return None


@dataclass(frozen=True, kw_only=True)
class BusCommand(Command):
    """Base of the commands that talk to the servos of one robot."""

    servo: str = "sim"
    """Serial port, several with commas between them, or "sim" for an emulated bus."""
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
            for bus in buses:
                for identity in sorted(bus.alerts):
                    say(f"warning: servo {identity} on {bus.port} raises its alert: see `servos info`")

    @contextmanager
    def opened(self) -> Iterator[Servos]:
        """The robot's servos, found and checked."""
        with self.buses() as buses:
            yield Servos.find(self.rig(load_robot(self.robot)), buses)

    def rig(self, robot: RobotDescription) -> Rig:
        """The rig, calibrated if a calibration is given."""
        calibration = load_calibration(self.calibration, robot) if self.calibration else None
        return Rig.of_robot(robot, calibration=calibration, only=self.joints)

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


@dataclass(frozen=True, kw_only=True)
class ServosScan(BusCommand):
    """Find servos: ids, models, firmware; with --all-bauds at every baud rate."""

    all_bauds: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Try every baud rate of the X series; takes about a second each."""

    def run(self) -> int:
        robot = load_robot(self.robot)
        rig = self.rig(robot)
        names = dict(zip(rig.ids, rig.joints, strict=True))
        rows: list[Row] = []
        bauds = BAUD_RATES if self.all_bauds else (rig.baud,)
        with opened_port(self.servo, robot) as path:
            for baud in bauds:
                with open_ports(path, baud) as buses:
                    rows += [
                        {
                            "id": found.id,
                            "model": found.model,
                            "firmware": found.firmware,
                            "baud": baud,
                            "port": bus.port,
                            "joint": names.get(found.id, ""),
                        }
                        for bus in buses
                        for found in bus.scan()
                    ]
        self.table(f"servos on {self.servo}", rows)
        return 0 if rows else HardwareFault.exit_code


@dataclass(frozen=True, kw_only=True)
class ServosInfo(BusCommand):
    """The state of every servo of the robot."""

    def run(self) -> int:
        from hw.line import WATCHDOG_TRIPPED
        from hw.safety import hardware_errors
        from hw.units import to_si

        with self.opened() as servos:
            rows: list[Row] = []
            for i, (joint, identity) in enumerate(zip(servos.rig.joints, servos.rig.ids, strict=True)):
                table = servos.table(i)
                value = {
                    name: servos.read(i, name)
                    for name in ("Operating Mode", "Torque Enable", "Present Position", "Present Temperature",
                                 "Present Input Voltage", "Bus Watchdog", "Hardware Error Status")
                }  # fmt: skip
                problems = [hardware_errors(error)] if (error := value["Hardware Error Status"]) else []
                if value["Bus Watchdog"] == WATCHDOG_TRIPPED:
                    problems.append("watchdog tripped")
                rows.append(
                    {
                        "id": identity,
                        "joint": joint,
                        "model": table.model,
                        **({"port": servos.bus(i).port} if len(servos.buses) > 1 else {}),
                        "mode": value["Operating Mode"],
                        "torque": bool(value["Torque Enable"]),
                        "position_rad": to_si(table, "Present Position", value["Present Position"]),
                        "temperature_c": value["Present Temperature"],
                        "voltage_v": to_si(table, "Present Input Voltage", value["Present Input Voltage"]),
                        "error": ", ".join(problems),
                    }
                )
            self.table(f"{self.robot} on {self.servo}", rows)
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosRead(BusCommand):
    """Read the control table of one servo, or one register of it by name."""

    id: Annotated[int, tyro.conf.Positional]
    """Servo id."""
    register: Annotated[str | None, tyro.conf.Positional] = None
    """Register name as in the e-Manual, e.g. "Present Position"; all where it is left out."""

    def run(self) -> int:
        from hw.registers import control_table
        from hw.units import scale, to_si

        with self.buses() as buses:
            bus, model = next(((bus, model) for bus in buses if (model := bus.ping(self.id)) is not None), (None, ""))
            if bus is None:
                raise LostServo([f"servo {self.id}"], f"to a ping on {', '.join(bus.port for bus in buses)}")
            table = control_table(model)
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


@dataclass(frozen=True, kw_only=True)
class ServosConfigure(BusCommand):
    """Show which registers differ from what the robot needs; write them with --write."""

    write: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Write the changes (EEPROM included)."""

    def run(self) -> int:
        from hw.configure import apply_changes, planned_changes

        with self.opened() as servos:
            changes = planned_changes(servos)
            if self.write:
                apply_changes(servos, changes)
            if self.json:
                self.report({"written": self.write, "changes": [asdict(change) for change in changes]})
                return 0
            rows: list[Row] = [
                dict(
                    zip(
                        ("servo", "register", "now", "wanted"),
                        (c.servo, c.register, *c.describe(servos.table(c.index))),
                        strict=True,
                    )
                )
                for c in changes
            ]
            self.table("written" if self.write else "would be written with --write", rows)
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosReboot(BusCommand):
    """Restart servos: clears a hardware error; they go limp."""

    ids: Annotated[tuple[int, ...], tyro.conf.Positional] = ()
    """Servo ids; all of the robot where none are given."""

    def run(self) -> int:
        with self.opened() as servos:
            place = {identity: servos.bus(i) for i, identity in enumerate(servos.rig.ids)}
            chosen = self.ids or servos.rig.ids
            for identity in chosen:
                if identity not in place:
                    raise UnknownName("servo id", str(identity), map(str, place))
            for identity in chosen:
                place[identity].reboot(identity)
        self.report({"rebooted": list(chosen)}, f"restarted {len(chosen)} servos")
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosRelease(BusCommand):
    """Switch the torque of every servo off and recover tripped watchdogs: the robot goes limp, so support it."""

    def run(self) -> int:
        from hw.stop import torque_off

        with self.opened() as servos:
            unconfirmed = torque_off(servos, recover=True)
        if unconfirmed:
            raise HardwareFault(f"torque off NOT confirmed for {', '.join(unconfirmed)}: cut the power")
        self.report({"released": list(servos.rig.ids)}, f"torque off on {len(servos)} servos")
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosCalibrate(BusCommand):
    """Measure zero, direction and range of each joint: you move the limp robot, the servos say where it is."""

    out: Path = Path("calibration.yaml")
    """Where the calibration goes."""

    def run(self) -> int:
        from hw.guide import calibrate

        if not sys.stdin.isatty():
            raise InvalidOption("servos calibrate", "needs a terminal: it asks you to move the robot")
        with self.opened() as servos:
            try:
                calibration = calibrate(servos, lambda text: input(f"{text} "))
            except EOFError:
                raise InvalidOption("servos calibrate", "the terminal was closed; nothing was written") from None
        calibration.save(self.out)
        self.report({"calibration": str(self.out), "joints": len(calibration.joints)}, f"wrote {self.out}")
        return 0
