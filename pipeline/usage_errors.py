"""What is wrong with the options of a command line, in one line."""

from dataclasses import MISSING, fields
from typing import Any, NoReturn

from tyro import _errors

from ros_free_stack.console import Command
from ros_free_stack.errors import UsageError, did_you_mean


def refuse(event: _errors.ParseErrorEvent, name: str, command: type[Command]) -> NoReturn:
    """Raise the UsageError that a failure of the parser stands for.

    Args:
        event: the failure.
        name: of the subcommand.
        command: its dataclass, whose options are suggested.
    """
    raise UsageError(f"{name}: {_words(event, command)} (launch.py {name} --help shows all options)")


def option_names(command: type[Command]) -> tuple[str, ...]:
    """The flags of a subcommand, those that switch something off included."""
    names: list[str] = []
    for item in fields(command):
        if _is_positional(item.type):
            continue
        flag = item.name.replace("_", "-")
        names += [f"--{flag}", f"--no-{flag}"] if item.default is True else [f"--{flag}"]
    return tuple(names)


def _is_positional(annotation: Any) -> bool:
    import tyro

    markers = getattr(annotation, "__metadata__", ())
    return any(marker is tyro.conf.Positional or "Positional" in repr(marker) for marker in markers)


def _words(event: _errors.ParseErrorEvent, command: type[Command]) -> str:
    match event:
        case _errors.UnrecognizedArgs():
            return _unrecognised(event.tokens, command)
        case _errors.InvalidChoice():
            guess = did_you_mean(event.value, event.choices)
            return f"{_title(event.argument)}: {event.value!r} is not valid{guess}; valid: {', '.join(event.choices)}"
        case _errors.BadValue():
            return f"{_title(event.argument)}: needs a value, expected {event.argument.lowered.metavar}"
        case _errors.InstantiationFailure():
            return _problem(event.message, event.argument)
        case _errors.MissingArgs():
            missing = " and ".join(_title(item.arg) for item in event.missing_arguments)
            return f"{missing} must be given" + (
                f"; {_unrecognised(event.unrecognized_tokens, command)}" if event.unrecognized_tokens else ""
            )
        case _:
            return "these options do not go together"


def _problem(message: str, argument: Any) -> str:
    """What a value lacks; where Python's own conversion failed, what was expected in its place."""
    text = " ".join(message.split())
    if text.startswith(("invalid literal", "could not convert")):
        kind = "a whole number" if "int()" in text else "a number"
        text = f"expected {kind}, found {text.rpartition(': ')[2]}"
    return text if argument is None else f"{_title(argument)}: {text}"


def _unrecognised(tokens: list[str], command: type[Command]) -> str:
    options = [token for token in tokens if token.startswith("-")]
    if options:
        option = options[0].partition("=")[0]
        return f"unknown option {option!r}{did_you_mean(option, option_names(command))}"
    words = " ".join(tokens)
    takes_sentence = any(item.name == "prompt" and item.default is not MISSING for item in fields(command))
    hint = "; put a sentence in quotation marks" if takes_sentence or len(tokens) > 1 else ""
    return f"unexpected {words!r}{hint}"


def _title(argument: Any) -> str:
    if argument.is_positional():
        return str(argument.field.intern_name).replace("_", " ")
    return next((name for name in argument.lowered.name_or_flags if name.startswith("--")), "option")
