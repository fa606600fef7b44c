"""What retargeting could not keep, in words and numbers: limb errors, joints at their limits, feet that slipped."""

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from retarget.balance.com_plan import INSIDE_M
from retarget.body.geometry import RobotGeometry
from retarget.clip.runs import runs
from retarget.plan.targets import TRACKING_ERROR_SHARE, Targets
from retarget.solve.limits import active_limits
from retarget.solve.solution import Solution
from ros_free_stack.messages import Floats

WORTH_A_WORD = 0.02
"""Changes of pace and stride that are smaller than this share go without a word."""


@dataclass(frozen=True)
class Spread:
    """Mean and maximum over the frames of a clip."""

    mean: float
    max: float


@dataclass(frozen=True)
class TrackingError:
    """A limb that could not follow: when (s), by how many cm at worst, and the limits that joints were at meanwhile."""

    limb: str
    start_s: float
    end_s: float
    worst_cm: float
    joints: dict[str, tuple[str, ...]]

    def __str__(self) -> str:
        held = "; ".join(f"{joint}: {', '.join(limits)}" for joint, limits in self.joints.items())
        cause = f" (at the limit of {held})" if held else ""
        return f"{self.limb}: {self.worst_cm:.1f} cm off at {self.start_s:.2f} to {self.end_s:.2f} s{cause}"


@dataclass(frozen=True)
class RetargetReport:
    """The outcome of a retargeting.

    Attributes:
        position_error_cm: mean and largest error of every followed point and sole.
        limited_joints: share of frames in which each joint was held by its range, speed or acceleration limit.
        tracking_errors: limbs that could not follow their targets, and when.
        slipped_contact_s: time in which a standing foot could not be kept on its foothold, all feet together.
        flight_s: time without any foot on the floor; the balance pass leaves it as it is.
        stride_scale: travel over the floor, over that of the human at the robot's size; 1 where nothing was shortened.
        slowdown: time of the motion over the human's; 1 where nothing was slowed down.
        human_s: the human's time.
        unsolved_s: stretches (start, end) that the whole-clip solver left as they were before, as it found no better
            trajectory there; their limits hold all the same.
        solver_failures: quadratic programs without a solution: of a `frame`, which then goes on as the last one, and of
            the `balance`, which then stays as it was.
        zmp_outside_cm: how far the zero moment point leaves the support polygon, (mean, max), before and after
            balancing; None without the balance pass.
        zmp_outside_share: share of the frames in which it leaves it, before and after.
        timings_s: seconds of each step.
    """

    position_error_cm: dict[str, Spread]
    limited_joints: dict[str, float]
    tracking_errors: tuple[TrackingError, ...]
    slipped_contact_s: float
    flight_s: float
    stride_scale: float
    slowdown: float
    human_s: float
    unsolved_s: tuple[tuple[float, float], ...] = ()
    solver_failures: dict[str, int] = field(default_factory=dict[str, int])
    zmp_outside_cm: dict[str, Spread] | None = None
    zmp_outside_share: dict[str, float] | None = None
    timings_s: dict[str, float] = field(default_factory=dict[str, float])

    def changes(self) -> tuple[str, ...]:
        """One line for each change of pace and stride, with what undoes it."""
        lines: tuple[str, ...] = ()
        if self.slowdown > 1 + WORTH_A_WORD:
            robot_s = self.slowdown * self.human_s
            lines += (
                f"pace: {self.human_s:.1f} s of the person take the robot {robot_s:.1f} s, as its steps need time to "
                "shift the weight (--keep-timing keeps the person's pace)",
            )
        if self.stride_scale < 1 - WORTH_A_WORD:
            lines += (f"stride: steps are {100 * self.stride_scale:.0f} % of the person's at the robot's size",)
        return lines

    def failures(self) -> tuple[str, ...]:
        """One line for each kind of program that had no solution."""
        words = {
            "frame": "frames had no solution and went on as the one before",
            "balance": "plans of balance had no solution: the body leans as the person does",
        }
        return tuple(f"solver: {count} {words[kind]}" for kind, count in self.solver_failures.items())

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def limb_errors(geometry: RobotGeometry, solution: Solution) -> dict[str, np.ndarray]:
    """(N,) distance to the target in m of every followed point and sole."""
    errors = dict(zip(geometry.followed, solution.point_error.T, strict=True))
    soles = {f"{foot.name}_sole": error for foot, error in zip(geometry.feet, solution.foot_error.T, strict=True)}
    return errors | soles


def limb_chain(geometry: RobotGeometry, limb: str) -> set[str]:
    """The robot's joints that move a followed point or sole: those between it and the root.

    The root itself is moved by the legs that it stands on.
    """
    soles = {f"{foot.name}_sole": foot.body for foot in geometry.feet}
    model, root = geometry.model, int(geometry.model.body(geometry.robot.root_body).id)
    ends = [(geometry.bodies | soles)[limb]]
    if ends == [root]:
        ends = list(soles.values())
    above: set[int] = set()
    for end in ends:
        body = end
        while body not in (0, root):
            above.add(body)
            body = int(model.body_parentid[body])
    return {name for name in geometry.robot.joint_names if int(model.joint(name).bodyid[0]) in above}


def make_report(
    geometry: RobotGeometry,
    targets: Targets,
    solution: Solution,
    *,
    stride_scale: float,
    slowdown: float,
    human_s: float,
    unsolved: tuple[tuple[int, int], ...],
    solver_failures: dict[str, int],
    zmp_excess: dict[str, Floats] | None,
    timings_s: dict[str, float],
) -> RetargetReport:
    """Collect the report of a solved clip; `zmp_excess` holds (N,) by how many m the ZMP is outside, and when."""
    errors = limb_errors(geometry, solution)
    shares = solution.limited.mean(axis=0)
    return RetargetReport(
        position_error_cm={limb: _spread_cm(error) for limb, error in errors.items()},
        limited_joints={
            name: float(share) for name, share in zip(geometry.robot.joint_names, shares, strict=True) if share > 0
        },
        tracking_errors=tuple(_tracking_errors(geometry, targets, solution, errors)),
        slipped_contact_s=float(solution.released.sum()) / targets.fps,
        flight_s=0.0 if geometry.held else float((~targets.contacts.any(axis=1)).sum()) / targets.fps,
        stride_scale=stride_scale,
        slowdown=slowdown,
        human_s=human_s,
        unsolved_s=tuple((start / targets.fps, end / targets.fps) for start, end in unsolved),
        solver_failures=solver_failures,
        zmp_outside_cm=None if zmp_excess is None else {when: _spread_cm(e) for when, e in zmp_excess.items()},
        zmp_outside_share=None
        if zmp_excess is None
        else {when: float((e > INSIDE_M).mean()) for when, e in zmp_excess.items()},
        timings_s=timings_s,
    )


def _spread_cm(values: Floats) -> Spread:
    return Spread(100 * float(values.mean()), 100 * float(values.max()))


def _tracking_errors(
    geometry: RobotGeometry, targets: Targets, solution: Solution, errors: dict[str, np.ndarray]
) -> list[TrackingError]:
    threshold = TRACKING_ERROR_SHARE * geometry.limb_length
    limits = active_limits(geometry.robot, solution.qpos[:, geometry.qpos_index], targets.fps)
    found: list[TrackingError] = []
    for limb, error in errors.items():
        chain = limb_chain(geometry, limb)
        for start, end in runs(error > threshold):
            held = {kind: np.asarray(at[start:end].any(axis=0)) for kind, at in limits.items()}
            joints = {
                name: tuple(kind for kind in held if held[kind][j])
                for j, name in enumerate(geometry.robot.joint_names)
                if name in chain and any(at[j] for at in held.values())
            }
            worst = 100 * float(error[start:end].max())
            found.append(TrackingError(limb, start / targets.fps, end / targets.fps, worst, joints))
    return found
