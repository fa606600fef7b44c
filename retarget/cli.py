"""The `retarget` subcommand."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from ros_free_stack.console import say, time_left
from ros_free_stack.formats.cli import ReadsMotion


@dataclass(frozen=True, kw_only=True)
class Retarget(ReadsMotion):
    """Turn a human motion into a robot's joint trajectory.

    Examples:
        python launch.py retarget out/human_motion.npz --robot g1 --out out/trajectory.npz
        python launch.py retarget walk1_subject1.bvh --robot g1
        python launch.py retarget dance.bvh --robot g1 --start 12 --end 20 --keep-timing
        python launch.py retarget take.bvh --mapping mapping.yaml --units cm
        python launch.py retarget Walk_B15_stageii.npz --skeleton SMPLX_NEUTRAL.npz
    """

    motion: Annotated[Path, tyro.conf.Positional, tyro.conf.arg(metavar="FILE")]
    """Human motion: .npz (as `generate` writes it, or AMASS), .bvh, .amc, .npy (HumanML3D), .txt (DeepMimic), .pkl."""
    robot: str = "op3"
    """Robot by name."""
    out: Path = Path("trajectory.npz")
    """Trajectory to write (.npz); a .csv for spreadsheets appears beside it."""
    fps: float = 50.0
    """Frames a second of the trajectory."""
    balance: bool = True
    """Shift the body so that the robot keeps its balance."""
    solver: Literal["clip", "frames"] = "clip"
    """`clip` solves all frames together; `frames` one after the other: quicker, less smooth."""
    keep_timing: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Keep the person's pace also where a step leaves the robot no time to shift its weight."""

    def run(self) -> int:
        """Retarget, write both files, and say what could not be followed."""
        from ros_free_stack.files import check_input, check_output, make_folder, save_trajectory, save_trajectory_csv
        from ros_free_stack.formats.registry import load_human
        from ros_free_stack.robots import load_robot

        check_output(self.out, ".npz")
        robot = load_robot(self.robot)
        check_input(self.motion)
        motion, notes = load_human(self.motion, self.source_options(), self.format)
        for note in notes:
            say(note)
        from retarget.pipeline import retarget  # slow: after all that may refuse

        make_folder(self.out.parent)
        result = retarget(
            motion,
            robot,
            fps=self.fps,
            balance=self.balance,
            solver=self.solver,
            keep_timing=self.keep_timing,
            progress=time_left("retarget"),
        )
        table = self.out.with_suffix(".csv")
        save_trajectory_csv(table, result.trajectory)
        save_trajectory(self.out, result.trajectory)
        for line in result.report.changes():
            say(line)
        for item in result.report.tracking_errors:
            say(f"tracking error: {item}")
        for line in result.report.failures():
            say(line)
        for start, end in result.report.unsolved_s:
            say(f"no better trajectory was found from {start:.2f} to {end:.2f} s than the one frame by frame")
        trajectory = result.trajectory
        self.report(
            {
                "trajectory": str(self.out),
                "csv": str(table),
                "robot": robot.name,
                "frames": len(trajectory.joint_pos),
                "duration_s": trajectory.duration_s,
                "report": result.report.as_dict(),
            },
            f"{self.out}: {trajectory.duration_s:.1f} s for {robot.title}, standing at both ends",
        )
        return 0
