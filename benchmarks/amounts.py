"""Amounts in sentences, measured on the robot's trajectory: distances, turns, durations and counts.

python -m benchmarks.amounts --out out/amounts                # 20 prompts a kind, seeds 0 to 2, OP3 and G1
python -m benchmarks.amounts --robots op3 --seeds 0 --each 5
"""

import json
from dataclasses import asdict, dataclass
from itertools import product
from pathlib import Path

import tyro

from generator.amounts import wanted_of
from generator.text.frame import Kind
from pipeline.pipeline import Pipeline
from ros_free_stack.console import progress
from ros_free_stack.errors import StackError
from ros_free_stack.files import make_folder, write_text
from ros_free_stack.robots import load_robot

PROMPTS: dict[Kind, tuple[str, ...]] = {
    "distance": (
        "walk forward one metre",
        "walk forward 50 cm",
        "walk forward 2 m",
        "take a walk of 1.5 metres",
        "go forward half a metre",
        "walk backwards 50 centimetres",
        "walk backward one metre",
        "walk 3 feet forward",
        "move forward 1 metre, then wave",
        "wave, then walk forward 1 m",
        "walk slowly for 80 cm",
        "walk two metres ahead",
        "walk 70 cm, then bow",
        "step back 30 cm",
        "walk forward 1.2 meters",
        "advance by one meter",
        "walk forward four feet and stop",
        "hey robot, could you please walk half a metre forward?",
        "walk straight for 1 m",
        "march forward 60 cm",
    ),
    "angle": (
        "turn left by 45 degrees",
        "turn 90 degrees to the right",
        "turn right by 120 degrees",
        "make a quarter turn to the left",
        "make a half turn",
        "turn around 180 degrees",
        "turn clockwise by 60 degrees",
        "rotate 30 degrees to the left",
        "turn left 90 degrees, then wave",
        "wave, then turn right by 90 degrees",
        "turn 150 degrees to the left",
        "turn counterclockwise by 90 degrees",
        "turn to the right by 75 degrees",
        "spin 360 degrees",
        "do a full turn to the left",
        "turn left by 200 degrees",
        "turn right, exactly 100 degrees",
        "make a quarter turn clockwise",
        "turn 45 degrees to the right and bow",
        "please turn left by 135 degrees",
    ),
    "duration": (
        "wave for 5 seconds",
        "wave with the left hand for 3 s",
        "stand on one leg for 5 seconds",
        "march in place for 4 seconds",
        "clap for 3 seconds",
        "hold both arms up for 4 seconds",
        "stand still for 3 seconds",
        "wave both hands for 6 seconds",
        "look around for 5 seconds",
        "bow for 4 seconds",
        "squat for 3 seconds",
        "walk in place for 5 seconds",
        "wave for 2.5 seconds, then bow",
        "bow, then wave for 4 seconds",
        "point forward for 3 seconds",
        "clap your hands for 5 seconds",
        "balance on the left leg for 4 seconds",
        "raise the right arm for 3 seconds",
        "punch for 4 seconds",
        "wave for 8 seconds",
    ),
}


@dataclass(frozen=True)
class Arguments:
    """Generate, retarget and measure; counts are those of `benchmarks/probes.py`."""

    out: Path = Path("out/amounts")
    """Folder for rows.jsonl and the table."""
    robots: tuple[str, ...] = ("op3", "g1")
    """Robots by name."""
    seeds: tuple[int, ...] = (0, 1, 2)
    """Seeds."""
    each: int = 20
    """Prompts of each kind."""


@dataclass(frozen=True)
class Row:
    """One run: what was asked for and what the robot did of it, or why there is nothing."""

    robot: str
    kind: str
    prompt: str
    seed: int
    asked: float
    got: float | None
    right: bool
    why: str = ""


def run(pipeline: Pipeline, kind: Kind, prompt: str, seed: int) -> Row:
    """One sentence, its first sample, bent to its amounts."""
    name = pipeline.robot.name
    try:
        understood = pipeline.understand(prompt)
        wanted = tuple(item for item in wanted_of(understood.moments) if item.amount.kind == kind)
        if not wanted:
            return Row(name, kind, prompt, seed, 0.0, None, False, "no amount was read")
        planned = pipeline.plan(prompt, understood.segments, wanted, seed=seed)
        (motion,) = pipeline.generate(
            prompt,
            planned.segments,
            seed=seed,
            candidates=1,
            make=lambda performer: performer.generate(prompt, planned.segments, seed=seed, lasting_s=planned.seconds),
        )
        measured = pipeline.bent(motion, planned.wanted).measured
    except StackError as error:
        return Row(name, kind, prompt, seed, 0.0, None, False, str(error))
    got, item = measured[0].of(kind), planned.wanted[0]
    return Row(name, kind, prompt, seed, item.amount.value, got, abs(got - item.amount.value) <= item.allowed)


def main(arguments: Arguments) -> None:
    """Print, for each robot and kind, how many amounts were followed, and those that were not."""
    rows: list[Row] = []
    for name in arguments.robots:
        pipeline = Pipeline(load_robot(name))
        jobs: list[tuple[Kind, str]] = [
            (kind, prompt) for kind, prompts in PROMPTS.items() for prompt in prompts[: arguments.each]
        ]
        for seed, (kind, prompt) in progress([*product(arguments.seeds, jobs)], name):
            rows.append(run(pipeline, kind, prompt, seed))
            write_text(make_folder(arguments.out) / "rows.jsonl", "".join(json.dumps(asdict(r)) + "\n" for r in rows))
    for name, kind in product(arguments.robots, PROMPTS):
        own = [row for row in rows if (row.robot, row.kind) == (name, kind)]
        print(f"{name} {kind}: {sum(row.right for row in own)} of {len(own)} followed")
        for row in own:
            if not row.right:
                print(f"    {row.prompt} (seed {row.seed}): asked {row.asked:g}, got {row.got} {row.why}")


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
