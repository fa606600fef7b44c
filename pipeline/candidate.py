"""One candidate of a run: a generated motion with what the robot makes of it and what the judge says."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ros_free_stack.messages import HumanMotion, RobotTrajectory

if TYPE_CHECKING:
    from retarget.report import RetargetReport
    from sim.judge.verdict import Judgement


@dataclass(frozen=True)
class Sample:
    """One generated motion and how well it shows its sentence, which is known before any robot is asked.

    Attributes:
        motion: the motion.
        violations: the verifier's count of what is wrong with it.
        missing: what the motion does not show of its segments' texts, a line each.
        distance: from the sentence, by the evaluator of text and motion; less is better.
        faithful: whether every action that was asked for is there, as far as the verifier can tell.
        amounts: what the robot's distances, angles and durations come to, where the sentence names them, a line each.
    """

    motion: HumanMotion
    violations: int
    missing: tuple[str, ...]
    distance: float
    faithful: bool = True
    amounts: tuple[str, ...] = ()

    @property
    def order(self) -> tuple[int, float]:
        """Samples are tried in this order: fewest violations, then the least distance from the sentence."""
        return self.violations, self.distance


@dataclass(frozen=True)
class Candidate:
    """A sample, what the robot makes of it, and the judgement."""

    sample: Sample
    trajectory: RobotTrajectory
    report: "RetargetReport"
    judgement: "Judgement"

    @property
    def motion(self) -> HumanMotion:
        """The human motion."""
        return self.sample.motion

    @property
    def passed(self) -> bool:
        """Feasible on the robot, and showing what was asked for."""
        return self.judgement.passed and self.sample.faithful

    @property
    def order(self) -> tuple[bool, int, int, float]:
        """Those that pass come first, then by fewest failed checks, then by how well they show what was said."""
        return not self.passed, len(self.judgement.verdict.failures), *self.sample.order

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        failed = [check.name for check in self.judgement.verdict.failures]
        errors = [spread.mean for spread in self.report.position_error_cm.values()]
        return {
            "passed": self.judgement.passed,
            "faithful": self.sample.faithful,
            "failed": failed,
            "duration_s": self.motion.duration_s,
            "not_shown": list(self.sample.missing),
            "amounts": list(self.sample.amounts),
            "violations": self.sample.violations,
            "distance_to_text": self.sample.distance,
            "mean_position_error_cm": sum(errors) / len(errors),
        }
