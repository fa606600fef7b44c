"""Subcommands of the generator: `train` and `generate`."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import tyro

from generator.options import MotionOptions
from generator.registry import DEFAULT, DEFAULT_PRESET, SHARED, WEIGHTS_FOLDER, find_preset, stages
from generator.settings import Size
from ros_free_stack.console import Command, say
from ros_free_stack.errors import InvalidOption

if TYPE_CHECKING:
    from collections.abc import Sequence

    from generator.performer import Performer
    from generator.text.understanding import Understood
    from ros_free_stack.messages import HumanMotion

DOMAIN_STAGE: Final = "domain"
MAX_CANDIDATES: Final = 64


@dataclass(frozen=True, kw_only=True)
class Train(Command):
    """Train a model of the generator; interrupt it at will and go on with --resume."""

    stage: Annotated[str, tyro.conf.Positional]
    """Which model of the preset: tokenizer, or mask, residual and grounding, which need it (`segmo-layout` has no
    residual, `momask` no grounding; `party` has a transformer in their place); durations or evaluator, which serve all
    generators. `domain` lists the known texts. `all` does all."""
    dataset: Path
    """Folder of the motion data set (made by `data build`)."""
    out: Path
    """Folder for the weights; each generator gets a folder in it, and each model one in that."""
    preset: str = DEFAULT_PRESET
    """How the models are built and trained: `segmo-layout` is what comes with the program, `segmo-published` SegMo as
    published, `momask` its baseline, `party-small` and `party` (as published) ParTY, `part-wise` its
    baseline."""
    size: Size = "small"
    """`small` trains on two processor cores, `published` has the published sizes and wants a GPU."""
    set: Annotated[tuple[str, ...], tyro.conf.UseAppendAction] = ()
    """A setting of the preset to change, for example mask.training.batch=8; give it as often as you like."""
    iterations: int | None = None
    """How many iterations; the preset's number where not given."""
    minutes: float | None = None
    """End after this many minutes of training, if that comes before the last iteration."""
    threads: int = 2
    """Processor threads."""
    device: str = "auto"
    """`cpu`, `cuda`, or `auto`: the GPU where there is one."""
    seed: int = 0
    """Seed of initial weights, batches and noise."""
    resume: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Go on from the last checkpoint in the output folder."""
    tune: Path | None = None
    """Begin with the trained weights of this folder, for example `generator/weights`, instead of random ones."""

    def run(self) -> int:
        import torch

        from generator.datasets.open_dataset import open_dataset
        from generator.training.domain import fit_domain
        from generator.training.stages import StageJob, choose_device

        generator, preset = find_preset(self.preset, self.size)
        preset = preset.changed(self.set)
        torch.set_num_threads(self.threads)
        dataset, device = open_dataset(self.dataset), choose_device(self.device)
        names = (*(stage.name for stage in stages(generator) if stage.name in preset.stages), DOMAIN_STAGE)
        results: dict[str, dict[str, float]] = {}
        folders: dict[str, Path] = {}
        for stage in names if self.stage == "all" else (self.stage,):
            if stage == DOMAIN_STAGE:
                folders[stage] = self.out / SHARED
                results[stage] = fit_domain(dataset, folders[stage])
                continue
            torch.manual_seed(self.seed)
            job = StageJob(
                stage=stage,
                generator=generator,
                preset=preset,
                dataset=dataset,
                out=self.out,
                iterations=self.iterations,
                minutes=self.minutes,
                device=device,
                seed=self.seed,
                resume=self.resume,
                tune=self.tune,
            )
            results[stage], folders[stage] = job.run(), job.folder(stage)
            if not results[stage]["finished"]:
                self.report(results, f"{stage}: stopped; the same command with --resume goes on")
                return 130
        self.report(results, *(f"{stage}: {folder}" for stage, folder in folders.items()))
        return 0


@dataclass(frozen=True, kw_only=True)
class Generate(MotionOptions):
    """Generate human motion from a sentence.

    Examples:
        python launch.py generate "a person waves, then bows" --out wave.npz
        python launch.py generate "walks forward" --candidates 4 --seed 1 --out walk.npz
    """

    prompt: Annotated[str, tyro.conf.Positional]
    """What the person does, in English, e.g. "a person waves, then bows"."""
    out: Path = Path("human_motion.npz")
    """File to write (.npz); further candidates get a number in their name."""
    seed: int = 0
    """Same seed, same motion."""
    candidates: int = 1
    """How many motions to make."""
    generator: str = DEFAULT
    """Which generator makes the motion: `segmo` comes with the program, `momask` and `party` where they were
    trained."""
    weights: Path | None = None
    """Folder of trained models; the ones that come with the program where not given."""
    anyway: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Try a sentence outside what the model knows."""
    llm: str | None = None
    """Let a language model split the sentence: base address of an OpenAI-compatible endpoint."""
    llm_model: str = "qwen3:8b"
    """Name of the language model; RFS_LLM_KEY holds the key, if it needs one."""

    def run(self) -> int:
        from generator.text.prompt import check_prompt
        from ros_free_stack.files import check_output

        self.check_options()
        check_output(self.out, ".npz")
        if not 1 <= self.candidates <= MAX_CANDIDATES:
            raise InvalidOption("--candidates", f"expected 1 to {MAX_CANDIDATES}, found {self.candidates}")
        for prompt in (self.prompt, *self.then):
            check_prompt(prompt)  # before anything that loads slowly
        from generator.performer import Performer
        from generator.text.understanding import Understanding, segmenter
        from ros_free_stack.files import make_folder, save_motion

        folder = self.weights or WEIGHTS_FOLDER
        understanding = Understanding(folder / SHARED, segmenter=lambda: segmenter(self.llm, self.llm_model))
        understood = [understanding.read(prompt, anyway=self.anyway) for prompt in (self.prompt, *self.then)]
        for note in (note for sentence in understood for note in sentence.notes):
            say(note)
        make_folder(self.out.parent)
        generator = Performer.load(folder, generator=self.generator)
        motions, amounts = self._made(generator, understood)
        paths = [self.out, *(self.out.with_stem(f"{self.out.stem}_{i}") for i in range(1, len(motions)))]
        for path, motion in zip(paths, motions, strict=True):
            save_motion(path, motion)
        missing = [generator.mismatches(motion) for motion in motions]
        found = {
            "files": [str(path) for path in paths],
            "segments": [vars(s) for s in motions[0].segments],
            "amounts": [list(lines) for lines in amounts],
            "not_shown": [[mismatch.words for mismatch in wrong] for wrong in missing],
        }
        lines = [f"{s.start_s:5.1f} to {s.end_s:4.1f} s  {s.text}" for s in motions[0].segments]
        for path, told, wrong in zip(paths, amounts, missing, strict=True):
            lines += [f"wrote {path}", *told, *(f"prompt mismatch: {mismatch.words}" for mismatch in wrong)]
        self.report(found, *lines)
        return 0

    def _made(
        self, performer: "Performer", understood: "Sequence[Understood]"
    ) -> "tuple[tuple[HumanMotion, ...], list[tuple[str, ...]]]":
        """The motions, bent to the person's own metres, degrees and seconds, and what those come to for each."""
        from generator.amounts import fit, followed_words, measured, plan, wanted_of
        from generator.performer import FIRST_SAMPLES

        prompts = (self.prompt, *self.then)
        sentences = [(prompt, found.segments) for prompt, found in zip(prompts, understood, strict=True)]
        wanted, lasting_s = wanted_of(understood[0].moments) if self.alone else (), None
        if wanted:
            ((prompt, segments),) = sentences
            (sample,) = performer.generate(prompt, segments, seed=self.seed, settings=FIRST_SAMPLES)
            planned = plan(segments, wanted, measured(sample, wanted))
            sentences, lasting_s, wanted = [(prompt, planned.segments)], planned.seconds, planned.wanted
        motions = self.motions(performer, sentences, seed=self.seed, candidates=self.candidates, lasting_s=lasting_s)
        if not wanted:
            return motions, [() for _ in motions]
        bent = [fit(motion, wanted, lambda _: None, lambda motion, _: measured(motion, wanted)) for motion in motions]
        return tuple(found.motion for found in bent), [followed_words(wanted, found.measured) for found in bent]
