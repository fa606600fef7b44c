"""How many motions each controller plays without a fall, how sure the checks are, and what judging costs.

python benchmarks/playback.py --dataset data/corpus --cmu cmu_mocap --out out/playback
python benchmarks/playback.py --dataset data/corpus --robots op3 --clips 2 --perturbed 2 --controllers default

Authored clips of the validation and test splits with one action each, sorted into classes, and CMU's takes called
"walk", one a subject, the first seconds of each. Success means that the robot did not fall. Perturbed runs differ in
mass, friction, latency, a push and sensor noise, and read an estimated state; PD reads nothing. The checks of the
reference and those of the default controller's nominal playback that do not ask whether the robot stands are set
against whether it stood, for two halves of the clips: limits may be tuned on the first only. Times are of this process
alone. Trajectories and what each playback gave are kept under --out and read again, so a run that was broken off goes
on; delete what a change of the code made stale. Verdicts are formed anew with the present limits.
"""

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from time import process_time
from typing import Any, Final, TypeVar

import numpy as np
import tyro

from ros_free_stack.console import progress
from ros_free_stack.errors import InvalidFile
from ros_free_stack.files import load_trajectory, make_folder, save_trajectory, write_text
from ros_free_stack.messages import Check, ControllerName, HumanMotion, RobotTrajectory
from ros_free_stack.robot_model import size_scale
from ros_free_stack.robots import RobotDescription, load_robot
from ros_free_stack.skeleton import FPS
from ros_free_stack.thresholds import load_thresholds
from sim.judge.repair import BALANCE_CHECKS
from sim.judge.robustness import draw, wilson
from sim.judge.verdict import kinematic_checks, playback_checks
from sim.model import judging_model
from sim.playback.controllers import CONTROLLERS
from sim.playback.physics import FallLimits, Stage, play, set_stage
from sim.reference import Reference, make_reference

CLASSES: Final = {
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
WALK: Final = "CMU walk"

T = TypeVar("T")


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
    perturbed_controllers: tuple[ControllerName, ...] = CONTROLLERS
    """Controllers that are played perturbed."""
    perturbed_clips: int = 1000
    """Clips a class that are played perturbed."""
    out: Path = Path("out/playback")
    """Folder for tables.md, the trajectories and the results."""


@dataclass(frozen=True)
class Item:
    """One motion on one robot, and what became of it.

    Attributes:
        kind: its class.
        half: 0 for the clips on which limits may be tuned, 1 for those that report.
        checks: `value` of each check of the reference and of the default controller's nominal playback.
        fell_at_s: by controller, of the nominal playback; None where it stood.
        perturbed: by controller, the same of each perturbed run.
        cost_s: by part, s of this process a second of motion.
    """

    robot: str
    kind: str
    clip: str
    half: int
    scale: float
    checks: dict[str, float]
    fell_at_s: dict[str, float | None]
    perturbed: dict[str, list[float | None]]
    cost_s: dict[str, float]

    @property
    def stood(self) -> bool:
        return self.fell_at_s["default"] is None

    def refused_by(self) -> list[str]:
        """Names of the checks other than those of standing and tracking that refuse the motion at present."""
        limits = load_thresholds("default", scale=self.scale)
        values = ((name, value) for name, value in self.checks.items() if name not in BALANCE_CHECKS)
        return [name for name, value in values if not limits[name].check(name, value, "").passed]


class Judged:
    """A trajectory on its robot, made ready for playbacks where something is played."""

    def __init__(self, trajectory: RobotTrajectory, robot: RobotDescription) -> None:
        self._trajectory, self._robot, self._model = trajectory, robot, judging_model(robot)
        self.scale, self.cost_s = size_scale(robot, self._model), dict[str, float]()
        self._limits = load_thresholds("default", scale=self.scale)
        self._fall = FallLimits(self._limits["fall_height"].limit, self._limits["fall_orientation"].limit)

    @cached_property
    def _reference(self) -> Reference:
        return self._timed(
            "place bodies, find contacts", lambda: make_reference(self._trajectory, self._robot, self._model)
        )

    @cached_property
    def _stage(self) -> Stage:
        return self._timed("inverse dynamics", lambda: set_stage(self._reference))

    def reference(self) -> dict[str, Any]:
        """Values of the reference's checks, and what they and the preparation of a playback cost."""
        reference = self._reference
        checks = self._timed("checks", lambda: kinematic_checks(reference, self._limits, "free", self.scale))
        _ = self._stage
        return {"checks": _values(checks), "cost_s": self.cost_s}

    def nominal(self, controller: ControllerName) -> dict[str, Any]:
        """When it fell, and the values of the playback's checks."""
        part, stage = f"simulate, {controller}", self._stage
        playback = self._timed(part, lambda: play(stage, self._fall, controller=controller))
        checks = playback_checks(stage.reference, playback, self._limits, "free")
        cost_s = {part: self.cost_s[part]}
        return {"fell_at_s": playback.fell_at_s, "checks": _values(checks), "cost_s": cost_s}

    def perturbed(self, controller: ControllerName, runs: int) -> list[float | None]:
        """When each run fell; None where it stood."""
        stage = self._stage
        return [
            play(stage, self._fall, controller=controller, state="estimated", disturbance=draw(stage, seed)).fell_at_s
            for seed in range(runs)
        ]

    def _timed(self, part: str, make: Callable[[], T]) -> T:
        began = process_time()
        made = make()
        self.cost_s[part] = (process_time() - began) / self._trajectory.duration_s
        return made


def _values(checks: Iterable[Check]) -> dict[str, float]:
    return {check.name: check.value for check in checks}


def motions(arguments: Arguments) -> Iterator[tuple[str, str, HumanMotion]]:
    """Class, name and motion."""
    if arguments.dataset:
        from generator.datasets.authored import AuthoredCorpus
        from ros_free_stack.formats.features import decode

        dataset = AuthoredCorpus.open(arguments.dataset)
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


def measure(
    arguments: Arguments, robot: RobotDescription, kind: str, clip: str, place: int, trajectory: RobotTrajectory
) -> Item:
    """Check and play one trajectory, the `place`-th of its class."""
    judged = Judged(trajectory, robot)

    def kept(what: str, make: Callable[[], Any]) -> Any:
        path = arguments.out / "results" / f"{robot.name}-{clip}-{what}.json"
        if not path.is_file():
            write_text(path, json.dumps(make()))
        return json.loads(path.read_text(encoding="utf-8"))

    reference = kept("reference", judged.reference)
    nominal = {name: kept(name, lambda name=name: judged.nominal(name)) for name in arguments.controllers}
    shaken: list[ControllerName] = [name for name in arguments.perturbed_controllers if name in nominal]
    runs = arguments.perturbed if place < arguments.perturbed_clips else 0
    costs = [reference["cost_s"], *(item["cost_s"] for item in nominal.values())]
    return Item(
        robot=robot.name,
        kind=kind,
        clip=clip,
        half=place // 2 % 2,  # neighbours are a motion and its mirror image
        scale=judged.scale,
        checks=reference["checks"] | nominal.get("default", {}).get("checks", {}),
        fell_at_s={name: item["fell_at_s"] for name, item in nominal.items()},
        perturbed={
            name: kept(f"{name}-{runs}", lambda name=name: judged.perturbed(name, runs)) for name in shaken if runs
        },
        cost_s={part: seconds for cost in costs for part, seconds in cost.items()},
    )


def tables(arguments: Arguments, items: list[Item]) -> str:
    """All tables as Markdown."""
    parts = [_success(arguments, items)]
    if "default" in arguments.controllers:
        parts += [_confusion(arguments, items), _blame(items)]
    return "\n".join([*parts, _costs(arguments, items)])


def _success(arguments: Arguments, items: list[Item]) -> str:
    """Nominal successes, then perturbed ones with their interval."""
    rows: list[tuple[str, ...]] = [("robot", "class", *arguments.controllers)]
    for robot in arguments.robots:
        for kind in (*CLASSES, WALK):
            of_kind = [item for item in items if (item.robot, item.kind) == (robot, kind)]
            if of_kind:
                rows.append((robot, kind, *(_cell(of_kind, name) for name in arguments.controllers)))
    return _markdown(rows)


def _cell(items: list[Item], controller: str) -> str:
    words = f"{sum(item.fell_at_s[controller] is None for item in items)}/{len(items)}"
    runs = [fell for item in items for fell in item.perturbed.get(controller, ())]
    if not runs:
        return words
    low, high = wilson(runs.count(None), len(runs))
    return f"{words}; {runs.count(None)}/{len(runs)} ({low:.0%} to {high:.0%})"


def _confusion(arguments: Arguments, items: list[Item]) -> str:
    """Whether the checks that do not ask for standing pass, against whether the robot stood."""
    pairs = {(True, True): "passed, stood", (True, False): "passed, fell"}
    pairs |= {(False, True): "failed, stood", (False, False): "failed, fell"}
    rows: list[tuple[str, ...]] = [("robot", "half", *pairs.values())]
    for robot in arguments.robots:
        for half, name in enumerate(("first", "second")):
            found = [(not i.refused_by(), i.stood) for i in items if (i.robot, i.half) == (robot, half)]
            rows.append((robot, name, *(str(found.count(pair)) for pair in pairs)))
    return _markdown(rows)


def _blame(items: list[Item]) -> str:
    """Which checks refused, and how many of those motions stood."""
    refused = [(name, item) for item in items for name in item.refused_by()]
    rows: list[tuple[str, ...]] = [
        ("check that refused", "first half: stood / fell", "second: stood / fell", "values where it stood")
    ]
    for check in sorted({name for name, _ in refused}):
        halves = [[item for name, item in refused if name == check and item.half == half] for half in (0, 1)]
        counts = [f"{sum(i.stood for i in half)} / {sum(not i.stood for i in half)}" for half in halves]
        stood = sorted(item.checks[check] for half in halves for item in half if item.stood)
        rows.append((check, *counts, ", ".join(f"{value:.3g}" for value in stood)))
    return _markdown(rows)


def _costs(arguments: Arguments, items: list[Item]) -> str:
    rows: list[tuple[str, ...]] = [("robot", "part", "ms a motion second", "times real time")]
    for robot in arguments.robots:
        costs = [item.cost_s for item in items if item.robot == robot]
        for part in costs[0] if costs else ():
            mean = float(np.mean([cost[part] for cost in costs]))
            rows.append((robot, part, f"{1e3 * mean:.1f}", f"{1 / mean:.0f}"))
    return _markdown(rows)


def _markdown(rows: list[tuple[str, ...]]) -> str:
    head, *body = [f"| {' | '.join(row)} |" for row in rows]
    return "\n".join([head, "|---" * len(rows[0]) + "|", *body, ""])


def main(arguments: Arguments) -> None:
    """Measure robot by robot; the tables are written anew after each."""
    for folder in ("trajectories", "results"):
        make_folder(arguments.out / folder)
    found = list(motions(arguments))
    items: list[Item] = []
    for name in arguments.robots:
        robot, seen = load_robot(name), list[str]()
        for kind, clip, trajectory in progress(trajectories(arguments, robot, found), name, total=len(found)):
            items.append(measure(arguments, robot, kind, clip, seen.count(kind), trajectory))
            seen.append(kind)
        write_text(arguments.out / "tables.md", tables(arguments, items))
    print(tables(arguments, items))


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
