"""Every error that a user can meet, each with one line that says what was wrong and what is valid.

The command line prints `error: <message>` and ends with the class's `exit_code`:
2 bad input or usage, 3 no solution, 4 hardware fault. (An infeasible motion, 3 too, is a result and not an error.)
"""

from collections.abc import Iterable
from pathlib import Path


class StackError(Exception):
    """Base of all errors of this project; `exit_code` is the process's exit status."""

    exit_code = 2


class InvalidMessage(StackError):
    """A message field has the wrong shape, type or values."""

    def __init__(self, message: str, field: str, problem: str) -> None:
        super().__init__(f"{message}.{field}: {problem}")
        self.field = field


class UsageError(StackError):
    """A command line that cannot be read: an unknown command or option, a missing or impossible value."""


class UnknownName(StackError):
    """A name is not among the known ones; the message lists them, the likeliest first."""

    def __init__(self, kind: str, name: str, choices: Iterable[str]) -> None:
        self.choices = tuple(sorted(choices))
        guess = did_you_mean(name, self.choices)
        super().__init__(f"unknown {kind} {name!r}{guess}; valid: {', '.join(self.choices) or '(none)'}")


class InvalidFile(StackError):
    """A file is missing, truncated or not in the format its reader expects."""

    def __init__(self, path: Path | str, problem: str) -> None:
        super().__init__(f"{path}: {problem}")
        self.path = Path(path)


class InvalidOption(StackError):
    """A command-line option or function argument has an unusable value."""

    def __init__(self, option: str, problem: str) -> None:
        super().__init__(f"{option}: {problem}")
        self.option = option


class InvalidPrompt(StackError):
    """The sentence cannot be used: empty, too long, or not English."""

    def __init__(self, problem: str) -> None:
        super().__init__(f"prompt: {problem}")


class OutOfDomain(StackError):
    """The sentence is too far from everything that the model was trained on."""

    def __init__(self, segment: str, nearest: Iterable[str]) -> None:
        self.segment, self.nearest = segment, tuple(nearest)
        super().__init__(
            f"prompt: the model does not know {segment!r}; nearest known actions: "
            f"{'; '.join(self.nearest)} (use --anyway to try all the same)"
        )


class MissingDependency(StackError):
    """A system library or optional package that this command needs is absent."""

    def __init__(self, what: str, remedy: str) -> None:
        super().__init__(f"{what} is missing: {remedy}")


class UnsupportedModel(StackError):
    """A robot model has a part that this project cannot handle."""


class SolverFailed(StackError):
    """A solver ended without a solution, and nothing usable is left in its place.

    `status` is the solver's own word for it.
    """

    exit_code = 3

    def __init__(self, problem: str, status: object) -> None:
        super().__init__(f"{problem} has no solution (solver status: {status})")
        self.status = status


class ModelMismatch(StackError):
    """Two things that must belong to the same robot model or trajectory do not."""


class NoWeights(StackError):
    """Trained weights are missing or belong to another configuration."""


class HardwareFault(StackError):
    """A servo, the bus or the port failed."""

    exit_code = 4


class PortError(HardwareFault):
    """The serial port cannot be opened or went away."""

    def __init__(self, port: str, problem: str) -> None:
        super().__init__(f"port {port}: {problem}")
        self.port = port


class UnsafeCommand(HardwareFault):
    """A command was refused before it could reach a servo."""


class BusFault(HardwareFault):
    """The bus does not carry clean packets: noise, wrong replies, a register that refuses a value."""


class LostServo(HardwareFault):
    """One or more servos do not answer."""

    def __init__(self, servos: Iterable[str], circumstance: str) -> None:
        self.servos = tuple(servos)
        super().__init__(f"no answer from {', '.join(self.servos)} {circumstance}; check power and cables")


class ServoFault(HardwareFault):
    """A servo reports a hardware error, or its temperature, voltage or position left the safe range."""

    def __init__(self, servo: str, problem: str) -> None:
        super().__init__(f"{servo}: {problem}")
        self.servo = servo


class DeadlineFault(HardwareFault):
    """The computer is too slow or too busy to keep the servo cycle."""


def did_you_mean(name: str, choices: Iterable[str]) -> str:
    """`; did you mean ...?` where one of the choices is much like the name, else nothing."""
    from difflib import get_close_matches

    by_lower = {choice.lower(): choice for choice in choices}
    found = get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    return f"; did you mean {by_lower[found[0]]}?" if found else ""
