"""The `stream` command of the servo package alone; `hw.commands` has those that talk to single servos."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from hw.outputs import check_output
from hw.stream import WayCheck, stream
from ros_free_stack.console import Command, say
from ros_free_stack.files import load_trajectory, load_verdict, make_folder
from ros_free_stack.robots import RobotDescription, load_robot


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
        if self.telemetry is not None:
            inputs = {"trajectory": self.trajectory, "verdict": self.verdict, "--calibration": self.calibration}
            check_output("--telemetry", make_folder(self.telemetry.parent) / self.telemetry.name, inputs=inputs)
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
