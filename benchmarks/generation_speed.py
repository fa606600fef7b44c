"""Seconds from a prompt to a 9.8 s motion, cold and warm, part by part, and how other ways to run the layers compare.

python -m benchmarks.generation_speed --threads 2

Every variant replaces the layers of the transformers, is timed in turn with the plain eager
float32 program (so that a change of the computer's load meets both), and is compared with it in what it draws from the
same seed. Only "resampled where wrong", as the program does unless told otherwise, holds samples against the text.
What a variant costs before its first motion is shown as its own column. ONNX Runtime is tried where it is installed
(`pip install onnx onnxruntime`).
"""

import copy
import json
import subprocess
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
import torch
import tyro

from benchmarks.speed_variants import VARIANTS
from generator.models.segmo.conditioning import Condition
from generator.models.segmo.config import MAX_TOKENS, TOKEN_S
from generator.models.segmo.model import SegMo
from generator.performer import FIRST_SAMPLES, Performer, PerformerSettings
from generator.postprocess.foot_lock import lock_feet
from generator.registry import SHARED, WEIGHTS_FOLDER
from generator.text.counts import segment_counts
from generator.text.domain import Domain
from generator.text.meanwhile import encode_segments
from generator.text.splitter import Splitter
from generator.text.understanding import DOMAIN
from generator.timing import uniform_lengths
from ros_free_stack.console import say
from ros_free_stack.errors import StackError, UnknownName
from ros_free_stack.formats.features import decode

PROMPT = "a person walks forward, then waves with the right hand"
DURATION_S = MAX_TOKENS * TOKEN_S
ANOTHER_SEED = "eager, another seed"
CHECKED = "resampled where wrong"


@dataclass(frozen=True, kw_only=True)
class Arguments:
    """Time the generation of motion."""

    weights: Path = WEIGHTS_FOLDER
    """Folder of trained models."""
    threads: int = 2
    repeats: int = 7
    """Warm runs, of which the median is told."""
    candidates: tuple[int, ...] = (1, 8)
    variants: tuple[str, ...] = tuple(VARIANTS)
    """Ways to run the layers that are compared with "eager"."""
    json: bool = False
    """Print one JSON object instead of tables."""


@dataclass
class Laps:
    """A stop watch for the parts of one way."""

    seconds: dict[str, float] = field(default_factory=dict)
    last: float = field(default_factory=perf_counter)

    def lap(self, part: str) -> None:
        now = perf_counter()
        self.seconds[part], self.last = now - self.last, now


@dataclass(frozen=True)
class Drawn:
    """Tokens (Q P, B, T) and joints (B, T, 22, 3) m of B candidates before feet are locked, and what each part took."""

    tokens: torch.Tensor
    joints: np.ndarray
    seconds: dict[str, float]


@dataclass(frozen=True)
class Bench:
    """What every measurement uses, loaded once; the model is a SegMo."""

    generator: Performer
    splitter: Splitter
    domain: Domain

    def prompt_to_motion(self, generator: Performer, candidates: int, settings: PerformerSettings) -> float:
        """Seconds of a warm prompt through the program's own stages."""
        start = perf_counter()
        segments = self.splitter.split(PROMPT)
        self.domain.similarity(segments)
        generator.generate(PROMPT, segments, seed=0, candidates=candidates, duration_s=DURATION_S, settings=settings)
        return perf_counter() - start

    @torch.inference_mode()
    def draw(self, generator: Performer, candidates: int, seed: int = 0) -> Drawn:
        """The stages one by one, with a layout that does not depend on the durations model."""
        laps, noise, model = Laps(), torch.Generator().manual_seed(seed), segmo(generator)
        segments = self.splitter.split(PROMPT)
        laps.lap("split")
        self.domain.similarity(segments)
        laps.lap("check known")
        texts = torch.from_numpy(generator.text_encoder.encode_sentences([PROMPT, *segments]))
        laps.lap("encode text")
        place = torch.arange(len(segments))
        counts = torch.from_numpy(segment_counts(segments))
        generator.durations(texts[1:], counts, place, torch.full_like(place, len(segments)))
        laps.lap("durations")
        lengths = torch.from_numpy(uniform_lengths(len(segments), MAX_TOKENS)).expand(candidates, -1)
        clauses = torch.from_numpy(encode_segments(generator.text_encoder, segments))
        condition = Condition(
            texts[:1].expand(candidates, -1),
            clauses.expand(candidates, -1, -1, -1),
            counts.expand(candidates, -1, -1),
            lengths,
        )
        base = model.mask.generate(condition, model.settings, noise)
        laps.lap("mask steps")
        tokens = base
        if model.residual is not None:
            tokens = model.residual.generate(base, condition, model.settings, noise)
            laps.lap("residual layers")
        features = [model.tokenizer.decode(tokens[:, i : i + 1])[0].numpy() for i in range(candidates)]
        laps.lap("decode tokens")
        joints = [decode(rows) for rows in features]
        laps.lap("features to joints")
        for rows, motion in zip(features, joints, strict=True):
            lock_feet(motion, rows[:, -4:])
        laps.lap("lock feet")
        return Drawn(tokens, np.stack(joints), laps.seconds)

    def variant(self, name: str) -> Performer:
        """The generator with another way to run its layers."""
        model = segmo(self.generator)
        mask, residual = copy.deepcopy(model.mask), copy.deepcopy(model.residual)
        for network in (mask, residual):
            if network is not None:
                network.transformer = VARIANTS[name](network.transformer)  # pyright: ignore[reportAttributeAccessIssue]
        return replace(self.generator, model=replace(model, mask=mask, residual=residual))


def segmo(generator: Performer) -> SegMo:
    """The model of a performer, which has to be a SegMo."""
    assert isinstance(generator.model, SegMo)
    return generator.model


def run(arguments: Arguments) -> dict[str, Any]:
    """All measurements; times in s.

    Raises:
        UnknownName: there is no such variant.
    """
    for name in arguments.variants:
        if name not in VARIANTS:
            raise UnknownName("variant", name, VARIANTS)
    torch.set_num_threads(arguments.threads)
    say("a fresh process for each number of candidates")
    cold = {count: cold_start(arguments, count) for count in arguments.candidates}
    generator = Performer.load(arguments.weights)
    bench = Bench(generator, Splitter(), Domain.load(arguments.weights / SHARED / DOMAIN, generator.text_encoder))
    profile = {count: parts(bench, count, arguments.repeats) for count in arguments.candidates}
    ways: dict[str, tuple[Callable[[], Performer], PerformerSettings, int]] = {
        name: (lambda name=name: bench.variant(name), FIRST_SAMPLES, 0) for name in arguments.variants
    }
    ways[CHECKED] = (lambda: generator, PerformerSettings(), 0)
    ways[ANOTHER_SEED] = (lambda: generator, FIRST_SAMPLES, 1)
    compared: list[dict[str, Any]] = []
    for name, way in ways.items():
        say(name)
        try:
            compared += compare(bench, name, *way, arguments)
        except (StackError, RuntimeError) as error:
            say(f"{name}: does not run here: {str(error).splitlines()[0]}")
    return {"threads": arguments.threads, "cold_s": cold, "warm_s": profile, "variants": compared}


def cold_start(arguments: Arguments, candidates: int) -> dict[str, float]:
    """Seconds of the parts of a fresh process, and of all of it with the interpreter's own start as "process"."""
    script = Path(__file__).with_name("cold_start.py")
    values = (arguments.weights, candidates, arguments.threads, DURATION_S, PROMPT)
    start = perf_counter()
    finished = subprocess.run([sys.executable, script, *map(str, values)], stdout=subprocess.PIPE, check=True)
    return {**json.loads(finished.stdout), "process": perf_counter() - start}


def parts(bench: Bench, candidates: int, repeats: int) -> dict[str, float]:
    """Median seconds of each part of a warm prompt."""
    runs = [bench.draw(bench.generator, candidates).seconds for _ in range(repeats + 1)][1:]
    return {part: median(run[part] for run in runs) for part in runs[0]}


def compare(
    bench: Bench,
    name: str,
    make: Callable[[], Performer],
    settings: PerformerSettings,
    seed: int,
    arguments: Arguments,
) -> list[dict[str, Any]]:
    """One row for each number of candidates: time against the eager program, and what is drawn."""
    rows: list[dict[str, Any]] = []
    start = perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        generator = make()
        for count in arguments.candidates:
            bench.prompt_to_motion(generator, count, settings)
    first_s = perf_counter() - start
    for count in arguments.candidates:
        pairs = [
            (
                bench.prompt_to_motion(bench.generator, count, FIRST_SAMPLES),
                bench.prompt_to_motion(generator, count, settings),
            )
            for _ in range(arguments.repeats)
        ]
        eager_s, own_s = (median(times) for times in zip(*pairs, strict=True))
        expected = bench.draw(bench.generator, count)
        found = bench.draw(generator, count, seed)
        rows.append(
            {
                "variant": name,
                "candidates": count,
                "first_s": first_s,
                "seconds": own_s,
                "eager_s": eager_s,
                "speed_up": eager_s / own_s,
                "same_tokens": float((expected.tokens == found.tokens).double().mean()),
                "joints_apart_m": float(np.linalg.norm(expected.joints - found.joints, axis=-1).mean()),
            }
        )
    return rows


def show(found: dict[str, Any]) -> None:
    """Print three tables."""
    for key, title in (("cold_s", "cold, part"), ("warm_s", "warm, part")):
        columns = found[key]
        counts = list(columns)
        print(f"| {title} | " + " | ".join(f"{count} candidates, ms" for count in counts) + " |")
        print("|---|" + "---|" * len(counts))
        for part in columns[counts[0]]:
            print(f"| {part} | " + " | ".join(f"{1000 * columns[count][part]:.1f}" for count in counts) + " |")
        print()
    print("| layers run by | candidates | to first motions, s | a prompt, s | eager, s | times as fast ", end="")
    print("| same tokens | joints apart, cm |\n|---|---|---|---|---|---|---|---|")
    for row in found["variants"]:
        print(
            f"| {row['variant']} | {row['candidates']} | {row['first_s']:.1f} | {row['seconds']:.3f} "
            f"| {row['eager_s']:.3f} | {row['speed_up']:.2f} | {100 * row['same_tokens']:.1f} % "
            f"| {100 * row['joints_apart_m']:.2f} |"
        )


def main(arguments: Arguments) -> None:
    """Measure and print."""
    found = run(arguments)
    if arguments.json:
        print(json.dumps(found))
    else:
        show(found)


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
