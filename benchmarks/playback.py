"""How many motions each controller plays without a fall, how sure the checks are, and what judging costs.

python benchmarks/playback.py --dataset data/corpus --cmu cmu_mocap --out out/playback
python benchmarks/playback.py --dataset data/corpus --robots op3 --clips 2 --perturbed 2 --controllers default

Authored clips of the validation and test splits with one action each, sorted into classes, and CMU's takes called
"walk", one a subject, the first seconds of each. Success means that the robot did not fall. Perturbed runs differ in
mass, friction, latency, a push and sensor noise, and read an estimated state; PD reads nothing. The confusion table
sets the verdict of the reference's own checks (no simulation) against the default controller's nominal playback, for
two halves of the clips: limits may be tuned on the first only. Times are of this process alone. Trajectories are kept
under --out and read again.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import process_time

import tyro

from ros_free_stack.console import progress, say
from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import load_trajectory, make_folder, save_trajectory, write_text
from ros_free_stack.messages import ControllerName, HumanMotion, RobotTrajectory
from ros_free_stack.robots import RobotDescription, load_robot
from ros_free_stack.skeleton import FPS
from sim.controllers import CONTROLLERS
from sim.model import judging_model, size_scale
from sim.playback import FallLimits, Stage, play, set_stage
from sim.reference import make_reference
from sim.robustness import draw, wilson
from sim.thresholds import load_thresholds
from sim.verdict import kinematic_checks

CLASSES = {
    "gesture": ("wave", "raise_arm", "clap", "point", "salute", "reach", "punch"),
    "bow": ("bow", "bend_forward"),
    "squat": ("squat", "crouch"),
    "weight shift": ("lean", "bounce", "sway"),
    "step": ("step",),
    "turn": ("turn",),
    "slow walk": ("walk",),
    "one leg": ("balance", "knee_lift"),
    "slow kick": ("swing_leg", "kick"),
}
WALK = "CMU walk"


@dataclass(frozen=True)
class Arguments:
    """Play motions with every controller on every robot and write tables."""

    dataset: Path | None = None
    """Folder of a motion data set."""
    cmu: Path | None = None
    """Folder of CMU takes."""
    robots: tuple[str, ...] = ("op3", "g1", "t1", "h1")
    """Robots by name."""
    controllers: tuple[ControllerName, ...] = CONTROLLERS
    """Controllers."""
    clips: int = 7
    """Authored clips a class."""
    walks: int = 12
    """CMU walks."""
    walk_s: float = 6.0
    """Seconds of each walk."""
    perturbed: int = 20
    """Perturbed runs of each motion and controller."""
    out: Path = Path("out/playback")
    """Folder for tables.md and the trajectories."""


@dataclass
class Tally:
    """Runs and successes, and seconds spent a second of motion."""

    nominal: list[bool] = field(default_factory=list[bool])
    perturbed: list[bool] = field(default_factory=list[bool])
    seconds: list[float] = field(default_factory=list[float])

    def cell(self) -> str:
        """Nominal successes, then perturbed ones with their interval."""
        words = f"{sum(self.nominal)}/{len(self.nominal)}"
        if self.perturbed:
            low, high = wilson(sum(self.perturbed), len(self.perturbed))
            words += f"; {sum(self.perturbed)}/{len(self.perturbed)} ({low:.0%} to {high:.0%})"
        return words


@dataclass
class Results:
    """Everything that is counted."""

    tallies: dict[tuple[str, str, str], Tally] = field(default_factory=lambda: defaultdict(Tally))
    costs: dict[tuple[str, str], list[float]] = field(default_factory=lambda: defaultdict(list))
    verdicts: dict[int, list[tuple[bool, bool]]] = field(default_factory=lambda: defaultdict(list))
    blamed: dict[str, int] = field(default_factory=lambda: defaultdict(int))


def motions(arguments: Arguments) -> Iterator[tuple[str, str, HumanMotion]]:
    """Class, name and motion."""
    if arguments.dataset:
        from generator.data.dataset import MotionDataset
        from ros_free_stack.formats.features import decode

        dataset = MotionDataset.open(arguments.dataset)
        clips = [clip for split in ("test", "val") for clip in dataset.split(split)]
        single = [c for c in clips if c.source == "authored" and len(c.segments) == len(c.segments[0].actions) == 1]
        for kind, names in CLASSES.items():
            found = [clip for clip in single if clip.segments[0].actions[0][0] in names]
            for clip in found[: arguments.clips]:
                joints = decode(dataset.features(clip).astype(float))
                yield kind, clip.id, HumanMotion(joints, FPS, clip.segments[0].text)
    if arguments.cmu:
        from ros_free_stack.formats import cmu

        takes = [take for take in cmu.index(arguments.cmu) if take.description == "walk"]
        subjects = {take.subject: take for take in reversed(takes)}
        for take in sorted(subjects.values(), key=lambda take: take.name)[: arguments.walks]:
            joints = cmu.read_take(arguments.cmu, take.name)[: round(arguments.walk_s * FPS)]
            yield WALK, take.name, HumanMotion(joints, FPS, "walk")


def trajectories(
    arguments: Arguments, robot: RobotDescription, found: Iterable[tuple[str, str, HumanMotion]]
) -> Iterator[tuple[str, str, RobotTrajectory]]:
    """Class, name and trajectory of each motion; kept ones are read."""
    from retarget.pipeline import Retargeter

    retargeter = None
    for kind, name, motion in found:
        path = arguments.out / "trajectories" / f"{robot.name}-{name}.npz"
        try:
            trajectory = load_trajectory(path)
        except InvalidFile:
            trajectory = None
        if trajectory is None or trajectory.model_sha256 != robot.sha256:
            retargeter = retargeter or Retargeter(robot)
            trajectory = retargeter.retarget(motion).trajectory
            save_trajectory(path, trajectory)
        yield kind, name, trajectory


def measure(arguments: Arguments, robot: RobotDescription, kind: str, trajectory: RobotTrajectory, half: int,
            results: Results) -> None:  # fmt: skip
    """Check and play one trajectory, and add what came out."""
    model, duration = judging_model(robot), trajectory.duration_s
    scale = size_scale(robot, model)
    limits = load_thresholds("default", scale=scale)
    fall = FallLimits(limits["fall_height"].limit, limits["fall_orientation"].limit)
    started = process_time()
    reference = make_reference(trajectory, robot, model)
    placed = process_time()
    failed = [check.name for check in kinematic_checks(reference, limits, "free", scale) if not check.passed]
    checked = process_time()
    stage = set_stage(reference)
    planned = process_time()
    for part, seconds in (
        ("place bodies, find contacts", placed - started),
        ("checks", checked - placed),
        ("inverse dynamics", planned - checked),
    ):
        results.costs[robot.name, part].append(seconds / duration)
    for controller in arguments.controllers:
        tally = results.tallies[robot.name, kind, controller]
        began = process_time()
        stood = stands(stage, fall, controller, None)
        results.costs[robot.name, f"simulate, {controller}"].append((process_time() - began) / duration)
        tally.nominal.append(stood)
        tally.perturbed += [stands(stage, fall, controller, seed) for seed in range(arguments.perturbed)]
        if controller == "default":
            results.verdicts[half].append((not failed, stood))
            for name in failed if stood else ():
                results.blamed[name] += 1


def stands(stage: Stage, fall: FallLimits, controller: ControllerName, seed: int | None) -> bool:
    """Whether the robot stays up, nominally or under the disturbance of that seed."""
    if seed is None:
        return play(stage, fall, controller=controller).fell_at_s is None
    disturbance = draw(stage, seed)
    return play(stage, fall, controller=controller, state="estimated", disturbance=disturbance).fell_at_s is None


def tables(arguments: Arguments, results: Results) -> str:
    """All tables as Markdown."""
    lines = [
        f"| robot | class | {' | '.join(arguments.controllers)} |",
        "|---" * (2 + len(arguments.controllers)) + "|",
    ]
    kinds = [*CLASSES, WALK]
    for robot in arguments.robots:
        for kind in kinds:
            cells = [results.tallies[robot, kind, name] for name in arguments.controllers]
            if cells[0].nominal:
                lines.append(f"| {robot} | {kind} | {' | '.join(cell.cell() for cell in cells)} |")
    lines += ["", "| robot | part | ms a motion second | times real time |", "|---|---|---|---|"]
    for (robot, part), seconds in results.costs.items():
        mean = sum(seconds) / len(seconds)
        lines.append(f"| {robot} | {part} | {1e3 * mean:.1f} | {1 / mean:.0f} |")
    lines += ["", "| half | passed, stood | passed, fell | failed, stood | failed, fell |", "|---|---|---|---|---|"]
    for half, pairs in sorted(results.verdicts.items()):
        counts = [pairs.count(pair) for pair in ((True, True), (True, False), (False, True), (False, False))]
        lines.append(f"| {'first' if half == 0 else 'second'} | {' | '.join(map(str, counts))} |")
    blamed = ", ".join(f"{name} {count}" for name, count in results.blamed.items()) or "none"
    return "\n".join([*lines, "", f"Checks that refused a motion that stood: {blamed}.", ""])


def main(arguments: Arguments) -> None:
    """Measure robot by robot; the tables are written anew after each motion."""
    make_folder(arguments.out / "trajectories")
    found = list(motions(arguments))
    results = Results()
    for name in arguments.robots:
        robot = load_robot(name)
        made = trajectories(arguments, robot, found)
        for index, (kind, clip, trajectory) in enumerate(progress(made, name, total=len(found))):
            measure(arguments, robot, kind, trajectory, index % 2, results)
            say(f"{name} {kind} {clip}")
            write_text(arguments.out / "tables.md", tables(arguments, results))
    print(tables(arguments, results))


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
