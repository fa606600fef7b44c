"""What every subcommand shares: `--json` and `--debug`, words on stderr, one JSON object on stdout, progress bars."""

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Annotated, Any, TypeVar

import tyro

Item = TypeVar("Item")

WIDE = 200
"""Columns of a table that goes into a file or a pipe."""


@dataclass(frozen=True, kw_only=True)
class Command:
    """Base of all subcommands: a dataclass whose fields are the options and whose `run` does the work."""

    json: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Print one JSON object on stdout; words and progress go to stderr."""
    debug: Annotated[bool, tyro.conf.FlagCreatePairsOff] = False
    """Show the traceback of an error."""

    def run(self) -> int:
        """Do the work and return the exit code: 0 done, 3 infeasible; bad input raises a StackError."""
        raise NotImplementedError

    def report(self, result: dict[str, Any], *lines: str) -> None:
        """Print the result: as JSON with `--json`, else the given lines of words."""
        if self.json:
            print(json.dumps(result, indent=2, default=str))
        else:
            for line in lines:
                print(line)


def say(message: str) -> None:
    """One line for a person, on stderr so that stdout stays clean."""
    print(message, file=sys.stderr, flush=True)


def time_left(work: str, every_s: float = 5.0) -> Callable[[float], None]:
    """What is to be told the share of a work that is done; says every few seconds how long it will still take."""
    started = last = perf_counter()

    def tell(share: float) -> None:
        nonlocal last
        now = perf_counter()
        if 0 < share < 1 and now - last >= every_s:
            last = now
            minutes, seconds = divmod(round((now - started) * (1 - share) / share), 60)
            left = f"{minutes} min {seconds} s" if minutes else f"{seconds} s"
            say(f"{work}: {100 * share:.0f} % done, about {left} left")

    return tell


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> None:
    """Print a table on stdout: fitted to a terminal, elsewhere as wide as its words."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    table = Table(*heads, box=box.SIMPLE_HEAD, pad_edge=False)
    for row in rows:
        table.add_row(*row)
    terminal = sys.stdout.isatty()
    Console(width=None if terminal else WIDE, highlight=False, markup=False, emoji=False).print(table)


def progress(items: Iterable[Item], description: str, total: int | None = None) -> Iterator[Item]:
    """Iterate with a progress bar on stderr; silent where stderr is no terminal."""
    from rich.console import Console
    from rich.progress import track

    console = Console(stderr=True)
    yield from track(items, description, total=total, console=console, disable=not console.is_terminal, transient=True)
