"""The `run` subcommand: a sentence, or a file of them, to run folders, and on request to servos."""

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from generator.options import MotionOptions, Sentence
from pipeline.run_words import EXIT_CODES, NOT_AS_ASKED, closing_words, outcome, searched_words, slug, verdict_words
from pipeline.timings import Timings
from ros_free_stack.console import print_table, say
from ros_free_stack.errors import HardwareFault, InvalidOption, InvalidPrompt, StackError
from ros_free_stack.robots import load_robot

if TYPE_CHECKING:
    from generator.amounts import Wanted
    from generator.text.understanding import Understood
    from pipeline.candidate import Candidate
    from pipeline.pipeline import Pipeline
    from pipeline.run_folder import RunFolder
    from ros_free_stack.messages import ControllerName
    from ros_free_stack.robots import RobotDescription

MAX_CANDIDATES = 64


@dataclass(frozen=True)
class Ran:
    """One run: its result for JSON, its last words, and the process's exit code."""

    result: dict[str, Any]
    words: tuple[str, ...]
    code: int


@dataclass(frozen=True, kw_only=True)
class Run(MotionOptions):
    """Turn a sentence into a robot's motion: generate, retarget, judge, draw, and stream on request.

    The exit code is 0 if a candidate passed every check and shows what was asked for, 3 if none is feasible (the report
    says why), 5 if what is feasible lacks an action that was asked for. Of a file of prompts it is 0 if all lines are,
    else that of the first that is not.

    Examples:
        python launch.py run "a person waves with the right hand" --out out/
        python launch.py run "walks forward, then bows" --robot g1 --candidates 8 --seed 3
        python launch.py run "squats" --then "waves" --then "bows"
        python launch.py run --prompts prompts.txt --out out/all --json
        python launch.py run "squats twice" --servo sim --json
        python launch.py run "claps" --servo /dev/ttyUSB0
        python launch.py run "waves" --servo /dev/ttyUSB0,/dev/ttyUSB1 --mount fixed --dry-run
    """

    prompt: Annotated[str | None, tyro.conf.Positional] = None
    """What the robot should do, in English; without it, a terminal is asked, again and again."""
    prompts: Path | None = None
    """A file of prompts instead, one a line: each gets a folder in the run folder, and there is a table at the end."""
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
    """Try a sentence outside what the model knows, and stream a motion that lacks an action that was asked for."""
    generator: str = "segmo"
    """Which generator makes the motion: `segmo` comes with the program."""
    llm: str | None = None
    """Let a language model split the sentence: base address of an OpenAI-compatible endpoint."""
    llm_model: str = "qwen3:8b"
    """Name of the language model; RFS_LLM_KEY holds the key, if it needs one."""

    def run(self) -> int:
        prompts = self._prompts()
        robot = self._checked()
        from pipeline.pipeline import Pipeline

        pipeline = Pipeline(
            robot,
            llm=self.llm,
            llm_model=self.llm_model,
            mount=self.mount,
            controller=self._controller(),
            generator=self.generator,
        )
        pipeline.prepare()
        if not prompts:
            from pipeline.asking import ask

            return ask(self.out, lambda prompt, out: self._run_one(pipeline, prompt, out))
        if self.prompts is not None:
            return self._run_all(pipeline, prompts)
        ran = self._run_one(pipeline, prompts[0], self.out)
        self.report(ran.result, *ran.words)
        return ran.code

    def _prompts(self) -> tuple[str, ...]:
        """The sentences, checked before anything that loads slowly; none where a terminal is asked for them.

        Those of a file are checked one by one later.
        """
        from generator.text.prompt import check_prompt

        if self.prompt is None and self.prompts is None and sys.stdin.isatty():
            return ()
        if (self.prompt is None) == (self.prompts is None):
            raise InvalidPrompt(
                'say what the robot should do, for example run "wave with the right hand", or --prompts'
            )
        if self.prompt is not None:
            for prompt in (self.prompt, *self.then):
                check_prompt(prompt)
            return (self.prompt,)
        if self.edit is not None or self.start is not None or self.then:
            raise InvalidOption("--prompts", "cannot be combined with --start, --edit or --then")
        assert self.prompts is not None
        from ros_free_stack.files import read_lines

        lines = tuple(line.strip() for line in read_lines(self.prompts) if line.strip())
        if not lines:
            raise InvalidOption("--prompts", f"{self.prompts} has no line with a sentence")
        return lines

    def _checked(self) -> "RobotDescription":
        """The robot, after a look at all other options and at the servos' port."""
        from ros_free_stack.files import check_folder

        self.check_options()
        check_folder(self.out)
        if not 1 <= self.candidates <= MAX_CANDIDATES:
            raise InvalidOption("--candidates", f"expected 1 to {MAX_CANDIDATES}, found {self.candidates}")
        robot = load_robot(self.robot)
        if self.servo is not None:
            from hw.stream import check_port

            check_port(self.servo, robot, joints=self.joints, calibration=self.calibration)
        elif self.dry_run or self.joints or self.calibration:
            raise InvalidOption("--servo", "is missing: --dry-run, --joints and --calibration are about servos")
        return robot

    def _run_one(self, pipeline: "Pipeline", prompt: str, out: Path) -> Ran:
        from pipeline.run_folder import RunFolder
        from ros_free_stack.files import make_folder

        started, timings = perf_counter(), Timings()
        with timings.measure("text"):
            understood = [pipeline.understand(text, anyway=self.anyway) for text in (prompt, *self.then)]
            sentences: list[Sentence] = [
                (text, found.segments) for text, found in zip((prompt, *self.then), understood, strict=True)
            ]
            sentences, lasting_s, wanted = self._amounts(pipeline, sentences, understood)
        whole = ", then ".join(text for text, _ in sentences)
        facts = {
            "asked": whole,
            "understood": "; ".join(text for _, segments in sentences for text in segments),
            "seed": str(self.seed),
            "candidates": str(self.candidates),
        }
        folder = RunFolder(make_folder(out), facts)
        found = pipeline.candidates(
            whole,
            tuple(text for _, segments in sentences for text in segments),
            seed=self.seed,
            candidates=self.candidates,
            timings=timings,
            repair=self.repair,
            exhaustive=self.exhaustive,
            make=lambda performer: self.motions(
                performer, sentences, seed=self.seed, candidates=self.candidates, lasting_s=lasting_s
            ),
            wanted=wanted,
        )
        best, robot = found[0], pipeline.robot
        timings.seconds["to_verdict"] = perf_counter() - started
        searched = searched_words(found, self.candidates, exhaustive=self.exhaustive)
        self._tell(*verdict_words(best, searched))
        files = folder.save(best, timings)
        try:
            servo = self._stream(best, pipeline, folder, timings)
        finally:
            # A stream that a fault ended is the one whose plots are wanted most.
            files |= folder.report(best, robot, timings, (searched,), video=self.video)
        verdict, word = best.judgement.verdict, outcome(best)
        result = {
            "prompt": whole,
            "robot": robot.name,
            "seed": self.seed,
            "outcome": word,
            "segments": [asdict(segment) for segment in best.motion.segments],
            "in_domain": all(sentence.known for sentence in understood),
            "search": {"candidates": self.candidates, "judged": len(found), "exhaustive": self.exhaustive},
            "candidates": [candidate.as_dict() for candidate in found],
            "retarget": best.report.as_dict(),
            "faithful": {"passed": best.sample.faithful, "not_shown": list(best.sample.missing)},
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
        return Ran(result, tuple(closing_words(str(out), servo, dry_run=self.dry_run)), EXIT_CODES[word])

    def _amounts(
        self, pipeline: "Pipeline", sentences: "list[Sentence]", understood: "Sequence[Understood]"
    ) -> "tuple[list[Sentence], tuple[float | None, ...] | None, tuple[Wanted, ...]]":
        """The sentences, durations of their segments and amounts, planned by what the robot makes of a first sample."""
        from generator.amounts import wanted_of

        wanted = wanted_of(understood[0].moments)
        if self.mount == "fixed" or pipeline.robot.mounted(self.mount) == "fixed":
            wanted = tuple(item for item in wanted if item.amount.kind == "duration")
        if not wanted:
            return sentences, None, ()
        if not self.alone:
            told = ", ".join(repr(item.amount.text) for item in wanted)
            say(f"not followed with --then, --start, --edit, --duration or --durations: {told}")
            return sentences, None, ()
        ((prompt, segments),) = sentences
        plan = pipeline.plan(prompt, segments, wanted, seed=self.seed)
        return [(prompt, plan.segments)], plan.seconds, plan.wanted

    def _run_all(self, pipeline: "Pipeline", prompts: Sequence[str]) -> int:
        """One folder a prompt; a line that fails is told, and the next one is tried. A servo fault ends it all."""
        rows: list[tuple[str, ...]] = []
        results: list[dict[str, Any]] = []
        codes: list[int] = []
        for number, prompt in enumerate(prompts, start=1):
            out = self.out / f"{number:0{len(str(len(prompts)))}d}-{slug(prompt)}"
            say(f"{number} of {len(prompts)}: {prompt}")
            try:
                ran = self._run_one(pipeline, prompt, out)
            except HardwareFault:
                raise
            except StackError as error:
                say(f"error: {error}")
                ran = Ran({"prompt": prompt, "outcome": "ERROR", "error": str(error)}, (), error.exit_code)
            results.append(ran.result)
            codes.append(ran.code)
            rows.append((prompt, ran.result["outcome"], ran.result.get("error", str(out))))
        if self.json:
            self.report({"runs": results})
        else:
            print_table(("prompt", "outcome", "folder"), rows)
        return next((code for code in codes if code), 0)

    def _controller(self) -> "ControllerName | None":
        """What will move the robot: the servo driver's own controller where there are servos."""
        if self.servo is None:
            return None
        from hw.gate import DRIVEN

        return DRIVEN

    def _say_why_not(self, best: "Candidate", pipeline: "Pipeline") -> None:
        """Why nothing is streamed, and what would do where it is balance alone that fails."""
        from sim.judge.repair import BALANCE_CHECKS

        if outcome(best) == NOT_AS_ASKED:
            say("nothing is streamed: the motion lacks an action that was asked for (--anyway streams it all the same)")
            return
        say("nothing is streamed: no candidate passed with what the servo driver does, which is to send plain angles")
        failed = {check.name for check in best.judgement.verdict.failures}
        if self.mount == "free" and failed <= BALANCE_CHECKS and pipeline.judge(best.trajectory, "default").passed:
            robot = best.trajectory.robot
            say(f"only feedback keeps {robot} up: hang it up and use --mount fixed, or leave --servo out")

    def _stream(
        self, best: "Candidate", pipeline: "Pipeline", folder: "RunFolder", timings: Timings
    ) -> dict[str, Any] | None:
        if self.servo is None:
            return None
        if not (best.passed or (self.anyway and best.judgement.passed)):
            self._say_why_not(best, pipeline)
            return None
        from functools import partial

        from hw.stream import stream
        from sim.judge.way_in import check_way_in

        with timings.measure("servo"):
            report = stream(
                best.trajectory,
                best.judgement.verdict,
                pipeline.robot,
                port=self.servo,
                telemetry=folder.telemetry,
                dry_run=self.dry_run,
                calibration=self.calibration,
                joints=self.joints,
                mount=self.mount,
                check_way=partial(check_way_in, pipeline.robot),
            )
        if report.skipped:
            say(f"skipped, not on this rig: {', '.join(report.skipped)}")
        return report.as_dict()

    def _tell(self, *lines: str) -> None:
        """What is known now, before report and video: on stderr with --json, whose object comes last."""
        for line in lines:
            print(line, file=sys.stderr if self.json else sys.stdout, flush=True)
