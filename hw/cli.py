"""Command line of the servo room: stream a trajectory; scan, read, set up, calibrate and emulate servos."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from hw.bus import Bus
from hw.calibration import load_calibration
from hw.rig import Rig
from hw.stream import opened_port, stream
from ros_free_stack.console import Command, say
from ros_free_stack.errors import HardwareFault, InvalidOption
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
    """Serial port, or "sim" for an emulated bus."""
    telemetry: Path | None = None
    """Record what was commanded and measured (.npz)."""
    calibration: Path | None = None
    """Servo directions, zeros and ranges (.yaml), as `servos calibrate` writes it."""
    joints: tuple[str, ...] | None = None
    """Move only these joints, on a rig that has only these."""
    at_end: Literal["off", "hold"] = "off"
    """Whether the servos go limp or hold the last pose."""
    dry_run: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Check everything and read the servos, but write nothing to them."""

    def run(self) -> int:
        trajectory, verdict = load_trajectory(self.trajectory), load_verdict(self.verdict)
        report = stream(
            trajectory,
            verdict,
            load_robot(trajectory.robot),
            port=self.servo,
            telemetry=self.telemetry,
            dry_run=self.dry_run,
            calibration=self.calibration,
            joints=self.joints,
            at_end=self.at_end,
        )
        result = report.as_dict()
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


@dataclass(frozen=True, kw_only=True)
class BusCommand(Command):
    """Base of the commands that talk to the servos of one robot."""

    servo: str = "sim"
    """Serial port, or "sim" for an emulated bus."""
    robot: str = "op3"
    """Robot whose servo map, baud rate and limits apply."""
    calibration: Path | None = None
    """Servo directions, zeros and ranges (.yaml)."""

    @contextmanager
    def opened(self) -> Iterator[tuple[Bus, Rig]]:
        """The open bus and the robot's rig."""
        robot = load_robot(self.robot)
        rig = self.rig(robot)
        with opened_port(self.servo, robot) as path, Bus(path, rig.baud) as bus:
            yield bus, rig

    def rig(self, robot: RobotDescription) -> Rig:
        """The rig of all joints, calibrated if a calibration is given."""
        return Rig.of_robot(robot, calibration=load_calibration(self.calibration, robot) if self.calibration else None)

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
        bauds = (57_600, 115_200, 1_000_000, 2_000_000, 3_000_000, 4_000_000) if self.all_bauds else (rig.baud,)
        with opened_port(self.servo, robot) as path:
            for baud in bauds:
                with Bus(path, baud) as bus:
                    rows += [
                        {
                            "id": d.id,
                            "model": d.model,
                            "firmware": d.firmware,
                            "baud": baud,
                            "joint": names.get(d.id, ""),
                        }
                        for d in bus.scan()
                    ]
        self.table(f"servos on {self.servo}", rows)
        return 0 if rows else HardwareFault.exit_code


@dataclass(frozen=True, kw_only=True)
class ServosInfo(BusCommand):
    """The state of every servo of the robot."""

    def run(self) -> int:
        from hw.safety import hardware_errors
        from hw.units import to_si

        with self.opened() as (bus, rig):
            rows: list[Row] = []
            for joint, identity in zip(rig.joints, rig.ids, strict=True):
                table = bus.table_of(identity)
                value = {
                    name: bus.read(identity, table, name)
                    for name in ("Operating Mode", "Torque Enable", "Present Position", "Present Temperature",
                                 "Present Input Voltage", "Hardware Error Status")
                }  # fmt: skip
                error = value["Hardware Error Status"]
                rows.append(
                    {
                        "id": identity,
                        "joint": joint,
                        "model": table.model,
                        "mode": value["Operating Mode"],
                        "torque": bool(value["Torque Enable"]),
                        "position_rad": to_si(table, "Present Position", value["Present Position"]),
                        "temperature_c": value["Present Temperature"],
                        "voltage_v": to_si(table, "Present Input Voltage", value["Present Input Voltage"]),
                        "error": hardware_errors(error) if error else "",
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
        from hw.units import scale, to_si

        with self.opened() as (bus, _):
            table = bus.table_of(self.id)
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

        with self.opened() as (bus, rig):
            changes = planned_changes(bus, rig)
            if self.write:
                apply_changes(bus, rig, changes)
            if self.json:
                self.report({"written": self.write, "changes": [asdict(change) for change in changes]})
                return 0
            rows: list[Row] = [
                dict(zip(("servo", "register", "now", "wanted"), (c.servo, c.register, *c.describe(rig)), strict=True))
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
        with self.opened() as (bus, rig):
            chosen = self.ids or rig.ids
            for identity in chosen:
                bus.reboot(identity)
        self.report({"rebooted": list(chosen)}, f"restarted {len(chosen)} servos")
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosRelease(BusCommand):
    """Switch the torque of every servo off: the robot goes limp, so support it."""

    def run(self) -> int:
        from hw.stop import torque_off

        with self.opened() as (bus, rig):
            unconfirmed = torque_off(bus, rig)
        if unconfirmed:
            raise HardwareFault(f"torque off NOT confirmed for {', '.join(unconfirmed)}: cut the power")
        self.report({"released": list(rig.ids)}, f"torque off on {len(rig.ids)} servos")
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
        with self.opened() as (bus, rig):
            calibration = calibrate(bus, rig, lambda text: input(f"{text} "))
        calibration.save(self.out)
        self.report({"calibration": str(self.out), "joints": len(calibration.joints)}, f"wrote {self.out}")
        return 0


@dataclass(frozen=True, kw_only=True)
class ServosEmulate(Command):
    """Run an emulated bus of a robot's servos on a pseudo terminal until Ctrl-C."""

    robot: str = "op3"
    """Robot whose servos are emulated."""
    untimed: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Answer at once instead of after the time that the bytes take on the wire."""

    def run(self) -> int:
        from hw.virtual.bus import VirtualBus

        with VirtualBus.of_robot(load_robot(self.robot), timed=not self.untimed) as bus:
            self.report({"port": bus.port, "servos": sorted(bus.network.servos)}, bus.port)
            sys.stdout.flush()
            say("emulating; stop with Ctrl-C")
            while True:
                time.sleep(3600)
