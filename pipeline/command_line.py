"""The command line: finds the subcommand, fills it from its arguments, and ends every error in one line."""

import importlib
import json
import os
import signal
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, NoReturn

from pipeline.commands import COMMANDS
from ros_free_stack import __version__
from ros_free_stack.errors import StackError, UsageError, did_you_mean

if TYPE_CHECKING:
    from ros_free_stack.console import Command

INTERRUPTED = 130
SCRIPT = "rfs"


def program() -> str:
    """How this process was called, as a person would call it again."""
    called = Path(sys.argv[0])
    as_module = (called.parent.name, called.name) == ("ros_free_stack", "__main__.py")
    return SCRIPT if as_module or called.stem == SCRIPT else "python launch.py"


def main(arguments: Sequence[str]) -> int:
    """Run the command line: 0 done, 2 bad input, 3 infeasible, 4 hardware fault, 5 not as asked, 130 interrupted."""
    if (told := _told(arguments)) is not None:
        print(told)
        return 0
    # PyTorch's threads spin while they wait, which makes it many times slower where cores are shared.
    os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    previous = signal.signal(signal.SIGTERM, _terminate)
    try:
        return parse(*find_command(arguments)).run()
    except StackError as error:
        return _failed(type(error).__name__, _as_called(str(error)), error.exit_code, arguments)
    except ModuleNotFoundError as error:
        return _without(str(error.name), arguments)
    except KeyboardInterrupt:
        return _failed("Interrupted", "interrupted", INTERRUPTED, arguments)
    finally:
        signal.signal(signal.SIGTERM, previous)


def _told(arguments: Sequence[str]) -> str | None:
    """What is told without a subcommand: help, that of a group, the version; None where there is one to run."""
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        return usage()
    if arguments[0] in ("-V", "--version"):
        return f"ros-free-stack {__version__}"
    group = f"{arguments[0]} "
    if list(arguments[1:]) in ([], ["-h"], ["--help"]) and any(name.startswith(group) for name in COMMANDS):
        return usage(prefix=group)
    return None


def usage(prefix: str = "") -> str:
    """The list of subcommands that begin with `prefix`."""
    rows = [f"  {name:17s} {words}" for name, (_, words) in COMMANDS.items() if name.startswith(prefix)]
    lines = [
        f"usage: {program()} COMMAND [options]      (COMMAND --help shows a command's options, --version the version)",
        "",
        *rows,
        "",
        f'example: {program()} run "a person waves with the right hand" --robot op3 --servo sim --out out/',
    ]
    return "\n".join(lines)


def find_command(arguments: Sequence[str]) -> tuple[str, list[str]]:
    """The subcommand that the arguments begin with, and the arguments that are left for it."""
    for words in (2, 1):
        name = " ".join(arguments[:words])
        if name in COMMANDS:
            return name, list(arguments[words:])
    first = arguments[0]
    groups = {name.partition(" ")[0] for name in COMMANDS if " " in name}
    if first in groups:
        inside = [name.partition(" ")[2] for name in COMMANDS if name.startswith(f"{first} ")]
        raise UsageError(
            f"{first} has no {arguments[1]!r}{did_you_mean(arguments[1], inside)}; valid: {', '.join(inside)}"
        )
    if " " in first.strip():
        raise UsageError(f"{first!r} is no command; for a sentence: {program()} run {first!r}")
    guess = did_you_mean(first, [*COMMANDS, *groups])
    raise UsageError(f"unknown command {first!r}{guess} ({program()} --help lists them all)")


def command_class(name: str) -> "type[Command]":
    """The dataclass of a subcommand; imports only the stage that it belongs to."""
    module, _, class_name = COMMANDS[name][0].partition(":")
    found: type[Command] = getattr(importlib.import_module(module), class_name)
    return found


def parse(name: str, arguments: Sequence[str]) -> "Command":
    """The subcommand's dataclass, filled from its arguments.

    Raises:
        UsageError: an option is unknown, lacks its value, or has one that it cannot have.
    """
    import inspect

    import tyro
    from tyro._errors import on_parse_error

    from pipeline.usage_errors import refuse

    found = command_class(name)
    with on_parse_error(lambda event: refuse(event, name, found)):
        return tyro.cli(
            found,
            args=list(arguments),
            prog=f"{program()} {name}",
            description=_as_called(inspect.getdoc(found) or ""),
        )


def _failed(kind: str, message: str, code: int, arguments: Sequence[str]) -> int:
    """Say what was wrong: in one line on stderr, and as an object on stdout for programs that asked for JSON."""
    if "--debug" in arguments:
        traceback.print_exc()
    print(message if code == INTERRUPTED else f"error: {message}", file=sys.stderr, flush=True)
    if "--json" in arguments:
        print(json.dumps({"error": {"type": kind, "message": message, "exit_code": code}}))
    return code


def _without(package: str, arguments: Sequence[str]) -> int:
    """A package is not installed: `doctor` works all the same, everything else ends here."""
    if arguments[0] == "doctor":
        from ros_free_stack.doctor import print_findings

        return print_findings(as_json="--json" in arguments)
    problem = f"the Python package {package} is missing: run make setup; {program()} doctor names all that lack"
    return _failed("MissingDependency", problem, 2, arguments)


def _as_called(text: str) -> str:
    """Words of this program about itself, with the name that it was called by."""
    return text.replace("python launch.py", "launch.py").replace("launch.py", program())


def _terminate(_number: int, _frame: FrameType | None) -> NoReturn:
    """SIGTERM unwinds like Ctrl-C, so that servos stop and temporary files go."""
    raise KeyboardInterrupt


def entry() -> int:
    """What the console script calls."""
    return main(sys.argv[1:])
