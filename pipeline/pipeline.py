"""Text to verdict for one robot: understanding, generator, retargeter and judge, called in this order and no other."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from pipeline.candidate import Candidate, Sample
from pipeline.stages import Stages
from pipeline.timings import Timings
from ros_free_stack.console import progress, say
from ros_free_stack.messages import ControllerName, HumanMotion, Mount, RobotTrajectory
from ros_free_stack.robots import RobotDescription
from ros_free_stack.skeleton import FPS

if TYPE_CHECKING:
    from generator.amounts import Fitted, Plan, Wanted
    from generator.performer import Performer
    from generator.ranking import Ranker
    from generator.text.encoder import TextEncoder
    from generator.text.reading import Segmenter
    from generator.text.understanding import Understanding, Understood
    from retarget.pipeline import Retargeter, RetargetResult
    from retarget.report import RetargetReport
    from sim.judge.verdict import Judgement

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
        self._stages = Stages()

    def prepare(self) -> None:
        """Begin to load every stage in the background; a sentence that comes meanwhile is read as soon as it can be."""
        # What several stages import comes first, in one thread.
        import scipy.ndimage
        import scipy.spatial.transform  # noqa: F401

        self._stages.begin("segmenter", self._make_segmenter)
        self._stages.begin("generator", self._make_generator)
        self._stages.begin("ranker", self._make_ranker)
        self._stages.begin("retargeter", self._make_retargeter)
        self._stages.begin("judge", self._make_judge)

    def understand(self, prompt: str, *, anyway: bool = False) -> "Understood":
        """What a prompt asks for; what there is to say of it is said.

        Raises:
            InvalidPrompt: the prompt is empty, too long, not English, or has too many actions.
            OutOfDomain: a segment is unknown to the model, unless `anyway`.
        """
        understanding = self._stages.get("understanding", self._make_understanding)
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
        distances = self._stages.get("ranker", self._make_ranker).distances(prompt, motions).tolist()
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
        retargeter = self._stages.get("retargeter", self._make_retargeter)
        return retargeter.retarget(motion, most_stride=most_stride)

    def judge(self, trajectory: RobotTrajectory, controller: ControllerName | None = None) -> "Judgement":
        """The verdict on a trajectory, with its playback by a controller; None takes the pipeline's own."""
        judge = self._stages.get("judge", self._make_judge)
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

        One passes if it is feasible and shows every action that was asked for, or if it is feasible and no other one
        shows them all. The preferred candidate comes first, repaired where none is feasible. `exhaustive` goes on after
        one has passed: that one stays preferred, but how many pass is then known. `make` makes the motions in another
        way than from the prompt alone; `wanted` are the amounts that their segments are to come to on the robot.
        """
        with timings.measure("generate"):
            motions = self.generate(prompt, segments, seed=seed, candidates=candidates, make=make)
            samples = self.compared(prompt, motions)
        found: list[Candidate] = []
        for tried, sample in enumerate(progress(samples, "retarget and judge", total=len(samples)), start=1):
            with timings.measure("retarget"):
                made = self.fitted(prompt, sample, wanted) if wanted else (sample, *self.retarget(sample.motion))
            with timings.measure("validate"):
                found.append(Candidate(*made, self.judge(made[1])))
            hope = not sample.faithful and any(later.faithful for later in samples[tried:])
            if found[-1].judgement.passed and not (exhaustive or hope):
                break
        found.sort(key=lambda candidate: candidate.order)
        if repair and not found[0].judgement.passed:
            with timings.measure("repair"):
                found[0] = self.repair(found[0])
        return tuple(found)

    @property
    def _generator(self) -> "Performer":
        return self._stages.get("generator", self._make_generator)

    def _encoder(self) -> "TextEncoder":
        return self._stages.get("encoder", self._make_encoder)

    def _make_segmenter(self) -> "Segmenter":
        from generator.text.understanding import segmenter

        return segmenter(self.llm, self.llm_model)

    def _make_understanding(self) -> "Understanding":
        from generator.registry import SHARED_WEIGHTS
        from generator.text.understanding import Understanding

        return Understanding(SHARED_WEIGHTS, self._encoder, lambda: self._stages.get("segmenter", self._make_segmenter))

    def _make_encoder(self) -> "TextEncoder":
        from generator.text.encoder import TextEncoder

        return TextEncoder()

    def _make_generator(self) -> "Performer":
        from generator.performer import Performer

        return Performer.load(generator=self.generator, text_encoder=self._encoder())

    def _make_ranker(self) -> "Ranker":
        from generator.ranking import Ranker

        return Ranker.load()

    def _make_retargeter(self) -> "Retargeter":
        from retarget.pipeline import Retargeter

        return Retargeter(self.robot)

    def _make_judge(self) -> "Callable[..., Judgement]":
        from sim.judge.verdict import judge
        from sim.model import judging_model

        judging_model(self.robot)  # compiled into the cache, where it is not there
        return judge
