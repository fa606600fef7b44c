"""Which sentences each robot can do: runs every prompt for several seeds on every robot and writes a table.

python benchmarks/feasibility.py --out out/feasibility                  # table.md, and a storyboard a row
python benchmarks/feasibility.py --robots op3 --seeds 0 --candidates 1
"""

import json
from collections import Counter
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import tyro

from hw.gate import DRIVEN
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
    """Run every prompt for every seed on every robot and write a table of what is feasible, and by which controller."""

    out: Path = Path("out/feasibility")
    """Folder for table.md, storyboards, and rows.jsonl, from which the same command goes on."""
    robots: tuple[str, ...] = ("op3", "g1")
    """Robots by name."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds."""
    candidates: int = 4
    """Candidates for each run."""
    only: str = ""
    """Only prompts that hold these words."""


@dataclass(frozen=True)
class Row:
    """One run: how many candidates passed by each controller, and the checks that failed most often."""

    robot: str
    prompt: str
    seed: int
    candidates: int
    passed: dict[str, int]
    failed: dict[str, list[str]]

    def words(self, controller: str) -> str:
        """ "yes" with the number of feasible candidates, or what failed."""
        if self.passed[controller]:
            return f"yes ({self.passed[controller]}/{self.candidates})"
        return "no: " + ", ".join(self.failed[controller])


def run(pipeline: Pipeline, prompt: str, seed: int, arguments: Arguments) -> Row:
    """Generate and retarget once, judge by the feedback controller and by what the servo driver does."""
    from sim.draw.storyboard import write_storyboard

    segments, _ = pipeline.segments(prompt, anyway=True)
    found = pipeline.candidates(
        prompt, segments, seed=seed, candidates=arguments.candidates, timings=Timings(), exhaustive=True
    )
    verdicts = {
        "default": [candidate.judgement.verdict for candidate in found],
        DRIVEN: [pipeline.judge(candidate.trajectory, DRIVEN).verdict for candidate in found],
    }
    failed = {
        name: Counter(check.name for verdict in made for check in verdict.failures) for name, made in verdicts.items()
    }
    row = Row(
        pipeline.robot.name,
        prompt,
        seed,
        len(found),
        {name: sum(verdict.passed for verdict in made) for name, made in verdicts.items()},
        {name: [check for check, _ in counts.most_common(3)] for name, counts in failed.items()},
    )
    picture = arguments.out / f"{row.robot}-{PROMPTS.index(prompt):02d}-{seed}.png"
    write_storyboard(picture, found[0].motion, found[0].judgement.reference, f"{prompt}: {row.words('default')}")
    return row


def table(rows: list[Row], robot: str) -> str:
    """Prompts down; for each controller, how many seeds have a feasible candidate, and how many candidates."""
    lines = ["| prompt | plain angles (the servo driver) | feedback |", "|---|---|---|"]
    for prompt in PROMPTS:
        own = [row for row in rows if (row.robot, row.prompt) == (robot, prompt)]
        if own:
            cells = (_cell(own, controller) for controller in (DRIVEN, "default"))
            lines.append(f"| {prompt.removeprefix('a person ')} | {' | '.join(cells)} |")
    own = [row for row in rows if row.robot == robot]
    shares = (f"{sum(row.passed[name] > 0 for row in own)} of {len(own)}" for name in (DRIVEN, "default"))
    return "\n".join([*lines, f"| **runs with a feasible candidate** | {' | '.join(shares)} |"])


def _cell(rows: list[Row], controller: str) -> str:
    passed, candidates = sum(row.passed[controller] for row in rows), sum(row.candidates for row in rows)
    failed = Counter(name for row in rows for name in row.failed[controller])
    words = ", ".join(name for name, _ in failed.most_common(2))
    return f"{sum(row.passed[controller] > 0 for row in rows)}/{len(rows)} ({passed}/{candidates})" + (
        f" {words}" if passed < candidates else ""
    )


def main(arguments: Arguments) -> None:
    """Make the rows that are not there yet, then the tables."""
    kept = make_folder(arguments.out) / "rows.jsonl"
    rows = [Row(**json.loads(line)) for line in kept.read_text().splitlines()] if kept.exists() else []
    done = {(row.robot, row.prompt, row.seed) for row in rows}
    for name in arguments.robots:
        pipeline = Pipeline(load_robot(name))
        # Seed by seed, so that what was interrupted is a table of fewer seeds.
        for seed, prompt in progress([*product(arguments.seeds, PROMPTS)], name):
            if arguments.only not in prompt or (name, prompt, seed) in done:
                continue
            row = run(pipeline, prompt, seed, arguments)
            rows.append(row)
            write_text(kept, "".join(json.dumps(asdict(row)) + "\n" for row in rows))
            say(f"{name} {seed} {prompt}: {row.words(DRIVEN)}; with feedback {row.words('default')}")
    text = "\n\n".join(f"### {name}\n\n{table(rows, name)}" for name in arguments.robots)
    write_text(arguments.out / "table.md", text + "\n")
    print(text)


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
