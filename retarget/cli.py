"""The `retarget` subcommand."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from ros_free_stack.console import Command, say


@dataclass(frozen=True, kw_only=True)
class Retarget(Command):
    """Turn a human motion into a robot's joint trajectory."""

    motion: Annotated[Path, tyro.conf.Positional]
    """Human motion (.npz, as written by `generate`)."""
    robot: str = "op3"
    """Robot by name."""
    out: Path = Path("trajectory.npz")
    """Trajectory to write (.npz); a .csv for spreadsheets appears beside it."""
    fps: float = 50.0
    """Frames a second of the trajectory."""
    balance: bool = True
    """Shift the body so that the robot keeps its balance."""

    def run(self) -> int:
        """Retarget, write both files, and say what could not be followed."""
        from retarget.pipeline import retarget
        from ros_free_stack.errors import InvalidOption
        from ros_free_stack.files import load_motion, make_folder, save_trajectory, save_trajectory_csv
        from ros_free_stack.robots import load_robot

        if self.out.suffix != ".npz":
            raise InvalidOption("--out", f"expected a name that ends in .npz, found {str(self.out)!r}")
        robot = load_robot(self.robot)
        motion = load_motion(self.motion)
        make_folder(self.out.parent)
        result = retarget(motion, robot, fps=self.fps, balance=self.balance)
        table = self.out.with_suffix(".csv")
        save_trajectory_csv(table, result.trajectory)
        save_trajectory(self.out, result.trajectory)
        for item in result.report.given_up:
            say(f"given up: {item}")
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
            f"{self.out}: {trajectory.duration_s:.1f} s for {robot.title}",
        )
        return 0
