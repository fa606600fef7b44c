"""Prompts from a terminal, one after the other, while the models stay in memory."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.run_words import slug
from ros_free_stack.console import say
from ros_free_stack.errors import HardwareFault, StackError

if TYPE_CHECKING:
    from pipeline.run import Ran

QUESTION = "What should the robot do? (an empty line ends) "


def ask(out: Path, run_one: "Callable[[str, Path], Ran]") -> int:
    """Ask for prompts until an empty line or the end of input, and run each in a folder of its own.

    Args:
        out: folder of the run folders.
        run_one: runs a prompt into a folder.

    Returns:
        The exit code of the last prompt, 0 where there was none.

    Raises:
        HardwareFault: a servo failed, which ends the asking.
    """
    code, number = 0, 0
    while prompt := _next():
        number += 1
        try:
            ran = run_one(prompt, out / f"{number}-{slug(prompt)}")
        except HardwareFault:
            raise
        except StackError as error:
            say(f"error: {error}")
            code = error.exit_code
            continue
        code = ran.code
        print(*ran.words, sep="\n", flush=True)
    return code


def _next() -> str:
    """What the person types, "" at the end."""
    import contextlib

    with contextlib.suppress(ImportError):
        import readline  # noqa: F401  # arrow keys and what was typed before
    try:
        return input(QUESTION).strip()
    except EOFError:
        print()
        return ""
