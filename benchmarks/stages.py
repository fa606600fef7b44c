"""From a sentence to its verdict: seconds of each stage, in fresh processes and in a warm one, and what imports take.

python benchmarks/stages.py                                  # 60 sentences on OP3 and G1
python benchmarks/stages.py --robots op3 --limit 10 --cold 2
python benchmarks/stages.py --rows before.jsonl              # a line a sentence, to hold two versions together

Seconds are those of the clock; `CPU` those that the process had a core, which a busy computer changes little.
Nothing here fails: it prints what it finds.
"""

import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
import tyro

import launch
from pipeline.pipeline import Pipeline
from pipeline.run_words import outcome
from pipeline.timings import Timings
from ros_free_stack.console import progress, say
from ros_free_stack.errors import StackError
from ros_free_stack.files import read_lines, write_text
from ros_free_stack.robots import load_robot

PROMPTS = Path(__file__).with_name("stage_prompts.txt")
STAGES = ("text", "generate", "retarget", "validate", "repair")
IMPORTS = (
    "launch",
    "numpy",
    "scipy.ndimage",
    "torch",
    "spacy",
    "mujoco",
    "casadi",
    "piqp",
    "pipeline.run",
    "generator.text.splitter",
    "generator.performer",
    "retarget.pipeline",
    "sim.judge.verdict",
    "sim.draw.report",
)
"""Each is imported in a process of its own."""


@dataclass(frozen=True)
class Arguments:
    """Time sentences from text to verdict, cold and warm, and the imports."""

    robots: tuple[str, ...] = ("op3", "g1")
    """Robots by name."""
    prompts: Path = PROMPTS
    """A file with a sentence a line."""
    limit: int = 60
    """Sentences at most."""
    cold: int = 6
    """How many of them, evenly chosen, each start a process of their own."""
    candidates: int = 4
    """Candidates at most."""
    imports: bool = True
    """Also print what imports take."""
    rows: Path | None = None
    """Write a line of JSON for each sentence: outcome and seconds."""


@dataclass(frozen=True)
class Row:
    """One sentence in the warm process: outcome (what a refusal says instead), candidates judged, s by stage."""

    robot: str
    prompt: str
    outcome: str
    judged: int
    seconds: dict[str, float]
    cpu: dict[str, float]


@dataclass(frozen=True)
class Cold:
    """One fresh process: s to the verdict and to its end, CPU s to its end, MB of memory at most."""

    verdict_s: float
    end_s: float
    cpu_s: float
    peak_mb: float


def cold(robot: str, prompt: str, candidates: int) -> Cold | None:
    """Run a sentence in a fresh process, without a video; None where it is refused."""
    options = ("--robot", robot, "--candidates", str(candidates), "--no-video", "--json")
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, launch.__file__, "run", prompt, *options, "--out", str(Path(folder) / "run")]
        start, told = perf_counter(), None
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
            assert process.stderr is not None
            for line in process.stderr:
                if line.startswith("verdict:"):
                    told = perf_counter() - start
            _, status, used = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
    if told is None:
        return None
    return Cold(told, perf_counter() - start, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024)


def warm(pipeline: Pipeline, prompt: str, candidates: int) -> Row:
    """A sentence in this process."""
    timings, start, cpu = Timings(), perf_counter(), process_time()
    try:
        with timings.measure("text"):
            segments, _ = pipeline.segments(prompt)
        found = pipeline.candidates(prompt, segments, seed=0, candidates=candidates, timings=timings, repair=True)
    except StackError as refused:
        return Row(pipeline.robot.name, prompt, f"refused: {refused}", 0, {}, {})
    timings.seconds["verdict"], timings.cpu["verdict"] = perf_counter() - start, process_time() - cpu
    return Row(pipeline.robot.name, prompt, outcome(found[0]), len(found), timings.seconds, timings.cpu)


def spread(values: Sequence[float]) -> str:
    """Median, 95th percentile and the largest, as cells of a table."""
    if not values:
        return " | | | "
    return f" | {np.median(values):.2f} | {np.percentile(values, 95):.2f} | {max(values):.2f} "


def table(robot: str, rows: Sequence[Row], fresh: Sequence[Cold]) -> str:
    """The tables of one robot."""
    done = [row for row in rows if "verdict" in row.seconds]
    lines = [f"\n{robot}, {len(done)} sentences, {len(rows) - len(done)} refused", ""]
    lines += ["| warm | s, median | p95 | most | CPU s, median | p95 | most |", "|---|---|---|---|---|---|---|"]
    for stage in (*STAGES, "verdict"):
        both = [(row.seconds[stage], row.cpu[stage]) for row in done if stage in row.seconds]
        few = f" ({len(both)})" if stage == "repair" else ""
        lines.append(f"| {stage}{few}{spread([s for s, _ in both])}{spread([cpu for _, cpu in both])}|")
    outcomes = sorted({row.outcome for row in done})
    counts = ", ".join(f"{sum(row.outcome == word for row in done)} {word}" for word in outcomes)
    lines += ["", f"outcomes: {counts}; {sum(row.judged for row in done)} candidates judged"]
    if fresh:
        lines += ["", "| cold | median | p95 | most |", "|---|---|---|---|"]
        lines.append(f"| s to the verdict{spread([run.verdict_s for run in fresh])}|")
        lines.append(f"| s to the end{spread([run.end_s for run in fresh])}|")
        lines.append(f"| CPU s to the end{spread([run.cpu_s for run in fresh])}|")
        lines.append(f"| MB at most{spread([run.peak_mb for run in fresh])}|")
    return "\n".join(lines)


def import_table() -> str:
    """CPU and clock seconds of each of `IMPORTS` by itself."""
    code = (
        "import sys, time; w, c = time.perf_counter(), time.process_time(); __import__(sys.argv[1]);"
        "print(time.perf_counter() - w, time.process_time() - c, len(sys.modules))"
    )
    lines = ["\n| import | s | CPU s | modules |", "|---|---|---|---|"]
    for name in IMPORTS:
        found = subprocess.run([sys.executable, "-c", code, name], capture_output=True, text=True, check=True).stdout
        wall, cpu, modules = found.split()
        lines.append(f"| {name} | {float(wall):.2f} | {float(cpu):.2f} | {modules} |")
    return "\n".join(lines)


def main(arguments: Arguments) -> None:
    """Print the tables."""
    prompts = [line.strip() for line in read_lines(arguments.prompts) if line.strip()][: arguments.limit]
    rows: list[Row] = []
    for name in arguments.robots:
        chosen = np.unique(np.linspace(0, len(prompts) - 1, min(arguments.cold, len(prompts))).astype(int))
        fresh = [cold(name, prompts[k], arguments.candidates) for k in progress(chosen.tolist(), f"{name}, cold")]
        pipeline = Pipeline(load_robot(name))
        warm(pipeline, prompts[0], 1)
        found = []
        for prompt in progress(prompts, f"{name}, warm"):
            found.append(warm(pipeline, prompt, arguments.candidates))
            say(f"{name} {prompt}: {found[-1].outcome}, {found[-1].seconds.get('verdict', 0.0):.2f} s")
        rows += found
        print(table(name, found, [run for run in fresh if run is not None]), flush=True)
    if arguments.imports:
        print(import_table())
    if arguments.rows is not None:
        write_text(arguments.rows, "".join(json.dumps(asdict(row)) + "\n" for row in rows))


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
