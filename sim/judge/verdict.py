"""The judge: one trajectory, one robot, one verdict."""

from dataclasses import dataclass

from ros_free_stack.errors import InvalidOption
from ros_free_stack.messages import Check, ControllerName, Level, Mount, RobotTrajectory, StateName, Verdict
from ros_free_stack.robot_model import size_scale
from ros_free_stack.robots import RobotDescription
from ros_free_stack.servo_path import servo_path
from ros_free_stack.thresholds import Threshold, limits_sha256, load_thresholds
from sim.judge.checks import balance, coherence, contact, joints, tracking
from sim.judge.robustness import Robustness, perturbed_runs
from sim.model import judging_model
from sim.playback.physics import FallLimits, Playback, play, set_stage
from sim.reference import Reference, check_belongs, make_reference

LONGEST_S = 600.0
"""A longer clip is refused: it would fill the memory before it gave an answer."""


@dataclass(frozen=True)
class Judgement:
    """A verdict with what the report draws: the reference's kinematics and, where physics ran, the playback."""

    verdict: Verdict
    reference: Reference
    playback: Playback | None

    @property
    def passed(self) -> bool:
        return self.verdict.passed


def judge(
    trajectory: RobotTrajectory,
    robot: RobotDescription,
    *,
    mount: Mount = "free",
    physics: bool = True,
    level: Level = "default",
    controller: ControllerName = "default",
    state: StateName = "true",
    perturbed: int = 0,
    seed: int = 0,
) -> Judgement:
    """Check a trajectory's kinematics and, with `physics`, play it in MuJoCo on the robot's own servos.

    What is judged, frame by frame, is its path at the rate of the servos (`ros_free_stack.servo_path`): frames of the
    checks, of the reference and of the playback are those of the path.

    Args:
        trajectory: what the robot should do; nothing in it is clipped or repaired.
        robot: the robot that it was made for.
        mount: `free` for a robot on the floor; `fixed` for one held by its root, for which floor, feet and balance
            do not count.
        physics: also simulate.
        level: how strict the limits are.
        controller: what moves the robot in the playback.
        state: what the controller reads in the nominal playback.
        perturbed: how many perturbed runs to play besides, for the success rate.
        seed: of the perturbed runs.

    Raises:
        ModelMismatch: the trajectory was made for another model.
        InvalidFile: the robot's model has a joint without an actuator.
        InvalidOption: the clip is too long, or `perturbed` is negative.
    """
    _check_arguments(trajectory, perturbed)
    mount = robot.mounted(mount)
    model = judging_model(robot)
    check_belongs(trajectory, robot)
    path = servo_path(trajectory, robot)
    reference = make_reference(path, robot, model)
    scale = size_scale(robot, model)
    limits = load_thresholds(level, scale=scale)
    checks = kinematic_checks(reference, limits, mount, scale)
    playback = None
    notes = [f"limits: {level}, for a robot of {scale:.2f} times G1's height"]
    if physics:
        fall = FallLimits(limits["fall_height"].limit, limits["fall_orientation"].limit)
        playback = play(set_stage(reference, mount=mount), fall, controller=controller, state=state)
        checks += playback_checks(reference, playback, limits, mount)
        notes.append(f"played by the {controller} controller on the {state} state")
        if playback.unsolved:
            notes.append(f"the controller found no solution in {playback.unsolved} cycles: the plan stood in")
        if playback.fell_at_s is not None:
            notes.append(f"fell at {playback.fell_at_s:.2f} s")
        if perturbed:
            found = perturbed_runs(path, robot, fall, runs=perturbed, seed=seed, mount=mount, controller=controller)
            checks.append(robustness_check(found, limits["robustness"]))
            notes.append(found.words())
    else:
        notes.append("physics playback was not run")
    verdict = Verdict(
        robot=robot.name,
        model_sha256=robot.sha256,
        trajectory_digest=trajectory.digest,
        checks=tuple(checks),
        notes=tuple(notes),
        physics=physics,
        mount=mount,
        controller=controller,
        state=state,
        level=level,
        limits_sha256=limits_sha256(limits),
        path_digest=path.digest,
    )
    return Judgement(verdict, reference, playback)


def _check_arguments(trajectory: RobotTrajectory, perturbed: int) -> None:
    if trajectory.duration_s > LONGEST_S:
        raise InvalidOption(
            "trajectory", f"lasts {trajectory.duration_s:.0f} s, expected at most {LONGEST_S:.0f} s: cut it into parts"
        )
    if perturbed < 0:
        raise InvalidOption("--perturbed", f"expected 0 or more runs, found {perturbed}")


def kinematic_checks(reference: Reference, limits: dict[str, Threshold], mount: Mount, scale: float) -> list[Check]:
    """Every check of the reference itself; those of floor and balance only for a robot that stands on its feet."""
    checks = [
        joints.joint_range(reference, limits["joint_range"]),
        joints.joint_velocity(reference, limits["joint_velocity"]),
        joints.joint_acceleration(reference, limits["joint_acceleration"]),
        joints.jerk(reference, limits["jerk"]),
        contact.self_collision(reference, limits["self_collision"]),
    ]
    if mount == "free":
        checks += [
            contact.ground_penetration(reference, limits["ground_penetration"]),
            contact.floating(reference, limits["floating"]),
            contact.foot_skate(reference, limits["foot_skate"]),
            contact.foot_skate_peak(reference, limits["foot_skate_peak"], scale=scale),
            balance.zmp_outside(reference, limits["zmp_outside"]),
        ]
    if not reference.robot.has_all_limbs:
        return checks
    return [
        *checks,
        coherence.temporal_coherence(reference, limits["temporal_coherence"]),
        coherence.spatial_coherence(reference, limits["spatial_coherence"]),
    ]


def playback_checks(
    reference: Reference, playback: Playback, limits: dict[str, Threshold], mount: Mount
) -> list[Check]:
    """Every check of a playback; electrical ones only where the motor's figures are known."""
    checks = [
        tracking.mpjpe_relative(reference, playback, limits["mpjpe_relative"]),
        tracking.joint_velocity_error(reference, playback, limits["joint_velocity_error"]),
        tracking.torque_peak(reference, playback, limits["torque_peak"]),
        tracking.torque_saturation(reference, playback, limits["torque_saturation"]),
    ]
    servos = reference.robot.servos
    if servos is not None and servos.motor is not None:
        checks += [
            tracking.power_peak(reference, playback, limits["power_peak"]),
            tracking.servo_heat(reference, playback, limits["servo_heat"]),
        ]
    if mount == "fixed":
        return checks
    return [
        tracking.fall_height(playback, limits["fall_height"]),
        tracking.fall_orientation(playback, limits["fall_orientation"]),
        tracking.mpjpe_global(reference, playback, limits["mpjpe_global"]),
        *checks,
    ]


def robustness_check(found: Robustness, threshold: Threshold) -> Check:
    """Share of the perturbed runs that did not fall; `sim.judge.robustness` says what is perturbed."""
    return threshold.check(
        "robustness",
        found.rate,
        "How often the robot stays up with another mass, friction, latency, a push and noisy sensors.",
    )
