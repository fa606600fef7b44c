"""From a human motion to a robot's trajectory: align, scale, plan footsteps, solve, balance, report."""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter
from typing import Literal

import numpy as np

from retarget.balance.com_plan import INSIDE_M, LONGEST_SHIFT, SHRINK, balanced_com, nearer, supports, zmp_excess
from retarget.balance.dynamics import whole_body_dynamics
from retarget.body.geometry import RobotGeometry, measure
from retarget.clip.human import HumanClip, align
from retarget.plan.foothold_update import latch
from retarget.plan.held import held_targets, own_pace
from retarget.plan.pace import walking_pace
from retarget.plan.stride import leg_speed, stride_share
from retarget.plan.targets import Targets, make_targets
from retarget.plan.timeline import Timeline, plan_timeline
from retarget.report import RetargetReport, make_report
from retarget.solve.effort import Effort
from retarget.solve.frame_solver import FrameSolver
from retarget.solve.solution import Solution
from retarget.solve.whole_clip import ClipSolver, Efforts
from ros_free_stack.errors import InvalidOption, SolverFailed
from ros_free_stack.messages import Bools, Floats, HumanMotion, RobotTrajectory
from ros_free_stack.robots import RobotDescription

BALANCE_PASSES = 3

Progress = Callable[[float], None]
"""Is told the share of the work that is done, 0 to 1."""

SolverName = Literal["clip", "frames"]
Unsolved = tuple[tuple[int, int], ...]
"""Stretches of frames (start, end)."""


@dataclass(frozen=True)
class RetargetResult:
    """A trajectory, and how far from its targets it had to stay.

    `human_s` (N,) is the moment of the human motion that each frame of the trajectory follows, s.
    """

    trajectory: RobotTrajectory
    report: RetargetReport
    human_s: Floats


class Retargeter:
    """A robot made ready once for many motions."""

    def __init__(self, robot: RobotDescription, solver: SolverName = "clip") -> None:
        """Measure the robot and build its solvers.

        Args:
            robot: the robot.
            solver: `clip` solves all frames together, from where the frame solver's trajectory lies; `frames` stays
                with that: quicker, less smooth.

        Raises:
            UnsupportedModel: the robot's model lacks something that retargeting needs.
        """
        started = perf_counter()
        self.robot = robot
        self._geometry = measure(robot)
        self._frames = FrameSolver(self._geometry)
        self._clip = ClipSolver(self._geometry, self._frames.collision) if solver == "clip" else None
        self.preparation_s = perf_counter() - started

    def retarget(
        self,
        motion: HumanMotion,
        *,
        fps: float = 50.0,
        balance: bool = True,
        keep_timing: bool = False,
        most_stride: float = 1.0,
        progress: Progress | None = None,
    ) -> RetargetResult:
        """See `retarget`; strides are no longer than `most_stride` of the human's at the robot's size."""
        if not (np.isfinite(fps) and fps > 0):
            raise InvalidOption("fps", f"expected a positive number, found {fps}")
        times = {"prepare": self.preparation_s}
        started = perf_counter()
        clip = align(motion)
        timeline, targets, stride, slowdown = self._targets(clip, fps, keep_timing=keep_timing, most_stride=most_stride)
        passes = _Passes(progress, 1 + BALANCE_PASSES * (balance and not self._geometry.held))
        times["targets"] = perf_counter() - started
        started = perf_counter()
        planned = targets.soles
        efforts: Efforts = defaultdict(Effort)
        balanced = balance and not self._geometry.held
        targets, solution, unsolved = self._solve(targets, efforts, passes, draft=balanced)
        failures = {"frame": self._frames.program.failed, "balance": 0}
        times["solve"] = perf_counter() - started
        excess = None
        if balanced:
            started = perf_counter()
            solution, unsolved, excess = self._balanced(targets, solution, unsolved, failures, efforts, passes)
            times["balance"] = perf_counter() - started
        passes.finish()
        return RetargetResult(
            trajectory=self._trajectory(targets, solution),
            report=make_report(
                self._geometry,
                targets,
                replace(solution, foot_error=solution.foot_error + np.linalg.norm(targets.soles - planned, axis=2)),
                unsolved=unsolved,
                solver_failures={name: count for name, count in failures.items() if count},
                zmp_excess=excess,
                stride_scale=stride,
                slowdown=slowdown,
                human_s=clip.duration_s,
                timings_s=times,
            ),
            human_s=timeline.human_s,
        )

    def _targets(
        self, clip: HumanClip, fps: float, *, keep_timing: bool, most_stride: float
    ) -> tuple[Timeline, Targets, float, float]:
        """Timeline and targets, and by how much strides were shortened and the motion slowed down for them."""
        geometry, pace = self._geometry, own_pace(clip)
        if geometry.held:
            timeline = plan_timeline(pace, fps)
            return timeline, held_targets(clip, geometry, timeline), 1.0, 1.0
        stride = min(stride_share(clip, geometry), most_stride)
        if not keep_timing:
            scale = stride * geometry.hip_height / clip.leg_length
            pace = walking_pace(clip, geometry.hip_height, leg_speed=leg_speed(geometry), scale=scale)
        timeline = plan_timeline(pace, fps)
        return timeline, make_targets(clip, geometry, timeline, stride), stride, pace.slowdown

    def _solve(
        self, targets: Targets, efforts: Efforts, passes: "_Passes", *, draft: bool
    ) -> tuple[Targets, Solution, Unsolved]:
        """Targets with the footholds that were reached, a solution, and the frames that could not be improved."""
        solution = self._frames.solve(targets)
        if self._clip is None:
            return targets, solution, ()
        targets = latch(self._geometry, targets, solution.qpos)
        found = self._clip.solve(targets, solution.qpos, efforts=efforts, draft=draft, solved=passes.next())
        return targets, found.solution, found.unsolved

    def _balanced(
        self,
        targets: Targets,
        solution: Solution,
        unsolved: Unsolved,
        failures: dict[str, int],
        efforts: Efforts,
        passes: "_Passes",
    ) -> tuple[Solution, Unsolved, dict[str, Floats]]:
        """Solve again with a centre of mass that keeps the ZMP inside the support polygons, until it does.

        Once the clip solver has refused a stretch, the centre of mass moves by `LONGEST_SHIFT` a time at most, and by
        half of that if it does so again. What has no solution is counted in `failures`, and what was found stays.
        The dictionary holds (N,) how far the ZMP is outside, `before` and `after`, m.
        """
        geometry, fps = self._geometry, targets.fps
        wanted = solution.centre_of_mass[:, :2]
        inner, outer = (supports(geometry, targets, shrink) for shrink in (SHRINK, 1.0))
        dynamics, com = whole_body_dynamics(geometry, solution.qpos, fps), None
        before = after = zmp_excess(dynamics.zmp, outer)
        longest = np.inf
        for done in range(BALANCE_PASSES):
            if done and (after.max() < INSIDE_M or _spent(efforts)):
                break
            # A body that was left where it was tells nothing of what it makes of a centre of mass.
            try:
                asked = balanced_com(dynamics, wanted, inner, fps, None if unsolved else com)
            except SolverFailed:
                failures["balance"] += 1
                break
            com = nearer(asked, dynamics.centre_of_mass[:, :2], longest)
            shifted = targets.shifted(com - wanted)
            if self._clip is None:
                solution = self._frames.solve(shifted, com)
                failures["frame"] += self._frames.program.failed
            else:
                found = self._clip.solve(shifted, solution.qpos, com, efforts=efforts, solved=passes.next())
                solution, unsolved = found.solution, found.unsolved
                longest = min(longest / 2, LONGEST_SHIFT * geometry.limb_length) if unsolved else longest
            dynamics = whole_body_dynamics(geometry, solution.qpos, fps)
            after = zmp_excess(dynamics.zmp, outer)
        return solution, unsolved, {"before": before, "after": after}

    def _trajectory(self, targets: Targets, solution: Solution) -> RobotTrajectory:
        quaternions = solution.qpos[:, 3:7]
        return RobotTrajectory(
            robot=self.robot.name,
            model_sha256=self.robot.sha256,
            joint_names=self.robot.joint_names,
            fps=targets.fps,
            root_pos=solution.qpos[:, :3],
            root_quat=quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True),
            joint_pos=solution.qpos[:, self._geometry.qpos_index],
            contacts=_resting(self._geometry, targets, solution),
            foot_names=self.robot.foot_names,
        )


def retarget(
    motion: HumanMotion,
    robot: RobotDescription,
    *,
    fps: float = 50.0,
    balance: bool = True,
    solver: SolverName = "clip",
    keep_timing: bool = False,
    progress: Progress | None = None,
) -> RetargetResult:
    """Make a robot's trajectory of a human motion.

    The trajectory starts and ends in the robot's standing pose at rest, and keeps range, speed and acceleration limits
    of every joint exactly. What the robot cannot reach is left out and reported, never an error.

    Args:
        motion: the human motion.
        robot: the robot.
        fps: frame rate of the trajectory, Hz.
        balance: shift the body so that the ZMP stays over the feet. Flight (a jump) has no support to keep it in: the
            body then only moves on at constant velocity, and whether the robot lands is for physics to say.
        solver: see `Retargeter`.
        keep_timing: keep the human's pace also where a step leaves the robot no time to shift its weight.
        progress: is told how much is done.

    Raises:
        InvalidOption: `fps` is not a positive number.
        UnsupportedModel: the robot's model lacks something that retargeting needs.
        SolverFailed: not even a first pose was found.
    """
    return Retargeter(robot, solver).retarget(
        motion, fps=fps, balance=balance, keep_timing=keep_timing, progress=progress
    )


class _Passes:
    """Shares of passes over a clip as shares of all of them; fewer may be needed than were expected."""

    def __init__(self, progress: Progress | None, expected: int) -> None:
        self._progress, self._expected, self._done = progress, expected, -1

    def next(self) -> Progress:
        """What the next pass is to be told its share by."""
        self._done += 1
        return lambda share: self._tell((self._done + share) / self._expected)

    def finish(self) -> None:
        self._tell(1.0)

    def _tell(self, share: float) -> None:
        if self._progress is not None:
            self._progress(share)


def _resting(geometry: RobotGeometry, targets: Targets, solution: Solution) -> Bools:
    """(N, F) contacts of feet that do rest on their footholds; a foot that moves is no support."""
    return targets.contacts & ~solution.released & (solution.foot_error < 0.05 * geometry.ankle_height)


def _spent(efforts: Efforts) -> bool:
    """Whether no stretch may be solved again."""
    return bool(efforts) and all(effort.spent for effort in efforts.values())
