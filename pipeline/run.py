"""The `run` subcommand: a sentence to a run folder, and on request to servos."""

import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Annotated, Any, Literal

import tyro

from pipeline.candidate import Candidate
from pipeline.pipeline import Pipeline
from pipeline.timings import Timings
from ros_free_stack.console import Command, say
from ros_free_stack.errors import InvalidOption
from ros_free_stack.messages import ControllerName
from ros_free_stack.robots import RobotDescription, load_robot

MAX_CANDIDATES = 64
TELEMETRY = "telemetry.npz"


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
    """How many motions to try at most, in the order in which they show the sentence, until one is feasible."""
    exhaustive: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Judge all candidates, though one has passed: the report then says how many are feasible."""
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
    generator: str = "segmo"
    """Which generator makes the motion: `segmo` comes with the program."""
    llm: str | None = None
    """Let a language model split the sentence: base address of an OpenAI-compatible endpoint."""
    llm_model: str = "qwen3:8b"
    """Name of the language model; RFS_LLM_KEY holds the key, if it needs one."""

    def run(self) -> int:
        from generator.text.prompt import check_prompt
        from ros_free_stack.files import check_folder, make_folder

        started = perf_counter()
        check_prompt(self.prompt)  # before anything that loads slowly
        check_folder(self.out)
        if not 1 <= self.candidates <= MAX_CANDIDATES:
            raise InvalidOption("--candidates", f"expected 1 to {MAX_CANDIDATES}, found {self.candidates}")
        robot = load_robot(self.robot)
        if self.servo is not None:
            from hw.stream import check_port

            check_port(self.servo, robot, joints=self.joints, calibration=self.calibration)
        elif self.dry_run or self.joints or self.calibration:
            raise InvalidOption("--servo", "is missing: --dry-run, --joints and --calibration are about servos")
        timings = Timings()
        pipeline = Pipeline(
            robot,
            llm=self.llm,
            llm_model=self.llm_model,
            mount=self.mount,
            controller=self._controller(),
            generator=self.generator,
        )
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
            exhaustive=self.exhaustive,
        )
        best = found[0]
        timings.seconds["to_verdict"] = perf_counter() - started
        searched = self._searched(found)
        self._tell(*self._verdict_words(best, searched))
        files = self._save(best, timings)
        if self.servo is not None and not best.judgement.passed:
            self._say_why_not(best, pipeline)
        try:
            servo = self._stream(best, robot, timings)
        finally:
            # A stream that a fault ended is the one whose plots are wanted most.
            files |= self._report(best, robot, timings, searched)
        verdict = best.judgement.verdict
        result = {
            "prompt": self.prompt,
            "robot": robot.name,
            "seed": self.seed,
            "segments": [asdict(segment) for segment in best.motion.segments],
            "in_domain": in_domain,
            "search": {"candidates": self.candidates, "judged": len(found), "exhaustive": self.exhaustive},
            "candidates": [candidate.as_dict() for candidate in found],
            "retarget": best.report.as_dict(),
            "verdict": {
                "passed": verdict.passed,
                "controller": verdict.controller,
                "checks": [asdict(check) for check in verdict.checks],
                "notes": list(verdict.notes),
            },
            "servo": servo,
            "timings_s": {stage: round(seconds, 3) for stage, seconds in timings.seconds.items()},
            "files": files,
        }
        self.report(result, *self._closing_words(servo))
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

    def _report(self, best: Candidate, robot: RobotDescription, timings: Timings, searched: str) -> dict[str, str]:
        """Write report and video, with what the servos did where there was a stream."""
        from ros_free_stack.files import load_telemetry
        from sim.draw.report import write_report

        path = self.out / TELEMETRY
        telemetry = load_telemetry(path) if path.exists() else None
        names = ["report.html", *([TELEMETRY] if telemetry else [])]
        with timings.measure("report"):
            write_report(
                self.out,
                best.motion,
                best.trajectory,
                best.judgement,
                robot,
                telemetry=telemetry,
                timings=dict(timings.seconds),
                notes=(searched,),
            )
        if self.video:
            with timings.measure("video"):
                names += self._video(best, robot)
        return self._files(*names)

    def _files(self, *names: str) -> dict[str, str]:
        return {name: str(self.out / name) for name in names}

    def _video(self, best: Candidate, robot: RobotDescription) -> list[str]:
        from ros_free_stack.errors import MissingDependency
        from sim.draw.render import render_video

        try:
            render_video(self.out / "video.mp4", best.trajectory, best.judgement, robot, best.motion)
        except MissingDependency as error:
            say(f"no video: {error}")
            return []
        return ["video.mp4"]

    def _controller(self) -> ControllerName | None:
        """What will move the robot: the servo driver's own controller where there are servos."""
        if self.servo is None:
            return None
        from hw.gate import DRIVEN

        return DRIVEN

    def _say_why_not(self, best: Candidate, pipeline: Pipeline) -> None:
        """Why nothing is streamed, and what would do where it is balance alone that fails."""
        from sim.judge.repair import BALANCE_CHECKS

        say("nothing is streamed: no candidate passed with what the servo driver does, which is to send plain angles")
        failed = {check.name for check in best.judgement.verdict.failures}
        if self.mount == "free" and failed <= BALANCE_CHECKS and pipeline.judge(best.trajectory, "default").passed:
            robot = best.trajectory.robot
            say(f"only feedback keeps {robot} up: hang it up and use --mount fixed, or leave --servo out")

    def _stream(self, best: Candidate, robot: RobotDescription, timings: Timings) -> dict[str, Any] | None:
        if self.servo is None or not best.judgement.passed:
            return None
        from functools import partial

        from hw.stream import stream
        from sim.judge.way_in import check_way_in

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
                check_way=partial(check_way_in, robot),
            )
        if report.skipped:
            say(f"skipped, not on this rig: {', '.join(report.skipped)}")
        return report.as_dict()

    def _tell(self, *lines: str) -> None:
        """What is known now, before report and video: on stderr with --json, whose object comes last."""
        for line in lines:
            print(line, file=sys.stderr if self.json else sys.stdout, flush=True)

    def _searched(self, found: tuple[Candidate, ...]) -> str:
        """How far the search went."""
        feasible, robot = sum(candidate.judgement.passed for candidate in found), self.robot
        if self.exhaustive or not feasible or len(found) == self.candidates:
            return f"{feasible} of {len(found)} candidates are feasible on {robot}"
        return (
            f"candidate {len(found)} of {self.candidates}, in the order in which they show the sentence, is the first "
            f"that is feasible on {robot}; --exhaustive judges them all"
        )

    def _verdict_words(self, best: Candidate, searched: str) -> Iterator[str]:
        verdict = best.judgement.verdict
        for segment in best.motion.segments:
            yield f"{segment.start_s:5.2f} to {segment.end_s:5.2f} s  {segment.text}"
        yield from (f"prompt mismatch: {line}" for line in best.sample.missing)
        yield from best.report.failures()
        yield searched
        yield from (note for note in verdict.notes if note.startswith(("played by", "changed", "tried")))
        for check in verdict.failures:
            yield f"failed {check.name}: {check.value:.3g} {check.unit}, limit {check.limit:.3g} {check.unit}"
        yield f"verdict: {'PASSED' if verdict.passed else 'INFEASIBLE'}"

    def _closing_words(self, servo: dict[str, Any] | None) -> Iterator[str]:
        if servo is not None and self.dry_run:
            yield f"servos: dry run, {servo['joints']} servos on {servo['port']} are ready, nothing was written"
        elif servo is not None:
            yield (
                f"servos: {servo['cycles']} cycles at {servo['rate_hz']:.1f} Hz, "
                f"jitter p99 {servo['jitter_p99_ms']:.2f} ms, {len(servo['errors'])} errors"
            )
        yield f"report: {self.out / 'report.html'}"
