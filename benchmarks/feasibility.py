"""Which sentences each robot can do: runs every prompt for several seeds on every robot and writes a table.

python benchmarks/feasibility.py --out out/feasibility                  # table.md, and a storyboard a row
python benchmarks/feasibility.py --robots op3 --seeds 0 --candidates 1
"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import tyro

from pipeline.candidate import Candidate
from pipeline.pipeline import Pipeline
from pipeline.timings import Timings
from ros_free_stack.console import progress, say
from ros_free_stack.files import make_folder, write_text
from ros_free_stack.robots import load_robot

PROMPTS = (
    "a person waves with the right hand",
    "a person waves with both hands",
    "a person bows",
    "a person squats down and stands up",
    "a person raises the left arm",
    "a person raises both arms above the head",
    "a person claps",
    "a person points forward with the left hand",
    "a person walks forward",
    "a person walks backward",
    "a person turns to the left",
    "a person steps to the right",
    "a person marches in place",
    "a person punches with the right hand",
    "a person kicks with the left leg",
    "a person balances on the right leg",
    "a person looks around",
    "a person jumps",
    "a person walks forward, then waves with the left hand",
    "a person bows after waving with the right hand",
    "a person squats twice",
    "a person waves while walking forward",
)


@dataclass(frozen=True)
class Arguments:
    """Run every prompt for every seed on every robot and write a table of what is feasible."""

    out: Path = Path("out/feasibility")
    """Folder for table.md and the storyboards."""
    robots: tuple[str, ...] = ("op3", "g1")
    """Robots by name."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds."""
    candidates: int = 4
    """Candidates for each run."""
    only: str = ""
    """Only prompts that hold these words."""


def outcome(candidates: tuple[Candidate, ...]) -> str:
    """ "yes" with the number of feasible candidates, or the checks that failed most often."""
    feasible = sum(candidate.judgement.passed for candidate in candidates)
    if feasible:
        return f"yes ({feasible}/{len(candidates)})"
    failed = Counter(check.name for c in candidates for check in c.judgement.verdict.failures)
    return "no: " + ", ".join(name for name, _ in failed.most_common(3))


def main(arguments: Arguments) -> None:
    """Fill the table row by row, prompts down, robots and seeds across."""
    from sim.storyboard import write_storyboard

    make_folder(arguments.out)
    prompts = [prompt for prompt in PROMPTS if arguments.only in prompt]
    rows = {prompt: [prompt.removeprefix("a person ")] for prompt in prompts}
    totals: list[str] = []
    for name in arguments.robots:
        pipeline, feasible = Pipeline(load_robot(name)), 0
        for prompt in progress(prompts, name):
            segments, _ = pipeline.segments(prompt, anyway=True)
            for seed in arguments.seeds:
                timings = Timings()
                found = pipeline.candidates(
                    prompt, segments, seed=seed, candidates=arguments.candidates, timings=timings
                )
                rows[prompt].append(outcome(found))
                feasible += found[0].judgement.passed
                say(f"{name} {seed} {prompt}: {rows[prompt][-1]}  {timings.seconds}")
                picture = arguments.out / f"{name}-{prompts.index(prompt):02d}-{seed}.png"
                write_storyboard(
                    picture, found[0].motion, found[0].judgement.reference, f"{prompt}: {rows[prompt][-1]}"
                )
        totals.append(f"{name}: {feasible} of {len(prompts) * len(arguments.seeds)} runs are feasible")
    columns = ["prompt", *(f"{name}, seed {seed}" for name in arguments.robots for seed in arguments.seeds)]
    lines = [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]
    lines += [f"| {' | '.join(row)} |" for row in rows.values()]
    write_text(arguments.out / "table.md", "\n".join([*lines, "", *totals]) + "\n")
    print("\n".join(totals))


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
