"""One way to do what a sentence asks for, with everything that is known about it."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ros_free_stack.messages import HumanMotion, RobotTrajectory

if TYPE_CHECKING:
    from retarget.report import RetargetReport
    from sim.judge.verdict import Judgement


@dataclass(frozen=True)
class Candidate:
    """One generated motion, how well it shows its sentence, what the robot makes of it, and the judgement.

    `missing` says what the motion does not show of its segments' texts; `distance` from the sentence is that of the
    evaluator of text and motion, less is better.
    """

    motion: HumanMotion
    missing: tuple[str, ...]
    distance: float
    trajectory: RobotTrajectory
    report: "RetargetReport"
    judgement: "Judgement"

    @property
    def order(self) -> tuple[int, int, float]:
        """Candidates are preferred by fewest failed checks, then by how well the motion shows what was said."""
        return len(self.judgement.verdict.failures), len(self.missing), self.distance

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        failed = [check.name for check in self.judgement.verdict.failures]
        errors = [limb.mean for limb in self.report.position_error_cm.values()]
        return {
            "passed": self.judgement.passed,
            "failed": failed,
            "duration_s": self.motion.duration_s,
            "not_shown": list(self.missing),
            "distance_to_text": self.distance,
            "mean_position_error_cm": sum(errors) / len(errors),
        }
