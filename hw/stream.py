"""Stream a judged trajectory to a robot's servos, or to an emulated bus."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from hw.calibration import load_calibration
from hw.driver import Driver
from hw.gate import let_through
from hw.goals import goals_of
from hw.outputs import check_output
from hw.rig import Rig
from hw.servos import open_ports
from hw.telemetry import Recording
from hw.virtual.bus import VirtualBus
from ros_free_stack.console import say
from ros_free_stack.errors import StackError
from ros_free_stack.files import make_folder, save_telemetry
from ros_free_stack.messages import Floats, Mount, RobotTrajectory, Verdict
from ros_free_stack.rate import RateStatistics
from ros_free_stack.robots import RobotDescription, ServoSafety, StopPolicy
from ros_free_stack.servo_path import smoothing_error

SIMULATED = "sim"

WayCheck = Callable[[tuple[str, ...], Floats], None]
"""Called with joint names (N) and the goals (K, N) from the measured pose to the first one; raises UnsafeCommand."""


@dataclass(frozen=True)
class StreamReport:
    """What a stream did.

    Attributes:
        port: where it went.
        mount: whether the robot stood free or was held by its root.
        joints, cycles: how many servos, and how often they were commanded (ramp included).
        skipped: joints of the robot that this rig does not have.
        rate: achieved rate and jitter; None in a dry run.
        method: how the servos were read.
        latency_timer: what became of each port's latency timer.
        realtime: whether the loop ran with real-time priority.
        lost_replies: readings that did not come and were made up for by the next.
        errors: what went wrong without stopping the stream.
        following_error_rad: largest distance between goal and measured angle.
        following_error_rms_rad: its root mean square over all joints and cycles.
        smoothing_error_rad: largest distance of a frame of the trajectory from the path that was judged and streamed.
        peak_current_a: over the servos that measure current.
        peak_temperature_c, min_voltage_v: extremes over all servos.
        at_end: "off" or "hold".
        dry_run: nothing was written to the servos.
    """

    port: str
    mount: Mount
    joints: int
    skipped: tuple[str, ...]
    cycles: int
    rate: RateStatistics | None
    method: str
    latency_timer: tuple[str, ...]
    realtime: bool
    lost_replies: int
    errors: tuple[str, ...]
    following_error_rad: float
    following_error_rms_rad: float
    smoothing_error_rad: float
    peak_current_a: float
    peak_temperature_c: float
    min_voltage_v: float
    at_end: str
    dry_run: bool = False

    @property
    def jitter_p99_ms(self) -> float:
        """99th percentile of the lateness of the cycles, ms."""
        return self.rate.jitter_p99_ms if self.rate else 0.0

    def as_dict(self) -> dict[str, Any]:
        """All fields, with the rate statistics flat among them."""
        data = asdict(self)
        rate = data.pop("rate") or {}
        return {**data, **rate}


def stream(
    trajectory: RobotTrajectory,
    verdict: Verdict,
    robot: RobotDescription,
    *,
    port: str,
    telemetry: Path | None = None,
    dry_run: bool = False,
    calibration: Path | None = None,
    joints: Iterable[str] | None = None,
    mount: Mount = "free",
    safety: ServoSafety | None = None,
    at_end: StopPolicy = "off",
    check_way: WayCheck | None = None,
) -> StreamReport:
    """Stream a trajectory that passed its verdict: ramp to its first pose, then its servo path, one goal a cycle.

    Args:
        trajectory: of this robot.
        verdict: passing, of this very trajectory, for what the driver will do (`hw.gate`).
        robot: must have servos.
        port: serial port, several with commas between them, or "sim" for an emulated bus.
        telemetry: `.npz` file for what was commanded and measured; also written when a fault ends the stream.
        dry_run: check everything and read the servos' pose, but write nothing to them.
        calibration: file of servo directions, zeros and ranges; None takes the robot's description.
        joints: stream only these, on a rig that has only these; None streams all.
        mount: `fixed` for a robot that hangs from a stand, which may also play what was judged so.
        safety: thresholds; None takes those of the robot's description.
        at_end: whether the servos go limp or hold at the end.
        check_way: looks at the ramp from the measured pose before torque is switched on; without one it is told that
            nobody did.

    Raises:
        UnsafeCommand: the verdict is none for what the driver would do, the motion breaks a limit, or the way in is
            refused.
        ModelMismatch: robot, trajectory and servos do not belong together.
        InvalidFile: the calibration cannot be read, or the telemetry not be written; said before anything moves.
        InvalidOption: the telemetry would overwrite the calibration.
        HardwareFault: port, bus or servo failed; the servos were stopped.
        KeyboardInterrupt: Ctrl-C or SIGTERM; the servos were stopped.
    """
    mount = robot.mounted(mount)
    path = let_through(trajectory, verdict, robot, mount)
    rig = _rig(robot, joints, calibration)
    rig = rig if safety is None else replace(rig, safety=safety)
    goals, smoothed = goals_of(path, rig), smoothing_error(trajectory)
    if telemetry is not None:
        make_folder(telemetry.parent)
        size = Recording.size(rig, len(goals))
        check_output("--telemetry", telemetry, inputs={"--calibration": calibration}, size=size)
    with (
        opened_port(port, robot, powered=False) as opened,
        Driver(rig, opened, at_end=at_end, power_up=not dry_run or port == SIMULATED) as driver,
    ):
        for bus in driver.servos.buses:
            if not bus.latency.ok:
                say(f"warning: latency timer of {bus.port} {bus.latency.words}")
        driver.check_goals(goals)
        if check_way is None:
            say("note: nobody looked whether the robot runs into itself on the way to the first pose")
        else:
            check_way(rig.joints, np.vstack([driver.measure(), driver.ramp_to(goals[0])]))
        if dry_run:
            return _report(driver, port, mount, smoothed, Recording(rig, 0), dry_run=True)
        driver.enable()
        way_in = driver.ramp_to(goals[0])
        recording = Recording(rig, len(way_in) + len(goals))
        notes: list[str] = []
        try:
            driver.follow(way_in, recording.add)
            driver.follow(goals, recording.add)
        finally:
            if telemetry is not None and recording.cycles:
                notes = _saved(telemetry, recording)
        return _report(driver, port, mount, smoothed, recording, dry_run=False, notes=notes)


def check_port(
    port: str, robot: RobotDescription, *, joints: Iterable[str] | None = None, calibration: Path | None = None
) -> None:
    """Fail early where a stream could not even begin; arguments as `stream`.

    Raises:
        InvalidOption: the robot has no servos.
        UnknownName: it has no such joint.
        InvalidFile, ModelMismatch: the calibration cannot be used.
        PortError: a port cannot be opened.
    """
    rig = _rig(robot, joints, calibration)
    if port != SIMULATED:
        with open_ports(port, rig.baud):
            pass


def _saved(telemetry: Path, recording: Recording) -> list[str]:
    """Keep the recording; a failure is told, and changes nothing about what the robot does."""
    try:
        save_telemetry(telemetry, recording.message())
    except (StackError, OSError) as error:
        say(f"warning: no telemetry: {error}")
        return [f"no telemetry: {error}"]
    return []


def _rig(robot: RobotDescription, joints: Iterable[str] | None, calibration: Path | None) -> Rig:
    return Rig.of_robot(robot, calibration=load_calibration(calibration, robot) if calibration else None, only=joints)


@contextmanager
def opened_port(port: str, robot: RobotDescription, *, powered: bool = True) -> Iterator[str]:
    """The path of a port, or of several; "sim" starts an emulated bus of the robot's servos while it is used.

    Unless `powered`, the emulated servos wait for their board's switch, as in a robot just started.
    """
    if port != SIMULATED:
        yield port
        return
    with VirtualBus.of_robot(robot, timed=True, powered=powered) as bus:
        yield bus.port


def _report(
    driver: Driver,
    port: str,
    mount: Mount,
    smoothed: float,
    recording: Recording,
    *,
    dry_run: bool,
    notes: Iterable[str] = (),
) -> StreamReport:
    rig = driver.rig
    rate = None if dry_run else driver.rate.statistics()
    error = recording.column("position")[1:] - recording.column("goal")[:-1]
    return StreamReport(
        port=port,
        mount=mount,
        joints=len(rig.joints),
        skipped=rig.skipped,
        cycles=rate.cycles if rate else 0,
        rate=rate,
        method=driver.cycle.method,
        latency_timer=tuple(f"{bus.port}: {bus.latency.words}" for bus in driver.servos.buses),
        realtime=driver.realtime,
        lost_replies=driver.watch.lost_replies,
        errors=(*_complaints(driver, rate), *notes),
        following_error_rad=driver.watch.max_following_error,
        following_error_rms_rad=float(np.sqrt(np.mean(error**2))) if error.size else 0.0,
        smoothing_error_rad=smoothed,
        peak_current_a=float(np.abs(recording.column("current")[:, rig.measures_current]).max(initial=0.0)),
        peak_temperature_c=float(recording.column("temperature").max(initial=0.0)),
        min_voltage_v=float(recording.column("voltage").min(initial=np.inf)) if error.size else 0.0,
        at_end=driver.at_end,
        dry_run=dry_run,
    )


def _complaints(driver: Driver, rate: RateStatistics | None) -> tuple[str, ...]:
    found: list[str] = []
    if rate is not None and rate.missed:
        found.append(f"{rate.missed} cycles began more than {1e3 * driver.rig.cycle_s:g} ms late")
    if driver.watch.lost_replies:
        found.append(f"{driver.watch.lost_replies} readings were lost")
    if driver.cycle.method != "fast sync read":
        found.append(f"no Fast Sync Read: used {driver.cycle.method}")
    if driver.board is not None and driver.board.lowest_v < driver.board.settings.low_voltage:
        found.append(f"the battery is low: {driver.board.lowest_v:.1f} V at least")
    return tuple(found)
