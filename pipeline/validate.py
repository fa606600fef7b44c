"""The `validate` subcommand with its repair, which needs a retargeter beside the judge."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import tyro

from ros_free_stack.errors import InvalidOption
from ros_free_stack.messages import HumanMotion, RobotTrajectory
from ros_free_stack.robots import RobotDescription
from sim.cli import Validate as ValidateAlone

if TYPE_CHECKING:
    from sim.judge.verdict import Judgement


@dataclass(frozen=True, kw_only=True)
class Validate(ValidateAlone):
    """Judge a trajectory: limits, contacts, coherence, and a playback in physics. Exit code 3 where it fails.

    Examples:
        python launch.py validate trajectory.npz --out out/
        python launch.py validate trajectory.npz --level strict --perturbed 20
        python launch.py validate trajectory.npz --motion human_motion.npz --repair --out out/
    """

    repair: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Where it fails, try whole-body control, then slower and smaller motions, retargeted anew; needs --motion.
    trajectory.npz and human_motion.npz of what was judged are written beside the verdict."""

    def run(self) -> int:
        if self.repair and (self.motion is None or self.out is None or not self.physics):
            raise InvalidOption("--repair", "needs the human motion (--motion), a folder (--out) and physics")
        return super().run()

    def _judge(
        self, trajectory: RobotTrajectory, motion: HumanMotion | None, robot: RobotDescription
    ) -> "tuple[RobotTrajectory, HumanMotion | None, Judgement]":
        if not self.repair or self.out is None:
            return super()._judge(trajectory, motion, robot)
        from retarget.pipeline import Retargeter
        from ros_free_stack.files import save_motion, save_trajectory
        from sim.judge.repair import repair

        retargeter = Retargeter(robot)
        found = repair(
            trajectory,
            robot,
            motion=motion,
            retarget=lambda changed: retargeter.retarget(changed, fps=trajectory.fps).trajectory,
            mount=self.mount,
            level=self.level,
            perturbed=self.perturbed,
            controllers=("default", "wbc") if self.controller == "default" else (self.controller,),
        )
        save_trajectory(self.out / "trajectory.npz", found.trajectory)
        if found.motion is not None:
            save_motion(self.out / "human_motion.npz", found.motion)
        return found.trajectory, found.motion, found.judgement
