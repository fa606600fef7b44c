"""The judge: one trajectory, one robot, one verdict."""

from dataclasses import dataclass

from ros_free_stack.messages import Check, RobotTrajectory, Verdict
from ros_free_stack.robots import RobotDescription
from sim.checks import coherence, contact, joints, tracking
from sim.humanoid import has_all_limbs
from sim.model import Mount, judging_model, size_scale
from sim.playback import Playback, play
from sim.reference import Reference, make_reference
from sim.thresholds import Level, Threshold, load_thresholds


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
) -> Judgement:
    """Check a trajectory's kinematics and, with `physics`, play it in MuJoCo on the robot's own servos.

    Args:
        trajectory: what the robot should do; nothing in it is clipped or repaired.
        robot: the robot that it was made for.
        mount: `free` for a robot on the floor; `fixed` for one held by its root, for which floor, feet and balance
            do not count.
        physics: also simulate.
        level: how strict the limits are.

    Raises:
        ModelMismatch: the trajectory was made for another model.
    """
    mount = robot.mounted(mount)
    model = judging_model(robot)
    reference = make_reference(trajectory, robot, model)
    scale = size_scale(robot, model)
    limits = load_thresholds(level, scale=scale)
    checks = _kinematic_checks(reference, limits, mount, scale)
    playback = None
    notes = [f"limits: {level}, for a robot of {scale:.2f} times G1's height"]
    if physics:
        playback = play(
            reference,
            mount=mount,
            fall_height=limits["fall_height"].limit,
            fall_orientation=limits["fall_orientation"].limit,
        )
        checks += _playback_checks(reference, playback, limits, mount)
        if playback.fell_at_s is not None:
            notes.append(f"fell at {playback.fell_at_s:.2f} s")
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
    )
    return Judgement(verdict, reference, playback)


def _kinematic_checks(reference: Reference, limits: dict[str, Threshold], mount: Mount, scale: float) -> list[Check]:
    checks = [
        joints.joint_range(reference, limits["joint_range"]),
        joints.joint_velocity(reference, limits["joint_velocity"]),
        joints.joint_acceleration(reference, limits["joint_acceleration"]),
        contact.self_collision(reference, limits["self_collision"]),
    ]
    if mount == "free":
        checks += [
            contact.ground_penetration(reference, limits["ground_penetration"]),
            contact.foot_skate(reference, limits["foot_skate"]),
            contact.foot_skate_peak(reference, limits["foot_skate_peak"], scale=scale),
        ]
    if not has_all_limbs(reference.robot):
        return checks
    return [
        *checks,
        coherence.temporal_coherence(reference, limits["temporal_coherence"]),
        coherence.spatial_coherence(reference, limits["spatial_coherence"]),
    ]


def _playback_checks(
    reference: Reference, playback: Playback, limits: dict[str, Threshold], mount: Mount
) -> list[Check]:
    checks = [
        tracking.mpjpe_relative(reference, playback, limits["mpjpe_relative"]),
        tracking.joint_velocity_error(reference, playback, limits["joint_velocity_error"]),
        tracking.torque_peak(reference, playback, limits["torque_peak"]),
        tracking.torque_saturation(reference, playback, limits["torque_saturation"]),
    ]
    if mount == "fixed":
        return checks
    return [
        tracking.fall_height(playback, limits["fall_height"]),
        tracking.fall_orientation(playback, limits["fall_orientation"]),
        tracking.mpjpe_global(reference, playback, limits["mpjpe_global"]),
        *checks,
    ]
