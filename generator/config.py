"""What all generators share: limits, how a stage is trained, and settings as checked dataclasses."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from ros_free_stack.errors import InvalidOption, NoWeights, UnknownName

FEATURES = 263
TEXT_WIDTH = 384
MAX_SEGMENTS = 5
MAX_ACTIONS = 20
MIN_FRAMES, MAX_FRAMES = 40, 196
"""Of a motion at 20 fps, as published (T2M)."""

Config = TypeVar("Config")

SegmentationKind = Literal["uniform", "change-point", "clustering", "exact"]
AlignmentKind = Literal["none", "segment", "batch", "global", "token"]


@dataclass(frozen=True)
class Training:
    """How a stage is trained: AdamW, its schedule, its averages.

    Attributes:
        batch, iterations, learning_rate: the usual.
        warm_up: iterations in which the rate rises to its value.
        schedule: "cosine" lets the rate fall to `final_rate` of itself; "step" multiplies it by `gamma` at each of the
            `milestones`, which are iterations.
        betas, weight_decay: of AdamW.
        clip: greatest norm of the gradient; 0 does not clip.
        ema: decay of the averaged weights that are evaluated and exported; 0 takes the weights themselves.
    """

    batch: int
    iterations: int
    learning_rate: float
    warm_up: int = 200
    schedule: Literal["cosine", "step"] = "cosine"
    final_rate: float = 0.03
    milestones: tuple[int, ...] = ()
    gamma: float = 0.1
    betas: tuple[float, float] = (0.9, 0.99)
    weight_decay: float = 0.01
    clip: float = 1.0
    ema: float = 0.999

    def __post_init__(self) -> None:
        for name in ("batch", "iterations", "learning_rate", "warm_up"):
            if getattr(self, name) <= 0:
                raise InvalidOption(f"training.{name}", f"must be positive, found {getattr(self, name)}")
        if len(self.betas) != 2 or not all(0 <= beta < 1 for beta in self.betas):
            raise InvalidOption("training.betas", f"must be two numbers from 0 to below 1, found {list(self.betas)}")
        if not 0 <= self.ema < 1:
            raise InvalidOption("training.ema", f"must be from 0 to below 1, found {self.ema}")


def to_json(config: Any) -> dict[str, Any]:
    """A config dataclass as plain data."""
    return asdict(config)


def from_json(kind: type[Config], data: dict[str, Any]) -> Config:
    """The config dataclass of that kind, or NoWeights where the data describe another version of it."""
    try:
        return kind(**data)
    except TypeError as error:
        raise NoWeights(f"{kind.__name__} was saved by another version of this program ({error})") from None


def checked(kind: type[Config], data: Mapping[str, Any], where: str) -> Config:
    """The config dataclass of that kind from settings that a person wrote.

    Raises:
        UnknownName: there is no such setting.
        InvalidOption: a setting is missing or of the wrong type.
    """
    hints = get_type_hints(kind)
    for name in data:
        if name not in hints:
            raise UnknownName(f"setting of {where}", name, hints)
    values = {name: _as(hints[name], value, f"{where}.{name}") for name, value in data.items()}
    try:
        return kind(**values)
    except TypeError:
        missing = [field.name for field in fields(kind) if field.name not in data]  # pyright: ignore[reportArgumentType]
        raise InvalidOption(where, f"lacks a setting, one of {', '.join(missing)}") from None


def _as(kind: Any, value: Any, where: str) -> Any:
    """The value as a field of that type takes it: whole numbers are floats too, lists are tuples."""
    if get_origin(kind) is Literal:
        if value not in get_args(kind):
            raise UnknownName(where, str(value), map(str, get_args(kind)))
        return value
    if get_origin(kind) is tuple:
        if isinstance(value, list | tuple):
            return tuple(_as(get_args(kind)[0], item, where) for item in value)
        raise InvalidOption(where, f"expected a list, found {value!r}")
    if kind is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
        raise InvalidOption(where, f"expected a value of type {kind.__name__}, found {value!r}")
    return value
