"""What an action is: one record of its motion, its words and what shows it.

The motion is a function that writes keys from a start time on, with declared and checked parameters; the words sample
these parameters and say them; the probe finds the action, with its side, number, direction and extent, in any motion.
"""

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

from generator.corpus.body import SIDES, Side
from generator.corpus.scene import Scene
from generator.corpus.vocabulary.entry import Entry
from generator.probes.spec import Probe
from ros_free_stack.errors import InvalidOption, UnknownName

Part = Literal["arms", "trunk", "whole", "legs"]
AnySide = Literal["left", "right", "both"]


@dataclass(frozen=True)
class Range:
    """Valid values of a numeric parameter."""

    low: float
    high: float


Count = Annotated[int, Range(1, 60)]
Speed = Annotated[float, Range(0.3, 2.5)]
Size = Annotated[float, Range(0.2, 2.0)]
Hold = Annotated[float, Range(0.0, 30.0)]
Angle = Annotated[float, Range(-1080.0, 1080.0)]


def sides(side: AnySide) -> tuple[Side, ...]:
    """The sides that a parameter names."""
    return SIDES if side == "both" else (side,)


@dataclass(frozen=True)
class Action:
    """A named action.

    Attributes:
        name: its name in the catalogue.
        part: what of the body it uses: "arms" may be layered over "legs"; "trunk" and "whole" stand alone.
        perform: writes the action's keys on a scene from a start time (s) on and returns its end (s).
        parameters: annotation of each parameter by name.
        words: how it is spoken of, and how its parameters are drawn.
        probe: what makes a window of motion this action.
    """

    name: str
    part: Part
    perform: Callable[..., float]
    parameters: dict[str, Any]
    words: Entry
    probe: Probe

    def __call__(self, scene: Scene, start: float, **params: Any) -> float:
        """Perform, after checking the parameters.

        Raises:
            InvalidOption: an unknown parameter, or a number out of its range.
            UnknownName: a word that is not among a parameter's choices.
        """
        for name, value in params.items():
            if name not in self.parameters:
                valid = ", ".join(sorted(self.parameters)) or "(none)"
                raise InvalidOption(f"{self.name}({name}=...)", f"no such parameter; valid: {valid}")
            _check(self.name, name, value, self.parameters[name])
        return self.perform(scene, start, **params)


def _check(action: str, name: str, value: Any, kind: Any) -> None:
    where = f"{action}({name}={value!r})"
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            raise UnknownName(f"{name} of {action}", str(value), get_args(kind))
    elif kind is bool:
        if not isinstance(value, bool):
            raise InvalidOption(where, "expected True or False")
    else:
        number, valid = get_args(kind)
        whole = number is not int or (isinstance(value, int) and not isinstance(value, bool))
        if not (whole and isinstance(value, int | float) and math.isfinite(value) and valid.low <= value <= valid.high):
            what = "a whole number" if number is int else "a number"
            raise InvalidOption(where, f"expected {what} from {valid.low:g} to {valid.high:g}")


def action(part: Part, words: Entry, probe: Probe) -> Callable[[Callable[..., float]], Action]:
    """Decorator: make an action of `function(scene, start, *, ...)`, named after it."""

    def record(function: Callable[..., float]) -> Action:
        name, hints = function.__name__, get_type_hints(function, include_extras=True)
        keyword = inspect.Parameter.KEYWORD_ONLY
        names = [n for n, p in inspect.signature(function).parameters.items() if p.kind is keyword]
        parameters = {parameter: hints[parameter] for parameter in names}
        return Action(name, part, function, parameters, replace(words, name=name), replace(probe, action=name))

    return record
