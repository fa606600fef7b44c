"""A picture of what is generated for some prompts, one strip each.

python -m benchmarks.generated_sheet --out sheet.png "a person bows, then waves with the right hand" "a person kicks"
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from benchmarks.corpus_sheet import Figure, draw_sheet, human_figures
from generator.performer import Performer
from generator.registry import WEIGHTS_FOLDER
from generator.text.splitter import Splitter
from ros_free_stack.console import progress
from ros_free_stack.errors import StackError


@dataclass(frozen=True)
class Arguments:
    """Generate one motion for each prompt and draw it."""

    prompts: Annotated[tuple[str, ...], tyro.conf.Positional]
    """One strip for each; what its motion does not show is said in the title."""
    out: Path = Path("sheet.png")
    """The picture."""
    weights: Path = WEIGHTS_FOLDER
    """Folder of the trained models."""
    frames: int = 14
    """Figures of a strip."""
    seed: int = 0


def strips(arguments: Arguments) -> list[tuple[str, list[Figure]]]:
    """Title and figures of each prompt."""
    generator, splitter, drawn = Performer.load(arguments.weights), Splitter(), []
    for prompt in progress(arguments.prompts, "generating", total=len(arguments.prompts)):
        (motion,) = generator.generate(prompt, splitter.split(prompt), seed=arguments.seed)
        missing = "; ".join(mismatch.words for mismatch in generator.mismatches(motion))
        title = f"{prompt} ({motion.duration_s:.1f} s)" + (f" - prompt mismatch: {missing}" if missing else "")
        drawn.append((title, human_figures(motion.joints, arguments.frames)))
    return drawn


def main(arguments: Arguments) -> None:
    """Write the picture."""
    try:
        draw_sheet(strips(arguments), arguments.out)
    except StackError as error:
        raise SystemExit(f"error: {error}") from None


if __name__ == "__main__":
    main(tyro.cli(Arguments, description=__doc__))
