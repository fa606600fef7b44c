"""The gate to the servos: a trajectory goes through with a passing verdict for exactly what the driver will do.

The verdict's own word counts for nothing here: whether each check passed is worked out from its numbers, the limits are
compared with those of this robot, and every check that the mount requires must be there.
"""

from typing import Final

from ros_free_stack.criteria import limits_of, required_checks
from ros_free_stack.errors import ModelMismatch, UnsafeCommand
from ros_free_stack.messages import Check, ControllerName, Level, Mount, RobotTrajectory, Verdict
from ros_free_stack.robots import RobotDescription
from ros_free_stack.servo_path import servo_path
from ros_free_stack.thresholds import Threshold, limits_sha256

DRIVEN: Final[ControllerName] = "pd"
"""The controller that the driver runs: the reference's angles as goals, without feedforward or feedback."""

LEVELS: Final[tuple[Level, ...]] = ("strict", "default")
"""Levels whose verdicts open the way."""

_JUDGE = f"`validate --controller {DRIVEN}`"


def let_through(
    trajectory: RobotTrajectory, verdict: Verdict, robot: RobotDescription, mount: Mount
) -> RobotTrajectory:
    """The servo path of a trajectory that was judged feasible for this robot, as it stands and as its driver moves it.

    It is the very path that was judged, made anew. A verdict for a robot that stands free also holds for one that hangs
    from a stand; not the other way round.

    Raises:
        ModelMismatch: the trajectory was made for another robot or model.
        UnsafeCommand: the verdict did not pass; is of another trajectory, path, model, mount, controller or set of
            limits; is lenient; was made without physics; lacks a check; or contradicts its own numbers.
    """
    _check_identity(trajectory, verdict, robot)
    _check_mode(verdict, mount)
    required = required_checks(robot, verdict.mount)
    _check_numbers(verdict, required, limits_of(robot, verdict.level))
    path = servo_path(trajectory, robot)
    if verdict.path_digest != path.digest:
        raise UnsafeCommand(f"the verdict is of another path between the frames than the driver takes: {_again()}")
    return path


def _check_identity(trajectory: RobotTrajectory, verdict: Verdict, robot: RobotDescription) -> None:
    if trajectory.robot != robot.name or trajectory.model_sha256 != robot.sha256:
        raise ModelMismatch(
            f"the trajectory was made for {trajectory.robot} (model {trajectory.model_sha256[:12]}), "
            f"not for this {robot.name} (model {robot.sha256[:12]}): retarget and judge it again"
        )
    if verdict.robot != robot.name:
        raise UnsafeCommand(f"the verdict is of {verdict.robot}, not of {robot.name}: judge this trajectory first")
    if verdict.trajectory_digest != trajectory.digest or verdict.model_sha256 != robot.sha256:
        raise UnsafeCommand("the verdict is of another trajectory or model: judge this trajectory first")


def _check_mode(verdict: Verdict, mount: Mount) -> None:
    """Whether the judge did what the driver is about to do."""
    if not verdict.physics:
        raise UnsafeCommand("the verdict was made without physics: judge the trajectory with its playback")
    if verdict.level not in LEVELS:
        raise UnsafeCommand(
            f"the verdict's limits are {verdict.level}: servos take {' or '.join(LEVELS)}, judge with `--level default`"
        )
    if verdict.mount == "fixed" and mount == "free":
        raise UnsafeCommand(
            "the verdict is for a robot held by its root, whose balance nobody judged: hang it up and use --mount fixed"
        )
    if verdict.controller != DRIVEN:
        raise UnsafeCommand(
            f"the verdict holds for the {verdict.controller} controller, and the servo driver streams plain angles: "
            f"judge with {_JUDGE}; a robot that only feedback keeps up can play it hung up, with --mount fixed"
        )


def _check_numbers(verdict: Verdict, required: tuple[str, ...], limits: dict[str, Threshold]) -> None:
    """Whether every check is there, once, with this robot's limit and a value within it."""
    if not verdict.checks:
        raise UnsafeCommand("the verdict did not pass (it holds no check): only a feasible motion is streamed")
    names = [check.name for check in verdict.checks]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise UnsafeCommand(f"the verdict holds {', '.join(twice)} more than once: {_again()}")
    if unknown := [name for name in names if name not in limits]:
        raise UnsafeCommand(f"the verdict holds checks that there are not ({', '.join(unknown)}): {_again()}")
    if failed := [check.name for check in verdict.checks if not check.passed]:
        raise UnsafeCommand(f"the verdict did not pass ({', '.join(failed)}): only a feasible motion is streamed")
    for check in verdict.checks:
        _check_one(check, limits[check.name])
    if verdict.limits_sha256 != limits_sha256(limits):
        raise UnsafeCommand(f"the verdict was made with other limits than those of {verdict.robot} now: {_again()}")
    if missing := [name for name in required if name not in names]:
        raise UnsafeCommand(f"the verdict lacks {', '.join(missing)}: {_again()}")


def _check_one(check: Check, limit: Threshold) -> None:
    if (check.limit, check.minimum, check.unit) != (limit.limit, limit.minimum, limit.unit):
        sense = "at least" if limit.minimum else "at most"
        raise UnsafeCommand(
            f"the verdict's limit of {check.name} is not this robot's, {sense} {limit.limit:g} {limit.unit}: {_again()}"
        )
    if not check.holds:
        raise UnsafeCommand(
            f"the verdict says that {check.name} passed, and its numbers do not "
            f"({check.value:g} {check.unit} against {check.limit:g}): {_again()}"
        )


def _again() -> str:
    return f"judge the trajectory again with {_JUDGE}"
