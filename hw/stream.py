"""Stream a judged trajectory to a robot's servos, or to an emulated bus."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from hw.bus import Bus
from hw.calibration import load_calibration
from hw.driver import AtEnd, Driver
from hw.resample import Goals, ramp, resample
from hw.rig import Rig
from hw.safety import Limits
from hw.telemetry import Telemetry
from hw.virtual.bus import VirtualBus
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import RobotTrajectory, Verdict
from ros_free_stack.rate import RateStatistics
from ros_free_stack.robots import RobotDescription

SIMULATED = "sim"


@dataclass(frozen=True)
class StreamReport:
    """What a stream did.

    Attributes:
        port: where it went.
        joints, cycles: how many servos, and how often they were commanded (ramp included).
        rate: achieved rate and jitter; None in a dry run.
        method: how the servos were read.
        latency_timer: what became of the port's latency timer.
        realtime: whether the loop ran with real-time priority.
        lost_replies: readings that did not come and were made up for by the next.
        errors: what went wrong without stopping the stream.
        following_error_rad: largest distance between goal and measured angle.
        following_error_rms_rad: its root mean square over all joints and cycles.
        resampling_error_rad: largest distance of a frame from what was streamed.
        peak_current_a, peak_temperature_c, min_voltage_v: extremes over all servos.
        at_end: "off" or "hold".
        dry_run: nothing was written to the servos.
    """

    port: str
    joints: int
    cycles: int
    rate: RateStatistics | None
    method: str
    latency_timer: str
    realtime: bool
    lost_replies: int
    errors: tuple[str, ...]
    following_error_rad: float
    following_error_rms_rad: float
    resampling_error_rad: float
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
    limits: Limits | None = None,
    at_end: AtEnd = "off",
) -> StreamReport:
    """Stream a trajectory that passed its verdict: ramp to its first frame, then one goal a servo cycle.

    Args:
        trajectory: of this robot.
        verdict: passing, of this very trajectory.
        robot: must have servos.
        port: serial port, or "sim" for an emulated bus.
        telemetry: `.npz` file for what was commanded and measured; also written when a fault ends the stream.
        dry_run: check everything and read the servos' pose, but write nothing to them.
        calibration: file of servo directions, zeros and ranges; None takes the robot's description.
        joints: stream only these, on a rig that has only these; None streams all.
        limits: safety thresholds.
        at_end: whether the servos go limp or hold at the end.

    Raises:
        UnsafeCommand: no passing verdict of this trajectory and model, or the motion breaks a limit.
        ModelMismatch: robot, trajectory and servos do not belong together.
        HardwareFault: port, bus or servo failed; the servos were stopped.
        KeyboardInterrupt: Ctrl-C or SIGTERM; the servos were stopped.
    """
    check_verdict(trajectory, verdict, robot)
    rig = Rig.of_robot(robot, calibration=load_calibration(calibration, robot) if calibration else None, only=joints)
    goals = resample(trajectory, rig)
    with (
        opened_port(port, robot) as path,
        Driver(rig, path, limits=limits, at_end=at_end) as driver,
    ):
        driver.check_goals(goals.angles)
        if dry_run:
            driver.measure()
            return _report(driver, port, goals, Telemetry(rig, 0), dry_run=True)
        start = driver.enable().position
        path_in = ramp(start, goals.angles[0], speed=driver.limits.ramp_speed, cycle_s=rig.cycle_s)
        recording = Telemetry(rig, len(path_in) + len(goals.angles) + 1)
        try:
            driver.move_to(goals.angles[0], recording.add)
            driver.follow(goals.angles, recording.add)
        finally:
            if telemetry is not None:
                recording.save(telemetry)
        return _report(driver, port, goals, recording, dry_run=False)


def check_verdict(trajectory: RobotTrajectory, verdict: Verdict, robot: RobotDescription) -> None:
    """UnsafeCommand unless the verdict passed and is of this trajectory and this robot's model."""
    if trajectory.robot != robot.name or trajectory.model_sha256 != robot.sha256:
        raise ModelMismatch(
            f"the trajectory was made for {trajectory.robot} (model {trajectory.model_sha256[:12]}), "
            f"not for this {robot.name} (model {robot.sha256[:12]}): retarget and judge it again"
        )
    if verdict.trajectory_digest != trajectory.digest or verdict.model_sha256 != robot.sha256:
        raise UnsafeCommand("the verdict is of another trajectory or model: judge this trajectory first")
    if not verdict.passed:
        failed = ", ".join(check.name for check in verdict.failures) or "it holds no check"
        raise UnsafeCommand(f"the verdict did not pass ({failed}): only a feasible motion is streamed")


def check_port(port: str, robot: RobotDescription) -> None:
    """Fail early where a stream could not even begin: the robot has no servos, or the port does not open.

    Raises:
        InvalidOption: the robot has no servos.
        PortError: the port cannot be opened.
    """
    rig = Rig.of_robot(robot)
    if port != SIMULATED:
        Bus(port, rig.baud).close()


@contextmanager
def opened_port(port: str, robot: RobotDescription) -> Iterator[str]:
    """The path of a serial port; "sim" starts an emulated bus of the robot's servos for as long as it is used."""
    if port != SIMULATED:
        yield port
        return
    with VirtualBus.of_robot(robot, timed=True) as bus:
        yield bus.port


def _report(driver: Driver, port: str, goals: Goals, recording: Telemetry, *, dry_run: bool) -> StreamReport:
    rate = None if dry_run else driver.pace.statistics()
    error = recording.column("position")[1:] - recording.column("goal")[:-1]
    return StreamReport(
        port=port,
        joints=len(driver.rig.joints),
        cycles=rate.cycles if rate else 0,
        rate=rate,
        method=driver.cycle.method,
        latency_timer=driver.bus.latency,
        realtime=driver.realtime,
        lost_replies=driver.watch.lost_replies,
        errors=_complaints(driver, rate),
        following_error_rad=driver.watch.max_following_error,
        following_error_rms_rad=float(np.sqrt(np.mean(error**2))) if error.size else 0.0,
        resampling_error_rad=goals.deviation,
        peak_current_a=float(np.abs(recording.column("current")).max(initial=0.0)),
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
    return tuple(found)
