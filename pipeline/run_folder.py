"""The folder of a run: motion, trajectory and verdict as soon as they are known, then report and video."""

import platform
import shlex
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

from pipeline.candidate import Candidate
from pipeline.timings import Timings
from ros_free_stack import __version__
from ros_free_stack.console import say
from ros_free_stack.robots import RobotDescription

TELEMETRY = "telemetry.npz"


@dataclass(frozen=True)
class RunFolder:
    """What is written where; every method returns the files that it wrote, by name."""

    path: Path
    facts: Mapping[str, str] = field(default_factory=dict)
    """How the motion was made, for the report."""

    @property
    def telemetry(self) -> Path:
        """Where a stream records itself."""
        return self.path / TELEMETRY

    def save(self, best: Candidate, timings: Timings) -> dict[str, str]:
        """Write motion, trajectory and verdict; what an earlier run left there must not pass for this one's."""
        from ros_free_stack.files import save_motion, save_trajectory, save_trajectory_csv, save_verdict

        for name in ("video.mp4", TELEMETRY):
            (self.path / name).unlink(missing_ok=True)
        with timings.measure("report"):
            save_motion(self.path / "human_motion.npz", best.motion)
            save_trajectory(self.path / "trajectory.npz", best.trajectory)
            save_trajectory_csv(self.path / "trajectory.csv", best.trajectory)
            save_verdict(self.path / "verdict.json", best.judgement.verdict)
        return self._files("human_motion.npz", "trajectory.npz", "trajectory.csv", "verdict.json")

    def report(
        self, best: Candidate, robot: RobotDescription, timings: Timings, notes: tuple[str, ...], *, video: bool
    ) -> dict[str, str]:
        """Write report and video, with what the servos did where there was a stream."""
        from ros_free_stack.files import load_telemetry
        from sim.draw.report import write_report

        telemetry = load_telemetry(self.telemetry) if self.telemetry.exists() else None
        names = ["report.html", *([TELEMETRY] if telemetry else [])]
        with timings.measure("report"):
            write_report(
                self.path,
                best.motion,
                best.trajectory,
                best.judgement,
                robot,
                telemetry=telemetry,
                timings=dict(timings.seconds),
                notes=notes,
                not_shown=best.sample.missing,
                faithful=best.sample.faithful,
                facts={**self.facts, **_versions()},
            )
        if video:
            with timings.measure("video"):
                names += self._video(best, robot)
        return self._files(*names)

    def _video(self, best: Candidate, robot: RobotDescription) -> list[str]:
        from ros_free_stack.errors import MissingDependency
        from sim.draw.render import render_video

        try:
            render_video(self.path / "video.mp4", best.trajectory, best.judgement, robot, best.motion)
        except MissingDependency as error:
            say(f"no video: {error}")
            return []
        return ["video.mp4"]

    def _files(self, *names: str) -> dict[str, str]:
        return {name: str(self.path / name) for name in names}


def _versions() -> dict[str, str]:
    """The command line, and the versions of what decides about the result."""
    libraries = ", ".join(f"{name} {version(name)}" for name in ("mujoco", "casadi", "torch", "numpy"))
    return {
        "command line": shlex.join(sys.argv),
        "versions": f"ros-free-stack {__version__}, Python {platform.python_version()}, {libraries}",
    }
