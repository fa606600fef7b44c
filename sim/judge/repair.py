"""The ladder: what to try before a motion is called infeasible, and what was changed to make it pass.

The controllers that may move the robot, then a slower or smaller motion, then infeasible. A gentler motion is not a
stretched trajectory: the human motion is changed and retargeted anew, so that footsteps, balance and limits are planned
for the new pace. The judge does not know how to retarget, so it is handed a function.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from ros_free_stack.messages import ControllerName, HumanMotion, Level, Mount, RobotTrajectory, Segment
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import INDEX
from sim.judge.verdict import Judgement, judge

Retarget = Callable[[HumanMotion], RobotTrajectory]

BALANCE_CHECKS: Final = frozenset(
    {"fall_height", "fall_orientation", "mpjpe_global", "mpjpe_relative", "joint_velocity_error", "robustness"}
)
"""Checks that another controller may pass where the default one does not; the others are the reference's own."""


@dataclass(frozen=True)
class Change:
    """How a motion is made gentler: `slowdown` stretches its time, `amplitude` shrinks every joint's path."""

    slowdown: float = 1.0
    amplitude: float = 1.0

    def words(self) -> str:
        """What was changed, for people."""
        parts = []
        if self.slowdown != 1:
            parts.append(f"{self.slowdown:g} times slower")
        if self.amplitude != 1:
            parts.append(f"{self.amplitude:.0%} of its size")
        return " and ".join(parts) or "as it was"


GENTLER: Final = (Change(slowdown=1.25), Change(slowdown=1.6), Change(amplitude=0.75), Change(1.4, 0.6))

MOST_TURNING: Final = np.pi / 4
"""A motion that turns further is made slower, but not smaller."""


@dataclass(frozen=True)
class Repaired:
    """What came out of the ladder.

    Attributes:
        judgement: of the rung that passed, or of the unchanged motion where none did.
        trajectory: what was judged there.
        motion: the human motion that it follows, or None where none was given.
        change: what was changed.
        controller: what moved the robot.
        tried: one line a rung: what was tried and what failed.
    """

    judgement: Judgement
    trajectory: RobotTrajectory
    motion: HumanMotion | None
    change: Change
    controller: ControllerName
    tried: tuple[str, ...]


def repair(
    trajectory: RobotTrajectory,
    robot: RobotDescription,
    *,
    motion: HumanMotion | None = None,
    retarget: Retarget | None = None,
    mount: Mount = "free",
    level: Level = "default",
    perturbed: int = 0,
    controllers: Sequence[ControllerName] = ("default", "wbc"),
    known: Judgement | None = None,
) -> Repaired:
    """Climb the ladder until a rung passes every check.

    Args:
        trajectory: what the robot should do.
        robot: the robot.
        motion: the human motion that the trajectory follows; without it nothing can be made gentler.
        retarget: makes a trajectory of a human motion; as `motion`.
        mount: see `judge`.
        level: see `judge`.
        perturbed: see `judge`.
        controllers: tried one after the other on each motion, as long as only balance or tracking fails.
        known: of the trajectory as it is with the first controller, where it was judged like this before.

    Returns:
        The first rung that passed, with what was changed in the notes of its verdict; the unchanged motion's judgement,
        with what was tried, where none did.
    """
    tried: list[str] = []
    first: Repaired | None = None
    for change, changed, candidate in _rungs(trajectory, motion, retarget):
        for controller in controllers:
            judgement, known = known, None
            if judgement is None:
                judgement = judge(
                    candidate, robot, mount=mount, level=level, controller=controller, perturbed=perturbed
                )
            failed = [check.name for check in judgement.verdict.failures]
            rung = f"{change.words()}, {controller} controller"
            tried.append(f"{rung}: {'passed' if not failed else 'failed ' + ', '.join(failed)}")
            found = Repaired(judgement, candidate, changed, change, controller, tuple(tried))
            first = first or found
            if not failed:
                return _noted(found, f"changed: {rung}" if len(tried) > 1 else "")
            if not BALANCE_CHECKS.issuperset(failed):
                break
    assert first is not None
    return _noted(replace(first, tried=tuple(tried)), *(f"tried {line}" for line in tried[1:]))


def _rungs(
    trajectory: RobotTrajectory, motion: HumanMotion | None, retarget: Retarget | None
) -> Iterator[tuple[Change, HumanMotion | None, RobotTrajectory]]:
    yield Change(), motion, trajectory
    if motion is None or retarget is None:
        return
    turns = turning(motion) > MOST_TURNING
    for change in GENTLER:
        if turns and change.amplitude != 1:
            continue
        changed = gentler(motion, change)
        yield change, changed, retarget(changed)


def _noted(found: Repaired, *notes: str) -> Repaired:
    verdict = found.judgement.verdict
    verdict = replace(verdict, notes=(*verdict.notes, *(note for note in notes if note)))
    return replace(found, judgement=replace(found.judgement, verdict=verdict))


def gentler(motion: HumanMotion, change: Change) -> HumanMotion:
    """A slower or smaller motion.

    Every joint's way from where it is in the first frame shrinks alike, so a foot that stands still goes on standing,
    steps get shorter, squats less deep, arms rise less. Limbs get a little shorter where they turn, which a retargeter
    that follows directions does not mind.

    Args:
        motion: the motion; one that turns about the vertical (`turning`) collapses when it gets smaller.
        change: what to do.
    """
    start = motion.joints[0]
    segments = tuple(
        Segment(item.text, item.start_s * change.slowdown, item.end_s * change.slowdown) for item in motion.segments
    )
    joints = start + change.amplitude * (motion.joints - start)
    return replace(motion, joints=joints, fps=motion.fps / change.slowdown, segments=segments)


def turning(motion: HumanMotion) -> float:
    """Largest angle in rad between the hips' heading in any frame and in the first."""
    across = (motion.joints[:, INDEX["left_hip"]] - motion.joints[:, INDEX["right_hip"]])[:, :2]
    sine = across[0, 0] * across[:, 1] - across[0, 1] * across[:, 0]
    return float(np.abs(np.arctan2(sine, across @ across[0])).max())
