"""Text to verdict for one robot: understanding, generator, retargeter and judge, called in this order and no other."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

from pipeline.candidate import Candidate, Sample
from pipeline.timings import Timings
from ros_free_stack.console import progress, say
from ros_free_stack.messages import ControllerName, HumanMotion, Mount, RobotTrajectory
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import FPS

if TYPE_CHECKING:
    from generator.amounts import Fitted, Plan, Wanted
    from generator.performer import Performer
    from generator.text.encoder import TextEncoder
    from generator.text.understanding import Understood
    from retarget.pipeline import RetargetResult
    from retarget.report import RetargetReport
    from sim.judge.verdict import Judgement

Stage = TypeVar("Stage")
Make = Callable[["Performer"], tuple[HumanMotion, ...]]


class Pipeline:
    """Text understanding, generator, retargeter and judge for one robot; models load once, for many prompts."""

    def __init__(
        self,
        robot: RobotDescription,
        *,
        llm: str | None = None,
        llm_model: str = "qwen3:8b",
        mount: Mount = "free",
        controller: ControllerName | None = None,
        generator: str = "segmo",
    ) -> None:
        """
        Args:
            robot: what is commanded.
            llm: base address of a language model that splits sentences; None takes the grammar.
            llm_model: its name.
            mount: whether the robot stands free or is held by its root.
            controller: the one that will move the robot; None judges by `default`, and repair may try others.
            generator: the one that makes the motion, by name.
        """
        self.robot, self.llm, self.llm_model = robot, llm, llm_model
        self.mount: Mount = mount
        self.controller: ControllerName | None = controller
        self.generator = generator
        self._stages: dict[str, Any] = {}

    def understand(self, prompt: str, *, anyway: bool = False) -> "Understood":
        """What a prompt asks for; what there is to say of it is said.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, or has too many actions.
            OutOfDomain: a segment is unknown to the model, unless `anyway`.
        """
        from generator.registry import SHARED_WEIGHTS
        from generator.text.understanding import Understanding, segmenter

        understanding = self._stage(
            "understanding",
            lambda: Understanding(SHARED_WEIGHTS, self._encoder, lambda: segmenter(self.llm, self.llm_model)),
        )
        understood = understanding.read(prompt, anyway=anyway)
        for note in understood.notes:
            say(note)
        return understood

    def segments(self, prompt: str, *, anyway: bool = False) -> tuple[tuple[str, ...], bool]:
        """The segment texts of a prompt in temporal order, and whether the model knows them all; see `understand`."""
        understood = self.understand(prompt, anyway=anyway)
        return understood.segments, understood.known

    def plan(self, prompt: str, segments: tuple[str, ...], wanted: "tuple[Wanted, ...]", *, seed: int) -> "Plan":
        """How to generate a sentence that names amounts, by what the robot makes of a first sample of it.

        Raises:
            InvalidPrompt: an amount is more than one motion can hold.
        """
        from generator.amounts import plan
        from generator.performer import FIRST_SAMPLES
        from pipeline.amounts import robot_measured

        (sample,) = self._generator.generate(prompt, segments, seed=seed, settings=FIRST_SAMPLES)
        return plan(segments, wanted, robot_measured(sample, self._retargeted(sample), wanted))

    def generate(
        self, prompt: str, segments: tuple[str, ...], *, seed: int, candidates: int, make: "Make | None" = None
    ) -> tuple[HumanMotion, ...]:
        """Human motions for a prompt, or what `make` makes with the generator."""
        if make is not None:
            return make(self._generator)
        return self._generator.generate(prompt, segments, seed=seed, candidates=candidates)

    def compared(self, prompt: str, motions: Sequence[HumanMotion]) -> list[Sample]:
        """The motions with how well each shows its sentence, the best first."""
        from generator.ranking import Ranker

        distances = self._stage("ranker", Ranker.load).distances(prompt, motions).tolist()
        samples = []
        for motion, distance in zip(motions, distances, strict=True):
            found = self._generator.mismatches(motion)
            violations = sum(mismatch.violations for mismatch in found)
            words = tuple(mismatch.words for mismatch in found)
            samples.append(Sample(motion, violations, words, distance, not any(mismatch.absent for mismatch in found)))
        return sorted(samples, key=lambda sample: sample.order)

    def retarget(self, motion: HumanMotion) -> tuple[RobotTrajectory, "RetargetReport"]:
        """The robot's trajectory of a human motion, and how far from its targets it had to stay."""
        result = self._retargeted(motion)
        return result.trajectory, result.report

    def fitted(
        self, prompt: str, sample: Sample, wanted: "tuple[Wanted, ...]"
    ) -> tuple[Sample, RobotTrajectory, "RetargetReport"]:
        """A sample bent until the robot's metres, degrees and seconds are what was asked for, and its trajectory."""
        from generator.amounts import followed_words

        found = self.bent(sample.motion, wanted)
        (read,) = self.compared(prompt, (found.motion,))
        told = replace(read, amounts=followed_words(wanted, found.measured))
        return told, found.outcome.trajectory, found.outcome.report

    def bent(self, motion: HumanMotion, wanted: "tuple[Wanted, ...]") -> "Fitted[RetargetResult]":
        """A motion bent to its amounts, with its trajectory and what that comes to."""
        from generator.amounts import fit
        from pipeline.amounts import robot_measured

        stride = 1.0

        def made(motion: HumanMotion) -> "RetargetResult":
            # Steps that were bent shorter must not be given back by strides that are shortened less.
            nonlocal stride
            result = self._retargeted(motion, most_stride=stride)
            stride = result.report.stride_scale
            return result

        return fit(motion, wanted, made, lambda motion, result: robot_measured(motion, result, wanted))

    def _retargeted(self, motion: HumanMotion, *, most_stride: float = 1.0) -> "RetargetResult":
        from retarget.pipeline import Retargeter

        return self._stage("retargeter", lambda: Retargeter(self.robot)).retarget(motion, most_stride=most_stride)

    def judge(self, trajectory: RobotTrajectory, controller: ControllerName | None = None) -> "Judgement":
        """The verdict on a trajectory, with its playback by a controller; None takes the pipeline's own."""
        from sim.judge.verdict import judge

        return judge(trajectory, self.robot, mount=self.mount, controller=controller or self.controller or "default")

    def repair(self, candidate: Candidate) -> Candidate:
        """The candidate, or what other controllers and gentler motions make of it."""
        from ros_free_stack.formats.frames import resample
        from sim.judge.repair import repair

        reports = {candidate.trajectory.digest: candidate.report}

        def retarget(motion: HumanMotion) -> RobotTrajectory:
            trajectory, reports[trajectory.digest] = self.retarget(motion)
            return trajectory

        found = repair(
            candidate.trajectory,
            self.robot,
            motion=candidate.motion,
            retarget=retarget,
            mount=self.mount,
            controllers=(self.controller,) if self.controller else ("default", "wbc"),
            known=candidate.judgement,
        )
        sample, motion = candidate.sample, found.motion or candidate.motion
        if motion is not candidate.motion:
            # A gentler motion may show less of its sentence: what is told must be of the motion that is kept.
            joints = resample(motion.joints, fps=motion.fps, to=FPS)
            (read,) = self.compared(motion.prompt, (replace(motion, joints=joints, fps=FPS),))
            told = ("amounts: not kept by what was changed",) if sample.amounts else ()
            sample = replace(read, motion=motion, amounts=told)
        return Candidate(sample, found.trajectory, reports[found.trajectory.digest], found.judgement)

    def candidates(
        self,
        prompt: str,
        segments: tuple[str, ...],
        *,
        seed: int,
        candidates: int,
        timings: Timings,
        repair: bool = False,
        exhaustive: bool = False,
        make: "Make | None" = None,
        wanted: "tuple[Wanted, ...]" = (),
    ) -> tuple[Candidate, ...]:
        """Generate, then retarget and judge what shows the sentence best, one after the other until one passes.

        One passes if it is feasible and shows every action that was asked for. The preferred candidate comes first,
        repaired where none is feasible. `exhaustive` goes on after one has passed: that one stays preferred, but
        how many pass is then known. `make` makes the motions in another way than from the prompt alone; `wanted` are
        the amounts that their segments are to come to on the robot.
        """
        with timings.measure("generate"):
            motions = self.generate(prompt, segments, seed=seed, candidates=candidates, make=make)
            samples = self.compared(prompt, motions)
        found: list[Candidate] = []
        for sample in progress(samples, "retarget and judge", total=len(samples)):
            with timings.measure("retarget"):
                made = self.fitted(prompt, sample, wanted) if wanted else (sample, *self.retarget(sample.motion))
            with timings.measure("validate"):
                found.append(Candidate(*made, self.judge(made[1])))
            if found[-1].passed and not exhaustive:
                break
        found.sort(key=lambda candidate: candidate.order)
        if repair and not found[0].judgement.passed:
            with timings.measure("repair"):
                found[0] = self.repair(found[0])
        return tuple(found)

    @property
    def _generator(self) -> "Performer":
        from generator.performer import Performer

        return self._stage("generator", lambda: Performer.load(generator=self.generator, text_encoder=self._encoder()))

    def _encoder(self) -> "TextEncoder":
        from generator.text.encoder import TextEncoder

        return self._stage("encoder", TextEncoder)

    def _stage(self, name: str, make: Callable[[], Stage]) -> Stage:
        if name not in self._stages:
            self._stages[name] = make()
        return self._stages[name]
