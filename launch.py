#!/usr/bin/env python3
"""Command a humanoid by text: the composition root and command line, the only file that knows every stage."""

import importlib
import inspect
import os
import signal
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from time import perf_counter, sleep
from types import FrameType
from typing import TYPE_CHECKING, Annotated, Any, Literal, NoReturn, TypeVar

import tyro

from ros_free_stack.console import Command, progress, say
from ros_free_stack.errors import InvalidOption, StackError, UnknownName
from ros_free_stack.messages import HumanMotion, Mount, RobotTrajectory
from ros_free_stack.robots import RobotDescription, load_robot
from sim.cli import Validate as ValidateAlone

if TYPE_CHECKING:
    from generator.generate import MotionGenerator
    from generator.text.encoder import TextEncoder
    from retarget.report import RetargetReport
    from sim.verdict import Judgement

Stage = TypeVar("Stage")

INTERRUPTED = 130
MAX_CANDIDATES = 64
TELEMETRY = "telemetry.npz"

COMMANDS: dict[str, tuple[str, str]] = {
    "run": ("launch:Run", "a sentence to human motion, robot trajectory, verdict, pictures, servos"),
    "generate": ("generator.cli:Generate", "a sentence to human motion"),
    "retarget": ("retarget.cli:Retarget", "a human motion to a robot's trajectory"),
    "convert": ("ros_free_stack.formats.cli:Convert", "a motion file to another format"),
    "validate": ("launch:Validate", "judge a trajectory in MuJoCo, and repair it on request"),
    "render": ("sim.cli:Render", "draw a trajectory as a video"),
    "play": ("sim.play:Play", "show a motion in a window or a browser"),
    "stream": ("hw.cli:Stream", "play a validated trajectory on servos, real or virtual"),
    "data build": ("generator.data.cli:DataBuild", "make the training corpus"),
    "data show": ("generator.data.cli:DataShow", "draw one clip of the corpus"),
    "data coverage": ("generator.data.cli:DataCoverage", "what of real captions the corpus can say"),
    "ground": ("generator.grounding.cli:Ground", "where in a motion each part of a sentence happens"),
    "caption": ("generator.grounding.cli:Caption", "the texts that a motion's segments are most like"),
    "train": ("generator.cli:Train", "train a model of the generator"),
    "evaluate": ("generator.evaluation.cli:Evaluate", "measure the generator against real motion"),
    "robots list": ("ros_free_stack.cli:RobotsList", "the robots that are described"),
    "robots show": ("ros_free_stack.cli:RobotsShow", "one robot's joints and limits"),
    "robots add": ("retarget.describe.cli:RobotsAdd", "describe a robot from its MuJoCo model"),
    "servos scan": ("hw.cli:ServosScan", "which servos answer on a port"),
    "servos info": ("hw.cli:ServosInfo", "what each servo is and how it is set"),
    "servos read": ("hw.cli:ServosRead", "position, current, temperature, voltage of each servo"),
    "servos configure": ("hw.cli:ServosConfigure", "set servos up for the robot, changes shown first"),
    "servos calibrate": ("hw.cli:ServosCalibrate", "directions and zeros of a real rig"),
    "servos reboot": ("hw.cli:ServosReboot", "clear hardware errors"),
    "servos release": ("hw.cli:ServosRelease", "torque off"),
    "servos emulate": ("hw.virtual.cli:ServosEmulate", "an emulated bus for other programs"),
    "servos simulate": ("launch:Simulate", "an emulated bus whose servos move the robot in MuJoCo"),
    "doctor": ("ros_free_stack.cli:Doctor", "what this machine has and lacks"),
}
"""Subcommand to the module and class that does it, and one line of help. A stage is imported when it is asked for."""


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


@dataclass
class Timings:
    """Seconds spent in each stage."""

    seconds: dict[str, float] = field(default_factory=dict[str, float])

    @contextmanager
    def measure(self, stage: str) -> Iterator[None]:
        start = perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + perf_counter() - start


class Pipeline:
    """Text understanding, generator, retargeter and judge for one robot; models load once, for many prompts."""

    def __init__(
        self, robot: RobotDescription, *, llm: str | None = None, llm_model: str = "qwen3:8b", mount: Mount = "free"
    ) -> None:
        self.robot, self.llm, self.llm_model = robot, llm, llm_model
        self.mount: Mount = mount
        self._stages: dict[str, Any] = {}

    def segments(self, prompt: str, *, anyway: bool = False) -> tuple[tuple[str, ...], bool]:
        """The segment texts of a prompt in temporal order, and whether the model knows them all.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, or has too many actions.
            OutOfDomain: a segment is unknown to the model, unless `anyway`.
        """
        from generator.generate import WEIGHTS_FOLDER
        from generator.text.understanding import Understanding, segmenter

        understanding = self._stage(
            "understanding",
            lambda: Understanding(WEIGHTS_FOLDER, self._encoder, lambda: segmenter(self.llm, self.llm_model)),
        )
        understood = understanding.read(prompt, anyway=anyway)
        for note in understood.notes:
            say(note)
        return understood.segments, understood.known

    def generate(
        self, prompt: str, segments: tuple[str, ...], *, seed: int, candidates: int
    ) -> tuple[HumanMotion, ...]:
        """Human motions for a prompt."""
        return self._generator.generate(prompt, segments, seed=seed, candidates=candidates)

    def missing(self, motion: HumanMotion) -> tuple[str, ...]:
        """What a motion does not show of its segments' texts."""
        return self._generator.missing(motion)

    def distances(self, prompt: str, motions: tuple[HumanMotion, ...]) -> list[float]:
        """How far each motion is from its sentence."""
        from generator.ranking import Ranker

        return self._stage("ranker", Ranker.load).distances(prompt, motions).tolist()

    def retarget(self, motion: HumanMotion) -> tuple[RobotTrajectory, "RetargetReport"]:
        """The robot's trajectory of a human motion, and what had to be given up."""
        from retarget.pipeline import Retargeter

        retargeter = self._stage("retargeter", lambda: Retargeter(self.robot))
        result = retargeter.retarget(motion)
        return result.trajectory, result.report

    def judge(self, trajectory: RobotTrajectory) -> "Judgement":
        """The verdict on a trajectory, with its playback."""
        from sim.verdict import judge

        return judge(trajectory, self.robot, mount=self.mount)

    def repair(self, candidate: Candidate) -> Candidate:
        """The candidate, or what the ladder of other controllers and gentler motions makes of it."""
        from sim.repair import repair

        reports = {candidate.trajectory.digest: candidate.report}

        def retarget(motion: HumanMotion) -> RobotTrajectory:
            trajectory, reports[trajectory.digest] = self.retarget(motion)
            return trajectory

        found = repair(candidate.trajectory, self.robot, motion=candidate.motion, retarget=retarget, mount=self.mount)
        motion = found.motion or candidate.motion
        return Candidate(
            motion,
            candidate.missing,
            candidate.distance,
            found.trajectory,
            reports[found.trajectory.digest],
            found.judgement,
        )

    def candidates(
        self,
        prompt: str,
        segments: tuple[str, ...],
        *,
        seed: int,
        candidates: int,
        timings: Timings,
        repair: bool = False,
    ) -> tuple[Candidate, ...]:
        """Generate, retarget and judge; the preferred candidate comes first, repaired where none passes."""
        with timings.measure("generate"):
            motions = self.generate(prompt, segments, seed=seed, candidates=candidates)
            shown = [(motion, self.missing(motion)) for motion in motions]
            distances = self.distances(prompt, motions)
        found: list[Candidate] = []
        pairs = zip(shown, distances, strict=True)
        for (motion, missing), distance in progress(pairs, "retarget and judge", total=len(motions)):
            with timings.measure("retarget"):
                trajectory, report = self.retarget(motion)
            with timings.measure("validate"):
                found.append(Candidate(motion, missing, distance, trajectory, report, self.judge(trajectory)))
        found.sort(key=lambda candidate: candidate.order)
        if repair and not found[0].judgement.passed:
            with timings.measure("repair"):
                found[0] = self.repair(found[0])
        return tuple(found)

    @property
    def _generator(self) -> "MotionGenerator":
        from generator.generate import MotionGenerator

        return self._stage("generator", lambda: MotionGenerator.load(text_encoder=self._encoder()))

    def _encoder(self) -> "TextEncoder":
        from generator.text.encoder import TextEncoder

        return self._stage("encoder", TextEncoder)

    def _stage(self, name: str, make: Callable[[], Stage]) -> Stage:
        if name not in self._stages:
            self._stages[name] = make()
        return self._stages[name]


@dataclass(frozen=True, kw_only=True)
class Run(Command):
    """Turn a sentence into a robot's motion: generate, retarget, judge, draw, and stream on request.

    The exit code is 0 if a candidate passed every check, 3 if none did (the report says why).

    Examples:
        python launch.py run "a person waves with the right hand" --out out/
        python launch.py run "walks forward, then bows" --robot g1 --candidates 8 --seed 3
        python launch.py run "squats twice" --servo sim --json
        python launch.py run "claps" --servo /dev/ttyUSB0
        python launch.py run "waves" --servo /dev/ttyUSB0,/dev/ttyUSB1 --mount fixed --dry-run
    """

    prompt: Annotated[str, tyro.conf.Positional]
    """What the robot should do, in English."""
    robot: str = "op3"
    """Robot by name; `launch.py robots list` shows them."""
    out: Path = Path("out/run")
    """Run folder: motion, trajectory, verdict, telemetry of a stream, report.html, video.mp4."""
    seed: int = 0
    """Seed of all randomness: the same seed gives the same motion."""
    candidates: int = 4
    """How many motions to try; the best feasible one is kept."""
    repair: bool = True
    """Where no candidate passes, try whole-body control and a slower or smaller motion of the best one."""
    servo: str | None = None
    """Stream the result: `sim` for a virtual bus, or a serial port such as /dev/ttyUSB0 (several with commas)."""
    dry_run: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Check everything and read the servos, but write nothing to them."""
    mount: Literal["free", "fixed"] = "free"
    """`fixed` for a robot held by its root: floor and balance do not count, and only such a robot may play it."""
    joints: tuple[str, ...] | None = None
    """Stream only these joints, on a rig that has only these; the others are skipped."""
    calibration: Path | None = None
    """Servo directions, zeros and ranges (.yaml), as `servos calibrate` writes it."""
    video: Annotated[bool, tyro.conf.arg(help="Draw video.mp4 where a GL library is present.")] = True
    anyway: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Try a sentence outside what the model knows."""
    llm: str | None = None
    """Let a language model split the sentence: base address of an OpenAI-compatible endpoint."""
    llm_model: str = "qwen3:8b"
    """Name of the language model; RFS_LLM_KEY holds the key, if it needs one."""

    def run(self) -> int:
        from ros_free_stack.files import make_folder

        if not 1 <= self.candidates <= MAX_CANDIDATES:
            raise InvalidOption("--candidates", f"expected 1 to {MAX_CANDIDATES}, found {self.candidates}")
        robot = load_robot(self.robot)
        if self.servo is not None:
            from hw.stream import check_port

            check_port(self.servo, robot, joints=self.joints, calibration=self.calibration)
        elif self.dry_run or self.joints or self.calibration:
            raise InvalidOption("--servo", "is missing: --dry-run, --joints and --calibration are about servos")
        timings = Timings()
        pipeline = Pipeline(robot, llm=self.llm, llm_model=self.llm_model, mount=self.mount)
        with timings.measure("text"):
            segments, in_domain = pipeline.segments(self.prompt, anyway=self.anyway)
        make_folder(self.out)
        found = pipeline.candidates(
            self.prompt,
            segments,
            seed=self.seed,
            candidates=self.candidates,
            timings=timings,
            repair=self.repair,
        )
        best = found[0]
        files = self._save(best, timings)
        try:
            servo = self._stream(best, robot, timings)
        finally:
            # A stream that a fault ended is the one whose plots are wanted most.
            files |= self._report(best, robot, timings)
        verdict = best.judgement.verdict
        result = {
            "prompt": self.prompt,
            "robot": robot.name,
            "seed": self.seed,
            "segments": [asdict(segment) for segment in best.motion.segments],
            "in_domain": in_domain,
            "candidates": [candidate.as_dict() for candidate in found],
            "retarget": best.report.as_dict(),
            "verdict": {
                "passed": verdict.passed,
                "checks": [asdict(check) for check in verdict.checks],
                "notes": list(verdict.notes),
            },
            "servo": servo,
            "timings_s": {stage: round(seconds, 3) for stage, seconds in timings.seconds.items()},
            "files": files,
        }
        self.report(result, *self._words(best, found, servo))
        return 0 if verdict.passed else 3

    def _save(self, best: Candidate, timings: Timings) -> dict[str, str]:
        """Write motion, trajectory and verdict; what an earlier run left there must not pass for this one's."""
        from ros_free_stack.files import save_motion, save_trajectory, save_trajectory_csv, save_verdict

        for name in ("video.mp4", TELEMETRY):
            (self.out / name).unlink(missing_ok=True)
        with timings.measure("report"):
            save_motion(self.out / "human_motion.npz", best.motion)
            save_trajectory(self.out / "trajectory.npz", best.trajectory)
            save_trajectory_csv(self.out / "trajectory.csv", best.trajectory)
            save_verdict(self.out / "verdict.json", best.judgement.verdict)
        return self._files("human_motion.npz", "trajectory.npz", "trajectory.csv", "verdict.json")

    def _report(self, best: Candidate, robot: RobotDescription, timings: Timings) -> dict[str, str]:
        """Write report and video, with what the servos did where there was a stream."""
        from ros_free_stack.files import load_telemetry
        from sim.report import write_report

        path = self.out / TELEMETRY
        telemetry = load_telemetry(path) if path.exists() else None
        names = ["report.html", *([TELEMETRY] if telemetry else [])]
        with timings.measure("report"):
            write_report(self.out, best.motion, best.trajectory, best.judgement, robot, telemetry=telemetry)
        if self.video:
            with timings.measure("video"):
                names += self._video(best, robot)
        return self._files(*names)

    def _files(self, *names: str) -> dict[str, str]:
        return {name: str(self.out / name) for name in names}

    def _video(self, best: Candidate, robot: RobotDescription) -> list[str]:
        from ros_free_stack.errors import MissingDependency
        from sim.render import render_video

        try:
            render_video(self.out / "video.mp4", best.trajectory, best.judgement, robot, best.motion)
        except MissingDependency as error:
            say(f"no video: {error}")
            return []
        return ["video.mp4"]

    def _stream(self, best: Candidate, robot: RobotDescription, timings: Timings) -> dict[str, Any] | None:
        if self.servo is None:
            return None
        if not best.judgement.passed:
            say("nothing is streamed: no candidate passed")
            return None
        if best.judgement.verdict.controller == "wbc":
            say("nothing is streamed: only whole-body control keeps the robot up, and the servo driver has none")
            return None
        from hw.stream import stream

        with timings.measure("servo"):
            report = stream(
                best.trajectory,
                best.judgement.verdict,
                robot,
                port=self.servo,
                telemetry=self.out / TELEMETRY,
                dry_run=self.dry_run,
                calibration=self.calibration,
                joints=self.joints,
                mount=self.mount,
            )
        if report.skipped:
            say(f"skipped, not on this rig: {', '.join(report.skipped)}")
        return report.as_dict()

    def _words(self, best: Candidate, found: tuple[Candidate, ...], servo: dict[str, Any] | None) -> Iterator[str]:
        verdict = best.judgement.verdict
        for segment in best.motion.segments:
            yield f"{segment.start_s:5.2f} to {segment.end_s:5.2f} s  {segment.text}"
        yield from (f"not as asked: {line}" for line in best.missing)
        feasible = sum(candidate.judgement.passed for candidate in found)
        yield f"{feasible} of {len(found)} candidates are feasible on {verdict.robot}"
        yield from (note for note in verdict.notes if note.startswith(("changed", "tried")))
        for check in verdict.failures:
            yield f"failed {check.name}: {check.value:.3g} {check.unit}, limit {check.limit:.3g} {check.unit}"
        if servo is not None and self.dry_run:
            yield f"servos: dry run, {servo['joints']} servos on {servo['port']} are ready, nothing was written"
        elif servo is not None:
            yield (
                f"servos: {servo['cycles']} cycles at {servo['rate_hz']:.1f} Hz, "
                f"jitter p99 {servo['jitter_p99_ms']:.2f} ms, {len(servo['errors'])} errors"
            )
        yield f"verdict: {'PASSED' if verdict.passed else 'INFEASIBLE'}"
        yield f"report: {self.out / 'report.html'}"


@dataclass(frozen=True, kw_only=True)
class Validate(ValidateAlone):
    """Judge a trajectory: limits, contacts, coherence, and a playback in physics. Exit code 3 where it fails.

    Examples:
        python launch.py validate trajectory.npz --out out/
        python launch.py validate trajectory.npz --level strict --perturbed 20
        python launch.py validate trajectory.npz --motion human_motion.npz --repair --out out/
    """

    repair: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Where it fails, try whole-body control, then slower and smaller motions, retargeted anew; needs --motion.
    trajectory.npz and human_motion.npz of what was judged are written beside the verdict."""

    def run(self) -> int:
        if self.repair and (self.motion is None or self.out is None or not self.physics):
            raise InvalidOption("--repair", "needs the human motion (--motion), a folder (--out) and physics")
        return super().run()

    def _judge(
        self, trajectory: RobotTrajectory, motion: HumanMotion | None, robot: RobotDescription
    ) -> "tuple[RobotTrajectory, HumanMotion | None, Judgement]":
        if not self.repair or self.out is None:
            return super()._judge(trajectory, motion, robot)
        from retarget.pipeline import Retargeter
        from ros_free_stack.files import save_motion, save_trajectory
        from sim.repair import repair

        retargeter = Retargeter(robot)
        found = repair(
            trajectory,
            robot,
            motion=motion,
            retarget=lambda changed: retargeter.retarget(changed, fps=trajectory.fps).trajectory,
            mount=self.mount,
            level=self.level,
            perturbed=self.perturbed,
        )
        save_trajectory(self.out / "trajectory.npz", found.trajectory)
        if found.motion is not None:
            save_motion(self.out / "human_motion.npz", found.motion)
        return found.trajectory, found.motion, found.judgement


@dataclass(frozen=True, kw_only=True)
class Simulate(Command):
    """Run an emulated bus whose servos move the whole robot in MuJoCo until Ctrl-C, then write what it did.

    The robot stands, held, until the first servo is switched on.

    Examples:
        python launch.py servos simulate --out simulated.npz
        python launch.py stream out/run/trajectory.npz out/run/verdict.json --servo PORT
        python launch.py render simulated.npz
    """

    robot: str = "op3"
    """Robot by name."""
    mount: Literal["free", "fixed"] = "free"
    """`fixed` for a robot held by its root."""
    out: Path = Path("simulated.npz")
    """Trajectory of the robot, from the moment the first servo was switched on."""

    def run(self) -> int:
        from hw.virtual.bus import VirtualBus
        from ros_free_stack.files import save_trajectory
        from sim.servo_world import ServoWorld

        robot = load_robot(self.robot)
        world = ServoWorld(robot, mount=self.mount)
        bus = VirtualBus.of_robot(robot, timed=True, world=world)
        try:
            with bus:
                self.report({"port": bus.port, "out": str(self.out)}, bus.port)
                sys.stdout.flush()
                say("simulating; stop with Ctrl-C")
                while True:
                    sleep(3600)
        finally:
            if world.started:
                done = world.trajectory()
                save_trajectory(self.out, done)
                say(f"{self.out}: {done.duration_s:.1f} s, the root ended {done.root_pos[-1, 2]:.2f} m above the floor")
            else:
                say("no servo was ever switched on: nothing is written")


def usage(prefix: str = "") -> str:
    """The list of subcommands that begin with `prefix`."""
    rows = [f"  {name:17s} {words}" for name, (_, words) in COMMANDS.items() if name.startswith(prefix)]
    lines = [
        "usage: python launch.py COMMAND [options]      (COMMAND --help shows a command's options)",
        "",
        *rows,
        "",
        'example: python launch.py run "a person waves with the right hand" --robot op3 --servo sim --out out/',
    ]
    return "\n".join(lines)


def find_command(arguments: list[str]) -> tuple[str, list[str]]:
    """The subcommand that the arguments begin with, and the arguments that are left for it."""
    for words in (2, 1):
        name = " ".join(arguments[:words])
        if name in COMMANDS:
            return name, arguments[words:]
    raise UnknownName("command", arguments[0], COMMANDS)


def parse(name: str, arguments: list[str]) -> Command:
    """The subcommand's dataclass, filled from its arguments; imports only the stage that it belongs to."""
    module, class_name = COMMANDS[name][0].split(":")
    command_class: type[Command] = getattr(importlib.import_module(module), class_name)
    return tyro.cli(command_class, args=arguments, prog=f"launch.py {name}", description=inspect.getdoc(command_class))


def main(arguments: list[str]) -> int:
    """Run the command line: 0 done, 2 bad input, 3 infeasible, 4 hardware fault, 130 interrupted."""
    if not arguments or arguments[0] in ("-h", "--help"):
        print(usage())
        return 0
    group = f"{arguments[0]} "
    if arguments[1:] in ([], ["-h"], ["--help"]) and any(name.startswith(group) for name in COMMANDS):
        print(usage(prefix=group))
        return 0
    # PyTorch's threads spin while they wait, which makes it many times slower where cores are shared.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    previous = signal.signal(signal.SIGTERM, _terminate)
    try:
        return parse(*find_command(arguments)).run()
    except StackError as error:
        if "--debug" in arguments:
            traceback.print_exc()
        say(f"error: {error}")
        return error.exit_code
    except KeyboardInterrupt:
        say("interrupted")
        return INTERRUPTED
    finally:
        signal.signal(signal.SIGTERM, previous)


def _terminate(_number: int, _frame: FrameType | None) -> NoReturn:
    """SIGTERM unwinds like Ctrl-C, so that servos stop and temporary files go."""
    raise KeyboardInterrupt


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
