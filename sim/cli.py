"""The `validate` and `render` subcommands."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from ros_free_stack.console import Command

if TYPE_CHECKING:
    from ros_free_stack.messages import Check, HumanMotion, RobotTrajectory
    from ros_free_stack.robots import RobotDescription
    from sim.judge.verdict import Judgement

INFEASIBLE = 3


@dataclass(frozen=True, kw_only=True)
class Validate(Command):
    """Judge a trajectory: limits, contacts, coherence, and a playback in physics. Exit code 3 where it fails."""

    trajectory: Annotated[Path, tyro.conf.Positional]
    """Trajectory (.npz, as written by `retarget`); it names its robot."""
    mount: Literal["free", "fixed"] = "free"
    """`fixed` for a robot held by its root, for which floor and balance do not count."""
    level: Literal["strict", "default", "lenient"] = "default"
    """How strict the limits are."""
    controller: Literal["pd", "default", "wbc"] = "default"
    """What moves the robot: plain servo goals, these with feedforward and balance feedback, or whole-body control."""
    state: Literal["true", "estimated"] = "true"
    """What the controller reads: the simulation's own state, or an estimate from joint encoders and an IMU."""
    perturbed: int = 0
    """Also play so many runs with another mass, friction, latency, a push and noisy sensors, for the success rate."""
    seed: int = 0
    """Seed of the perturbed runs."""
    physics: bool = True
    """Also play the trajectory in physics; without, nothing is written."""
    motion: Path | None = None
    """Human motion (.npz) that it was made from, for the pictures."""
    telemetry: Path | None = None
    """What the servos did when it was streamed (.npz, as `stream --telemetry` writes it), for the report."""
    out: Path | None = None
    """Folder for verdict.json and report.html."""

    def run(self) -> int:
        """Judge, print the checks, and write the report where a folder is given."""
        from time import perf_counter

        from ros_free_stack.errors import InvalidOption
        from ros_free_stack.files import (
            check_folder,
            load_motion,
            load_telemetry,
            load_trajectory,
            make_folder,
            save_verdict,
        )
        from ros_free_stack.robots import load_robot

        if self.out is not None and not self.physics:
            raise InvalidOption(
                "--no-physics", "a verdict file opens the way to servos, so it needs the physics playback"
            )
        if self.perturbed and not self.physics:
            raise InvalidOption("--perturbed", "needs the physics playback: leave --no-physics out")
        trajectory = load_trajectory(self.trajectory)
        robot = load_robot(trajectory.robot)
        motion = None if self.motion is None else load_motion(self.motion)
        telemetry = None if self.telemetry is None else load_telemetry(self.telemetry)
        if self.out is not None:
            check_folder(self.out)
        from sim.draw.report import write_report  # slow: after all that may refuse
        from sim.reference import check_belongs

        check_belongs(trajectory, robot)
        if self.out is not None:
            make_folder(self.out)
        started = perf_counter()
        trajectory, motion, judgement = self._judge(trajectory, motion, robot)
        seconds = perf_counter() - started
        verdict = judgement.verdict
        result: dict[str, Any] = {"passed": verdict.passed, **asdict(verdict), "judge_s": seconds}
        lines = [*map(_line, verdict.checks), *verdict.notes]
        lines.append("feasible" if verdict.passed else "infeasible")
        if self.out is not None:
            save_verdict(self.out / "verdict.json", verdict)
            title = motion.prompt if motion and motion.prompt else self.trajectory.name
            times = {"judge": seconds}
            report = write_report(self.out, motion, trajectory, judgement, robot, title, times, telemetry)
            result["report"] = str(report)
            lines.append(f"report: {report}")
        self.report(result, *lines)
        return 0 if verdict.passed else INFEASIBLE

    def _judge(
        self, trajectory: "RobotTrajectory", motion: "HumanMotion | None", robot: "RobotDescription"
    ) -> "tuple[RobotTrajectory, HumanMotion | None, Judgement]":
        """The judgement, with the trajectory and the human motion that it is about."""
        from sim.judge.verdict import judge

        judgement = judge(
            trajectory,
            robot,
            mount=self.mount,
            physics=self.physics,
            level=self.level,
            controller=self.controller,
            state=self.state,
            perturbed=self.perturbed,
            seed=self.seed,
        )
        return trajectory, motion, judgement


def _line(check: "Check") -> str:
    word = "pass" if check.passed else "FAIL"
    unit = "" if check.unit == "1" else f" {check.unit}"
    where = f"  {check.worst_item}" if check.worst_item else ""
    return f"{word}  {check.name:22} {check.value:10.4g}  limit {check.limit:.4g}{unit}{where}"


@dataclass(frozen=True, kw_only=True)
class Render(Command):
    """Draw a trajectory as a video (needs an OpenGL library: libegl1 or libosmesa6).

    Examples:
        python launch.py render out/run/trajectory.npz --motion out/run/human_motion.npz
    """

    trajectory: Annotated[Path, tyro.conf.Positional]
    """Trajectory (.npz); it names its robot."""
    motion: Path | None = None
    """Human motion (.npz) that it was made from, to show beside the robot."""
    out: Path = Path("video.mp4")
    """Video to write (.mp4)."""

    def run(self) -> int:
        """Draw the planned motion."""
        from ros_free_stack.files import check_output, load_motion, load_trajectory, make_folder
        from ros_free_stack.robots import load_robot

        check_output(self.out, ".mp4")
        trajectory = load_trajectory(self.trajectory)
        robot = load_robot(trajectory.robot)
        from sim.draw.render import render_video  # slow: after all that may refuse
        from sim.reference import check_belongs

        check_belongs(trajectory, robot)
        make_folder(self.out.parent)
        motion = None if self.motion is None else load_motion(self.motion)
        render_video(self.out, trajectory, None, robot, motion)
        self.report({"video": str(self.out)}, str(self.out))
        return 0
